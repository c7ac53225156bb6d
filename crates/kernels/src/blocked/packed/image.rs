//! Images of numbers of fewer bits.

use crate::blocked::image::{BEYOND, Image, Line};
use crate::simd::LANES;
use crate::simd::dots::{Bf16, Stored};

/// What a byte stands for: `(byte - zero) * step`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// From a value to the next; positive.
    pub step: f32,
    /// The byte that stands for 0.
    pub zero: u8,
}

impl Scale {
    /// The finest one for values from `low` to `high`, and for 0.
    pub fn of(low: f32, high: f32) -> Self {
        let (low, high) = (low.min(0.0), high.max(0.0));
        // Any step will do for values that are all 0.
        let step = if high > low { (high - low) / 255.0 } else { 1.0 };
        Self { step, zero: (-low / step).round_ties_even() as u8 }
    }

    /// The byte that is the nearest to a value.
    pub(super) fn byte(self, value: f32) -> u8 {
        (value / self.step + f32::from(self.zero)).round_ties_even() as u8
    }
}

/// How the numbers of an image are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Storage {
    /// In 16 bits, the upper halves of `f32`.
    Bf16,
    /// In 8 bits.
    Byte(Scale),
}

/// An image `[channels / 16][height][width][16]` with a border that stands for zeros.
#[derive(Debug, Clone)]
pub struct Packed {
    channels: usize,
    height: usize,
    width: usize,
    border: usize,
    storage: Storage,
    lines: Vec<Line>,
}

impl Packed {
    /// An image of zeros with a border of so many pixels.
    pub fn zeros([channels, height, width]: [usize; 3], border: usize, storage: Storage) -> Self {
        let mut image = Self { channels, height, width, border, storage, lines: Vec::new() };
        let bytes = image.blocks() * image.block_pitch() * image.pixel_bytes();
        let fill = match storage {
            Storage::Bf16 => 0,
            Storage::Byte(scale) => scale.zero,
        };
        let fill = f32::from_ne_bytes([fill; 4]);
        image.lines = vec![Line([fill; LANES]); bytes.div_ceil(size_of::<Line>())];
        image
    }

    /// Channels, rows and columns.
    pub fn size(&self) -> [usize; 3] {
        [self.channels, self.height, self.width]
    }

    /// Pixels of zeros on each side.
    pub fn border(&self) -> usize {
        self.border
    }

    /// How its numbers are kept.
    pub fn storage(&self) -> Storage {
        self.storage
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.lines.as_slice())
    }

    pub(super) fn blocks(&self) -> usize {
        self.channels.div_ceil(LANES)
    }

    /// Pixels from a row to the next.
    pub(super) fn row_pitch(&self) -> usize {
        self.width + 2 * self.border + BEYOND
    }

    /// Pixels from a block of channels to the next.
    pub(super) fn block_pitch(&self) -> usize {
        (self.height + 2 * self.border + BEYOND) * self.row_pitch()
    }

    fn pixel_bytes(&self) -> usize {
        match self.storage {
            Storage::Bf16 => LANES * 2,
            Storage::Byte(_) => LANES,
        }
    }

    /// Where the pixel at row 0 and column 0 of the first block is, in pixels.
    fn origin(&self) -> usize {
        self.border * (self.row_pitch() + 1)
    }

    /// The sixteen channels of a pixel `padding` above and to the left of row `y` and column `x`.
    ///
    /// # Panics
    /// If that is outside.
    pub(super) fn tap<S: Stored>(
        &self,
        block: usize,
        y: usize,
        x: usize,
        padding: usize,
    ) -> *const S {
        assert_eq!(size_of::<S>() * LANES, self.pixel_bytes(), "numbers of this size");
        let at = block * self.block_pitch() + self.origin() + y * self.row_pitch() + x;
        let at = at - padding * (self.row_pitch() + 1);
        assert!((at + 1) * self.pixel_bytes() <= self.bytes(), "a pixel inside");
        self.lines.as_ptr().cast::<S>().wrapping_add(at * LANES)
    }

    /// The first pixel, through which all are written.
    pub(super) fn first_mut<S: Stored>(&mut self) -> *mut S {
        assert_eq!(size_of::<S>() * LANES, self.pixel_bytes(), "numbers of this size");
        let origin = self.origin();
        self.lines.as_mut_ptr().cast::<S>().wrapping_add(origin * LANES)
    }

    /// Fills it from an image of the same size.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn read(&mut self, image: &Image) {
        assert_eq!([image.channels(), image.height(), image.width()], self.size(), "sizes");
        match self.storage {
            Storage::Bf16 => self.fill(image, Bf16::nearest),
            Storage::Byte(scale) => self.fill(image, |value| scale.byte(value)),
        }
    }

    fn fill<S: Stored>(&mut self, image: &Image, of: impl Fn(f32) -> S) {
        let (row_pitch, block_pitch) = (self.row_pitch(), self.block_pitch());
        let first: *mut S = self.first_mut();
        for block in 0..self.blocks() {
            for y in 0..self.height {
                let from = image.place(block * LANES, y, 0).0;
                let row = &image.lines()[from..from + self.width];
                for (x, line) in row.iter().enumerate() {
                    let at = (block * block_pitch + y * row_pitch + x) * LANES;
                    // SAFETY: the pixel is inside the image, and of this size.
                    unsafe { first.add(at).cast::<[S; LANES]>().write(line.0.map(&of)) };
                }
            }
        }
    }

    /// Writes its numbers to an image of the same size.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn write(&self, image: &mut Image) {
        assert_eq!([image.channels(), image.height(), image.width()], self.size(), "sizes");
        match self.storage {
            Storage::Bf16 => self.give::<Bf16>(image, Bf16::value),
            Storage::Byte(Scale { step, zero }) => {
                self.give::<u8>(image, |byte| (f32::from(byte) - f32::from(zero)) * step);
            }
        }
    }

    fn give<S: Stored>(&self, image: &mut Image, of: impl Fn(S) -> f32) {
        for block in 0..self.blocks() {
            // Channels that fill the last block up stay zero.
            let channels = LANES.min(self.channels - block * LANES);
            for y in 0..self.height {
                let to = image.place(block * LANES, y, 0).0;
                for (x, line) in image.lines_mut()[to..to + self.width].iter_mut().enumerate() {
                    // SAFETY: the pixel is inside the image, and of this size.
                    let pixel =
                        unsafe { self.tap::<S>(block, y, x, 0).cast::<[S; LANES]>().read() };
                    for (to, from) in line.0[..channels].iter_mut().zip(pixel) {
                        *to = of(from);
                    }
                }
            }
        }
    }
}

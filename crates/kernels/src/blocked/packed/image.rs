//! Images of numbers of fewer bits.

use crate::blocked::image::{BEYOND, Line};
use crate::simd::LANES;
use crate::simd::dots::Stored;

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
}

/// How the numbers of an image are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Storage {
    /// In 16 bits, the upper halves of `f32`.
    Bf16,
    /// In 8 bits.
    Byte(Scale),
}

impl Storage {
    /// Whether an image of one may become one of the other.
    pub fn is_alike(self, other: Self) -> bool {
        match (self, other) {
            (Self::Bf16, Self::Bf16) => true,
            (Self::Byte(one), Self::Byte(other)) => one.zero == other.zero,
            _ => false,
        }
    }
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

    /// From now on its numbers stand for something else; its border still for zeros.
    ///
    /// # Panics
    /// If they have other bits, or another one stands for zero.
    pub fn keep_as(&mut self, storage: Storage) {
        assert!(self.storage.is_alike(storage), "numbers of as many bits, and the same zero");
        self.storage = storage;
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

    /// The bytes of the first pixel.
    pub(super) fn first(&self) -> *const u8 {
        self.lines.as_ptr().cast::<u8>().wrapping_add(self.origin() * self.pixel_bytes())
    }

    /// As [`first`](Self::first); all are written through it.
    pub(super) fn first_mut(&mut self) -> *mut u8 {
        let first = self.origin() * self.pixel_bytes();
        self.lines.as_mut_ptr().cast::<u8>().wrapping_add(first)
    }
}

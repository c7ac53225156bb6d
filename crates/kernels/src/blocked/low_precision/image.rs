//! Images of bf16 or quantised uint8.

use crate::blocked::image::{Line, OVERREAD};
use crate::blocked::lines::Lines;
use crate::simd::LANES;
use crate::simd::dots::{Bf16, ReducedPrecision};

/// Largest quantised value.
pub(super) const MAX_UINT8: f32 = 255.0;

/// Affine quantisation to 8 bits: a byte `q` means `(q - zero_point) * scale`, as in PyTorch and
/// ONNX.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuantizationParams {
    /// Difference between neighbouring quantised values; positive.
    pub scale: f32,
    /// The byte that means 0, which is exact.
    pub zero_point: u8,
}

impl QuantizationParams {
    /// The finest parameters that cover 0 and the values from `min` to `max`.
    pub fn from_range(min: f32, max: f32) -> Self {
        let (min, max) = (min.min(0.0), max.max(0.0));
        // Values that are all 0 are exact at any scale.
        let scale = if max > min { (max - min) / MAX_UINT8 } else { 1.0 };
        Self { scale, zero_point: (-min / scale).round_ties_even() as u8 }
    }
}

/// Element type narrower than f32.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LowPrecisionType {
    /// bfloat16: the upper 16 bits of an f32, rounded to nearest.
    Bf16,
    /// Quantised 8-bit integers.
    Uint8(QuantizationParams),
}

impl LowPrecisionType {
    /// Whether an image of one type is valid with the other: 0 has the same bits in both, so that
    /// the border stays zero.
    pub fn is_compatible_with(self, other: Self) -> bool {
        match (self, other) {
            (Self::Bf16, Self::Bf16) => true,
            (Self::Uint8(one), Self::Uint8(other)) => one.zero_point == other.zero_point,
            _ => false,
        }
    }
}

/// An image `[channels / 16][height][width][16]` (nChw16c, batch 1) of bf16 or uint8, with a border
/// of elements that mean zero.
#[derive(Debug, Clone)]
pub struct LowPrecisionImage {
    channels: usize,
    height: usize,
    width: usize,
    border: usize,
    element_type: LowPrecisionType,
    lines: Lines,
}

/// Destination view of an image of bf16. Pitches are in elements.
#[derive(Clone, Copy)]
pub(in crate::blocked) struct Bf16Dst {
    pub(in crate::blocked) pixels: *mut Bf16,
    pub(in crate::blocked) row_pitch: usize,
    pub(in crate::blocked) block_pitch: usize,
}

// SAFETY: each part of a parallel region writes its own pixels through it.
unsafe impl Send for Bf16Dst {}
// SAFETY: as above.
unsafe impl Sync for Bf16Dst {}

impl LowPrecisionImage {
    /// A zero image with `border` pixels on each side.
    pub fn zeros(
        [channels, height, width]: [usize; 3],
        border: usize,
        element_type: LowPrecisionType,
    ) -> Self {
        let mut image =
            Self { channels, height, width, border, element_type, lines: Lines::default() };
        let bytes = image.blocks() * image.block_pitch() * image.pixel_bytes();
        let fill = match element_type {
            LowPrecisionType::Bf16 => 0,
            // A byte of zero would be a negative value in the border, which convolutions read.
            LowPrecisionType::Uint8(params) => params.zero_point,
        };
        let fill = f32::from_ne_bytes([fill; 4]);
        image.lines = Lines::unspecified(bytes.div_ceil(size_of::<Line>()));
        image.lines.fill(Line([fill; LANES]));
        image
    }

    /// Channels, height and width.
    pub fn size(&self) -> [usize; 3] {
        [self.channels, self.height, self.width]
    }

    /// Zero pixels on each side.
    pub fn border(&self) -> usize {
        self.border
    }

    /// Type of the elements.
    pub fn element_type(&self) -> LowPrecisionType {
        self.element_type
    }

    /// Changes the meaning of the elements without changing their bits, so that a buffer can be
    /// reused for another activation.
    ///
    /// # Panics
    /// If the types are not [compatible](LowPrecisionType::is_compatible_with).
    pub fn reinterpret_as(&mut self, element_type: LowPrecisionType) {
        assert!(
            self.element_type.is_compatible_with(element_type),
            "elements of as many bits, and the same zero point"
        );
        self.element_type = element_type;
    }

    /// Memory of the image in bytes, its border included.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.lines[..])
    }

    /// Number of channel blocks.
    pub(super) fn blocks(&self) -> usize {
        self.channels.div_ceil(LANES)
    }

    /// Pixels from a row to the next.
    pub(super) fn row_pitch(&self) -> usize {
        self.width + 2 * self.border + OVERREAD
    }

    /// Pixels from a block of channels to the next.
    pub(super) fn block_pitch(&self) -> usize {
        (self.height + 2 * self.border + OVERREAD) * self.row_pitch()
    }

    /// Bytes of a block of a pixel.
    fn pixel_bytes(&self) -> usize {
        match self.element_type {
            LowPrecisionType::Bf16 => LANES * 2,
            LowPrecisionType::Uint8(_) => LANES,
        }
    }

    /// Index of the pixel at row 0 and column 0 of the first block.
    fn origin(&self) -> usize {
        self.border * (self.row_pitch() + 1)
    }

    /// Pointer to a block of the pixel `padding` above and to the left of row `y` and column `x`:
    /// the first tap of the kernel's window there.
    ///
    /// # Panics
    /// If that pixel is outside of the image and its border, or the elements are not of type `S`.
    pub(super) fn tap<S: ReducedPrecision>(
        &self,
        block: usize,
        y: usize,
        x: usize,
        padding: usize,
    ) -> *const S {
        assert_eq!(size_of::<S>() * LANES, self.pixel_bytes(), "elements of this size");
        let at = block * self.block_pitch() + self.origin() + y * self.row_pitch() + x;
        let at = at - padding * (self.row_pitch() + 1);
        assert!((at + 1) * self.pixel_bytes() <= self.bytes(), "a pixel inside");
        self.lines.as_ptr().cast::<S>().wrapping_add(at * LANES)
    }

    /// Pointer to the first pixel.
    pub(super) fn first(&self) -> *const u8 {
        self.lines.as_ptr().cast::<u8>().wrapping_add(self.origin() * self.pixel_bytes())
    }

    /// Destination view of bf16.
    ///
    /// # Panics
    /// If the elements are others.
    pub(in crate::blocked) fn bf16_dst(&mut self) -> Bf16Dst {
        assert_eq!(self.element_type(), LowPrecisionType::Bf16, "element type");
        let [row_pitch, block_pitch] =
            [self.row_pitch(), self.block_pitch()].map(|pixels| pixels * LANES);
        Bf16Dst { pixels: self.first_mut().cast(), row_pitch, block_pitch }
    }

    /// Pointer to the first pixel, valid for writes to the whole image from there on.
    pub(super) fn first_mut(&mut self) -> *mut u8 {
        let first = self.origin() * self.pixel_bytes();
        self.lines.as_mut_ptr().cast::<u8>().wrapping_add(first)
    }
}

//! References to images of any element type, and raw views that convert elements to and from f32.

use super::image::{LowPrecisionImage, LowPrecisionType, MAX_UINT8, QuantizationParams};
use crate::blocked::image::Image;
use crate::blocked::tile::Activation;
use crate::simd::dots::{Bf16, ReducedPrecision};
use crate::simd::{LANES, Lanes};

/// Reference to an image of any element type.
#[derive(Debug, Clone, Copy)]
pub enum TensorView<'a> {
    /// f32.
    F32(&'a Image),
    /// bf16 or uint8.
    LowPrecision(&'a LowPrecisionImage),
}

/// Mutable reference to an image of any element type.
#[derive(Debug)]
pub enum TensorViewMut<'a> {
    /// f32.
    F32(&'a mut Image),
    /// bf16 or uint8.
    LowPrecision(&'a mut LowPrecisionImage),
}

impl TensorView<'_> {
    /// Channels, height and width.
    pub fn size(&self) -> [usize; 3] {
        match self {
            Self::F32(image) => [image.channels(), image.height(), image.width()],
            Self::LowPrecision(image) => image.size(),
        }
    }

    /// Source view.
    pub(super) fn src(&self) -> SrcView {
        match self {
            Self::F32(image) => SrcView {
                pixels: image.tap(0, 0, 0, 0).cast(),
                element_type: ElementType::F32,
                row_pitch: image.row_pitch() * LANES,
                block_pitch: image.block_pitch() * LANES,
                // Scale and zero point that leave a value as it is.
                dequantization: [1.0, 0.0],
            },
            Self::LowPrecision(image) => SrcView {
                pixels: image.first(),
                element_type: ElementType::from_low_precision(image.element_type()),
                row_pitch: image.row_pitch() * LANES,
                block_pitch: image.block_pitch() * LANES,
                dequantization: match image.element_type() {
                    LowPrecisionType::Bf16 => [1.0, 0.0],
                    LowPrecisionType::Uint8(QuantizationParams { scale, zero_point }) => {
                        [scale, f32::from(zero_point)]
                    }
                },
            },
        }
    }
}

impl TensorViewMut<'_> {
    /// Channels, height and width.
    pub fn size(&self) -> [usize; 3] {
        match self {
            Self::F32(image) => [image.channels(), image.height(), image.width()],
            Self::LowPrecision(image) => image.size(),
        }
    }

    /// Destination view.
    pub(in crate::blocked) fn dst(&mut self) -> DstView {
        match self {
            Self::F32(image) => DstView {
                pixels: image.first_mut().cast(),
                element_type: ElementType::F32,
                row_pitch: image.row_pitch() * LANES,
                block_pitch: image.block_pitch() * LANES,
                quantization: [1.0, 0.0],
            },
            Self::LowPrecision(image) => DstView {
                pixels: image.first_mut(),
                element_type: ElementType::from_low_precision(image.element_type()),
                row_pitch: image.row_pitch() * LANES,
                block_pitch: image.block_pitch() * LANES,
                quantization: match image.element_type() {
                    LowPrecisionType::Bf16 => [1.0, 0.0],
                    LowPrecisionType::Uint8(QuantizationParams { scale, zero_point }) => {
                        // Stores multiply, since a division takes several times as long.
                        [1.0 / scale, f32::from(zero_point)]
                    }
                },
            },
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ElementType {
    F32,
    Bf16,
    Uint8,
}

impl ElementType {
    fn from_low_precision(low_precision: LowPrecisionType) -> Self {
        match low_precision {
            LowPrecisionType::Bf16 => Self::Bf16,
            LowPrecisionType::Uint8(_) => Self::Uint8,
        }
    }

    fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::Bf16 => 2,
            Self::Uint8 => 1,
        }
    }
}

/// Source view of an image: a pointer with strides, from which elements are loaded as f32. Pitches
/// are in elements.
#[derive(Clone, Copy)]
pub(super) struct SrcView {
    pixels: *const u8,
    element_type: ElementType,
    row_pitch: usize,
    block_pitch: usize,
    /// Scale and zero point of uint8. The zero point is subtracted first: zero stays exact.
    dequantization: [f32; 2],
}

// SAFETY: an image that somebody holds a reference to; it is only read.
unsafe impl Send for SrcView {}
// SAFETY: as above.
unsafe impl Sync for SrcView {}

impl SrcView {
    /// Offset of the first pixel of a row of a block, in elements.
    pub(super) fn row_offset(&self, block: usize, y: usize) -> usize {
        block * self.block_pitch + y * self.row_pitch
    }

    /// Loads sixteen elements as f32.
    ///
    /// # Safety
    /// They are inside, and the processor has the instructions of `V`.
    #[inline(always)]
    pub(super) unsafe fn load<V: Lanes>(&self, at: usize) -> V {
        // SAFETY: the caller's.
        unsafe {
            let from = self.pixels.add(at * self.element_type.bytes());
            match self.element_type {
                ElementType::F32 => V::load(from.cast()),
                ElementType::Bf16 => Bf16::load(from.cast()),
                ElementType::Uint8 => {
                    let [scale, zero_point] = self.dequantization.map(|value| V::splat(value));
                    u8::load::<V>(from).sub(zero_point).mul(scale)
                }
            }
        }
    }
}

/// Destination view of an image: a pointer with strides, to which f32 values are stored as
/// elements. Pitches are in elements.
#[derive(Clone, Copy)]
pub(in crate::blocked) struct DstView {
    pixels: *mut u8,
    element_type: ElementType,
    row_pitch: usize,
    block_pitch: usize,
    /// Reciprocal scale and zero point of uint8.
    quantization: [f32; 2],
}

// SAFETY: each part of a parallel region writes its own pixels through it.
unsafe impl Send for DstView {}
// SAFETY: as above.
unsafe impl Sync for DstView {}

impl DstView {
    /// Offset of the first pixel of a row of a block, in elements.
    pub(in crate::blocked) fn row_offset(&self, block: usize, y: usize) -> usize {
        block * self.block_pitch + y * self.row_pitch
    }

    /// Stores sixteen values.
    ///
    /// # Safety
    /// There is room for them, nobody else writes there, and the processor has the instructions of
    /// `V`.
    #[inline(always)]
    pub(in crate::blocked) unsafe fn store<V: Lanes>(&self, value: V, at: usize) {
        // SAFETY: the caller's.
        unsafe {
            let to = self.pixels.add(at * self.element_type.bytes());
            match self.element_type {
                ElementType::F32 => value.store(to.cast()),
                ElementType::Bf16 => Bf16::store(value, to.cast()),
                ElementType::Uint8 => {
                    let [inverse_scale, zero_point] =
                        self.quantization.map(|value| V::splat(value));
                    u8::store(value.mul_add(inverse_scale, zero_point), to);
                }
            }
        }
    }

    /// View that requantises integer sums and applies `activation` at once, if the elements are
    /// uint8.
    #[inline(always)]
    pub(super) fn requantizing(&self, activation: Activation) -> Option<RequantizingDst> {
        let [inverse_scale, zero_point] = self.quantization;
        (self.element_type == ElementType::Uint8).then(|| {
            // The activation clamps values to [0, 6], which are bytes too: one clamp does both.
            let low = if activation == Activation::Identity { 0.0 } else { zero_point };
            let is_clipped = activation == Activation::Relu6;
            let high =
                if is_clipped { 6.0_f32.mul_add(inverse_scale, zero_point) } else { MAX_UINT8 };
            RequantizingDst { pixels: self.pixels, inverse_scale, zero_point, low, high }
        })
    }

    /// Stores the first `count` of sixteen values, each to one channel of a pixel of its own.
    ///
    /// # Safety
    /// As [`store`](Self::store), for one channel of `count` neighbouring pixels from `at` on.
    #[inline(always)]
    pub(in crate::blocked) unsafe fn scatter<V: Lanes>(&self, value: V, at: usize, count: usize) {
        // SAFETY: the caller's.
        unsafe {
            match self.element_type {
                ElementType::F32 => {
                    let to = self.pixels.cast::<f32>().add(at);
                    let values = value.to_array();
                    for (pixel, value) in values[..count].iter().enumerate() {
                        to.add(pixel * LANES).write(*value);
                    }
                }
                ElementType::Bf16 => {
                    let (to, mut halves) = (self.pixels.cast::<Bf16>().add(at), [Bf16(0); LANES]);
                    Bf16::store(value, halves.as_mut_ptr());
                    for (pixel, half) in halves[..count].iter().enumerate() {
                        to.add(pixel * LANES).write(*half);
                    }
                }
                ElementType::Uint8 => {
                    let (to, mut bytes) = (self.pixels.add(at), [0; LANES]);
                    let [inverse_scale, zero_point] =
                        self.quantization.map(|value| V::splat(value));
                    u8::store(value.mul_add(inverse_scale, zero_point), bytes.as_mut_ptr());
                    for (pixel, byte) in bytes[..count].iter().enumerate() {
                        to.add(pixel * LANES).write(*byte);
                    }
                }
            }
        }
    }
}

/// Destination view of uint8 that requantises: the scale of the bytes is folded into the scale and
/// bias of the sums, and the activation into the bounds of the clamp.
#[derive(Clone, Copy)]
pub(super) struct RequantizingDst {
    pixels: *mut u8,
    inverse_scale: f32,
    zero_point: f32,
    /// Bounds of the bytes.
    low: f32,
    high: f32,
}

impl RequantizingDst {
    /// Folds the quantisation into a scale and bias of sums, which then yield bytes.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    #[inline(always)]
    pub(super) unsafe fn fold<V: Lanes>(&self, scale: V, bias: V) -> [V; 2] {
        // SAFETY: the caller's.
        unsafe {
            let inverse_scale = V::splat(self.inverse_scale);
            [scale.mul(inverse_scale), bias.mul_add(inverse_scale, V::splat(self.zero_point))]
        }
    }

    /// Stores sixteen sums, with a scale and bias from [`fold`](Self::fold).
    ///
    /// # Safety
    /// As of [`DstView::store`].
    #[inline(always)]
    pub(super) unsafe fn store<V: Lanes>(&self, sum: V, [scale, bias]: [V; 2], at: usize) {
        // SAFETY: the caller's.
        unsafe {
            let value = sum.mul_add(scale, bias).max(V::splat(self.low));
            let value = value.min(V::splat(self.high));
            value.store_nonnegative_u8(self.pixels.add(at));
        }
    }
}

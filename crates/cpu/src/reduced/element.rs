//! Elements of 16 and 8 bits: how tensors of reduced precision are stored.

use crate::lanes16::{LANES_16, Lanes16};

/// An element type of reduced precision.
///
/// Tensors are stored as [`Bf16`], or as bytes with a scale and a zero point.
pub trait ReducedPrecision: Copy + Send + Sync + 'static {
    /// Weights that are multiplied with it.
    type Weight: Copy;

    /// The element as `f32`, before scale and zero point.
    fn value(self) -> f32;

    /// Loads 16 elements.
    ///
    /// # Safety
    /// The processor has the instructions of `V`; 16 elements are at `from`.
    unsafe fn load<V: Lanes16>(from: *const Self) -> V;

    /// Loads 16 weights.
    ///
    /// # Safety
    /// The processor has the instructions of `V`; 16 weights are at `from`.
    unsafe fn load_weights<V: Lanes16>(from: *const Self::Weight) -> V;

    /// Rounds 16 values to the nearest elements.
    ///
    /// # Safety
    /// The processor has the instructions of `V`; there is room for 16 elements at `to`.
    unsafe fn store<V: Lanes16>(values: V, to: *mut Self);
}

/// bfloat16: the upper half of an `f32`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub struct Bf16(pub u16);

impl Bf16 {
    /// The nearest bfloat16 value, ties to even.
    ///
    /// ```
    /// use evpose_cpu::{Bf16, ReducedPrecision as _};
    ///
    /// assert_eq!(Bf16::nearest(1.0), Bf16(0x3F80));
    /// assert_eq!(Bf16::nearest(3.141).value(), 3.140625);
    /// ```
    #[inline]
    pub fn nearest(value: f32) -> Self {
        let bits = value.to_bits();
        Self((bits.wrapping_add(0x7FFF + (bits >> 16 & 1)) >> 16) as u16)
    }
}

impl ReducedPrecision for Bf16 {
    type Weight = Self;

    #[inline(always)]
    fn value(self) -> f32 {
        f32::from_bits(u32::from(self.0) << 16)
    }

    #[inline(always)]
    unsafe fn load<V: Lanes16>(from: *const Self) -> V {
        // SAFETY: the caller's.
        unsafe { V::load_bf16(from.cast()) }
    }

    #[inline(always)]
    unsafe fn load_weights<V: Lanes16>(from: *const Self) -> V {
        // SAFETY: the caller's.
        unsafe { V::load_bf16(from.cast()) }
    }

    #[inline(always)]
    unsafe fn store<V: Lanes16>(values: V, to: *mut Self) {
        // SAFETY: the caller's.
        unsafe { values.store_bf16(to.cast()) }
    }
}

impl ReducedPrecision for u8 {
    type Weight = i8;

    #[inline(always)]
    fn value(self) -> f32 {
        f32::from(self)
    }

    #[inline(always)]
    unsafe fn load<V: Lanes16>(from: *const Self) -> V {
        // SAFETY: the caller's.
        unsafe { V::load_u8(from) }
    }

    #[inline(always)]
    unsafe fn load_weights<V: Lanes16>(from: *const i8) -> V {
        // SAFETY: the caller's.
        unsafe { V::load_i8(from) }
    }

    #[inline(always)]
    unsafe fn store<V: Lanes16>(values: V, to: *mut Self) {
        // SAFETY: the caller's.
        unsafe { values.store_u8(to) }
    }
}

/// Bytes that the weights of 16 output channels take, for `depth` input channels that are
/// multiplied at once.
pub const fn weight_vector_bytes<S: ReducedPrecision>(depth: usize) -> usize {
    LANES_16 * depth * size_of::<S::Weight>()
}

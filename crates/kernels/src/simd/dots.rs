//! Sums of products of numbers of fewer bits.
//!
//! Images and weights are kept in 16 bits ([`Bf16`]: the upper half of an `f32`) or 8 (a step and a
//! zero, see [`QuantizationParams`](crate::blocked::QuantizationParams)). Processors with
//! instructions for it multiply and add two or four neighbouring channels at once; elsewhere
//! numbers are widened to `f32` on their way.

use std::marker::PhantomData;

use super::{LANES, Lanes};

/// How the numbers of an image are kept.
pub(crate) trait Stored: Copy + Send + Sync + 'static {
    /// Weights that go with them.
    type Weight: Copy;

    /// The number.
    fn value(self) -> f32;

    /// # Safety
    /// The processor has the instructions of `V`; sixteen are at `from`.
    unsafe fn load<V: Lanes>(from: *const Self) -> V;

    /// # Safety
    /// The processor has the instructions of `V`; sixteen are at `from`.
    unsafe fn load_weights<V: Lanes>(from: *const Self::Weight) -> V;

    /// Rounds to the nearest.
    ///
    /// # Safety
    /// The processor has the instructions of `V`; there is room for sixteen at `to`.
    unsafe fn store<V: Lanes>(values: V, to: *mut Self);
}

/// The upper half of an `f32`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct Bf16(pub(crate) u16);

impl Bf16 {
    /// The nearest; of two that are as near the even one.
    pub(crate) fn nearest(value: f32) -> Self {
        let bits = value.to_bits();
        Self((bits.wrapping_add(0x7FFF + (bits >> 16 & 1)) >> 16) as u16)
    }
}

impl Stored for Bf16 {
    type Weight = Self;

    #[inline(always)]
    fn value(self) -> f32 {
        f32::from_bits(u32::from(self.0) << 16)
    }

    #[inline(always)]
    unsafe fn load<V: Lanes>(from: *const Self) -> V {
        // SAFETY: the caller's.
        unsafe { V::load_halves(from.cast()) }
    }

    #[inline(always)]
    unsafe fn load_weights<V: Lanes>(from: *const Self) -> V {
        // SAFETY: the caller's.
        unsafe { V::load_halves(from.cast()) }
    }

    #[inline(always)]
    unsafe fn store<V: Lanes>(values: V, to: *mut Self) {
        // SAFETY: the caller's.
        unsafe { values.store_halves(to.cast()) }
    }
}

impl Stored for u8 {
    type Weight = i8;

    #[inline(always)]
    fn value(self) -> f32 {
        f32::from(self)
    }

    #[inline(always)]
    unsafe fn load<V: Lanes>(from: *const Self) -> V {
        // SAFETY: the caller's.
        unsafe { V::load_bytes(from) }
    }

    #[inline(always)]
    unsafe fn load_weights<V: Lanes>(from: *const i8) -> V {
        // SAFETY: the caller's.
        unsafe { V::load_signed_bytes(from) }
    }

    #[inline(always)]
    unsafe fn store<V: Lanes>(values: V, to: *mut Self) {
        // SAFETY: the caller's.
        unsafe { values.store_bytes(to) }
    }
}

/// Sixteen sums, and how products of neighbouring channels are added to them.
///
/// # Safety
/// Every method requires that the processor has the instructions of the type, and that what it
/// reads is there.
pub(crate) trait Dots {
    /// How images are kept.
    type Stored: Stored;
    /// For what is done to whole sums.
    type Lanes: Lanes;
    /// Sixteen sums.
    type Sums: Copy;
    /// [`PER`](Self::PER) weights for each of sixteen sums.
    type Weights: Copy;
    /// [`PER`](Self::PER) neighbouring channels of a pixel, for every sum.
    type Values: Copy;
    /// Neighbouring channels that are added at once.
    const PER: usize;
    /// Pixels of a tile of one and of two blocks of channels whose sums stay in registers.
    const TILE: [usize; 2];
    /// Whether there is [`row`](Self::row).
    const HAS_ROWS: bool = false;

    unsafe fn zero() -> Self::Sums;
    unsafe fn weights(from: *const u8) -> Self::Weights;
    unsafe fn values(from: *const Self::Stored) -> Self::Values;
    unsafe fn add(sums: Self::Sums, values: Self::Values, weights: Self::Weights) -> Self::Sums;
    unsafe fn whole(sums: Self::Sums) -> Self::Lanes;

    /// Four neighbouring pixels of sixteen channels each, channel by channel.
    unsafe fn row(_from: *const Self::Stored) -> Self::Values {
        unreachable!("nobody asks where there are no rows")
    }
}

/// In `f32`, channel by channel.
pub(crate) struct Widened<V, S>(PhantomData<(V, S)>);

impl<V: Lanes, S: Stored> Dots for Widened<V, S> {
    type Stored = S;
    type Lanes = V;
    type Sums = V;
    type Weights = V;
    type Values = V;
    const PER: usize = 1;
    const TILE: [usize; 2] = V::TILE;

    #[inline(always)]
    unsafe fn zero() -> V {
        // SAFETY: the caller's.
        unsafe { V::splat(0.0) }
    }

    #[inline(always)]
    unsafe fn weights(from: *const u8) -> V {
        // SAFETY: the caller's.
        unsafe { S::load_weights(from.cast()) }
    }

    #[inline(always)]
    unsafe fn values(from: *const S) -> V {
        // SAFETY: the caller's.
        unsafe { V::splat((*from).value()) }
    }

    #[inline(always)]
    unsafe fn add(sums: V, values: V, weights: V) -> V {
        // SAFETY: the caller's.
        unsafe { values.mul_add(weights, sums) }
    }

    #[inline(always)]
    unsafe fn whole(sums: V) -> V {
        sums
    }
}

/// Bytes that one weight of sixteen sums takes, for each of the channels that are added at once.
pub(crate) const fn line_bytes<S: Stored>(per: usize) -> usize {
    LANES * per * size_of::<S::Weight>()
}

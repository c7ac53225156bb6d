//! Sums of products of elements of reduced precision.
//!
//! Processors with instructions for it multiply and add two or four neighbouring channels at once;
//! elsewhere elements are widened to `f32` as they are loaded.

use std::marker::PhantomData;

use super::element::ReducedPrecision;
use crate::lanes16::Lanes16;

/// Accumulators of 16 output channels, and the instruction that adds products to them.
///
/// # Safety
/// Every method requires that the processor has the instructions of the type, and that the memory
/// it reads is readable.
#[allow(clippy::missing_safety_doc, reason = "one contract for all methods, at the trait")]
pub trait DotProduct {
    /// Stored elements of the image.
    type Element: ReducedPrecision;
    /// Vector of the finished sums.
    type Lanes: Lanes16;
    /// Sixteen sums.
    type Accumulator: Copy;
    /// [`DEPTH`](Self::DEPTH) weights for each of 16 sums.
    type Weights: Copy;
    /// [`DEPTH`](Self::DEPTH) neighbouring channels of a pixel, repeated for every sum.
    type Values: Copy;
    /// Neighbouring input channels that are added at once.
    const DEPTH: usize;
    /// Pixels of a register tile whose accumulators stay in registers: for one, and for two, blocks
    /// of 16 output channels.
    const TILE: [usize; 2];
    /// Whether [`pixel_row`](Self::pixel_row) exists.
    const HAS_PIXEL_ROWS: bool = false;

    /// Sums of nothing.
    unsafe fn zero() -> Self::Accumulator;
    /// Loads the weights of 16 sums.
    unsafe fn weights(from: *const u8) -> Self::Weights;
    /// Loads neighbouring channels of one pixel and repeats them.
    unsafe fn values(from: *const Self::Element) -> Self::Values;
    /// `acc + values · weights`.
    unsafe fn add(
        acc: Self::Accumulator,
        values: Self::Values,
        weights: Self::Weights,
    ) -> Self::Accumulator;
    /// The sums as `f32`.
    unsafe fn to_f32(acc: Self::Accumulator) -> Self::Lanes;

    /// Loads four neighbouring pixels of 16 channels each, channel by channel.
    unsafe fn pixel_row(_from: *const Self::Element) -> Self::Values {
        unreachable!("guarded by HAS_PIXEL_ROWS")
    }
}

/// Products in `f32`, one channel at a time.
pub(super) struct Widened<V, S>(PhantomData<(V, S)>);

impl<V: Lanes16, S: ReducedPrecision> DotProduct for Widened<V, S> {
    type Element = S;
    type Lanes = V;
    type Accumulator = V;
    type Weights = V;
    type Values = V;
    const DEPTH: usize = 1;
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
    unsafe fn add(acc: V, values: V, weights: V) -> V {
        // SAFETY: the caller's.
        unsafe { values.mul_add(weights, acc) }
    }

    #[inline(always)]
    unsafe fn to_f32(acc: V) -> V {
        acc
    }
}

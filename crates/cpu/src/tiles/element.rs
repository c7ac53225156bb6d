//! Elements that tiles multiply.

use super::unit::TileUnit;
use crate::level::Level;
use crate::reduced::{Bf16, ReducedPrecision};

/// An element type whose products tile units add up.
///
/// A row of an input tile holds neighbouring channels of a pixel. A row of a weight tile holds the
/// weights of four bytes' worth of channels for each of 16 outputs, which is also the layout of
/// [`DotProduct`](crate::DotProduct) of as many channels.
pub trait TileElement: ReducedPrecision {
    /// A sum of products.
    type Sum: Copy + Default;

    /// Channels whose weights for one output are next to each other: four bytes of them.
    const DEPTH: usize = 4 / size_of::<Self>();

    /// Whether kernels of this level may use AMX for these elements.
    fn has_amx(level: Level) -> bool;

    /// Adds the products of tile `A` by tile `B` to tile `SUM`.
    ///
    /// # Safety
    /// That of [`TileUnit`].
    unsafe fn add_products<U: TileUnit, const SUM: usize, const A: usize, const B: usize>(
        unit: &mut U,
    );

    /// A sum as `f32`.
    fn sum_to_f32(sum: Self::Sum) -> f32;
}

impl TileElement for u8 {
    type Sum = i32;

    fn has_amx(level: Level) -> bool {
        level.has_amx_int8()
    }

    #[inline(always)]
    unsafe fn add_products<U: TileUnit, const SUM: usize, const A: usize, const B: usize>(
        unit: &mut U,
    ) {
        // SAFETY: the caller's.
        unsafe { unit.add_products_u8::<SUM, A, B>() }
    }

    #[inline(always)]
    fn sum_to_f32(sum: i32) -> f32 {
        sum as f32
    }
}

impl TileElement for Bf16 {
    type Sum = f32;

    fn has_amx(level: Level) -> bool {
        level.has_amx_bf16()
    }

    #[inline(always)]
    unsafe fn add_products<U: TileUnit, const SUM: usize, const A: usize, const B: usize>(
        unit: &mut U,
    ) {
        // SAFETY: the caller's.
        unsafe { unit.add_products_bf16::<SUM, A, B>() }
    }

    #[inline(always)]
    fn sum_to_f32(sum: f32) -> f32 {
        sum
    }
}

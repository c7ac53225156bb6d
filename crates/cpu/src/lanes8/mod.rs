//! Vectors of 8 `f32` or `i32`, safe.
//!
//! Loops over slices are left to the compiler ([`vectorize`](crate::vectorize())). Loops that
//! gather, mask or branch on a comparison it compiles to branches or shuffles; those kernels are
//! written here once, over [`Lanes8`], and compiled for AVX2 and for the baseline.
//!
//! Operations are those of IEEE 754, none contracted: both give the same bits.

/// Methods of one expression each, inlined everywhere.
macro_rules! lanes {
    ($($name:ident($self:ident $(, $arg:ident: $type:ty)*) -> $out:ty = $value:expr;)*) => {$(
        #[inline(always)]
        fn $name($self $(, $arg: $type)*) -> $out {
            $value
        }
    )*};
}

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
mod portable;
#[cfg(test)]
mod tests;

use std::fmt::Debug;

/// Lanes of a [`Lanes8`] vector.
pub const LANES_8: usize = 8;

/// Vectors of 8 `f32` (`F`) and of 8 `i32` (`I`).
///
/// Methods whose name ends in `_i` take integers. A mask is a vector of integers, all bits one or
/// zero in every lane.
#[allow(clippy::wrong_self_convention, reason = "self is the proof of the level, not the operand")]
pub trait Lanes8: Copy + Debug {
    /// Eight `f32`.
    type F: Copy + Debug;
    /// Eight `i32`.
    type I: Copy + Debug;

    /// A vector from an array.
    fn load(self, from: [f32; LANES_8]) -> Self::F;
    /// The lanes as an array.
    fn store(self, a: Self::F) -> [f32; LANES_8];
    /// `a` in every lane.
    fn splat(self, a: f32) -> Self::F;
    /// `a + b`.
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a - b`.
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a · b`.
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a / b`.
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// `√a`.
    fn sqrt(self, a: Self::F) -> Self::F;
    /// The smaller, or `b` where either is NaN.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// The larger, or `b` where either is NaN.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// Mask of `a < b`, false where either is NaN.
    fn lt(self, a: Self::F, b: Self::F) -> Self::I;
    /// Mask of `a <= b`, false where either is NaN.
    fn le(self, a: Self::F, b: Self::F) -> Self::I;
    /// `a` rounded towards negative infinity.
    fn floor(self, a: Self::F) -> Self::F;
    /// Converts to integers, rounding towards zero; magnitudes must be below 2³¹.
    fn to_i(self, a: Self::F) -> Self::I;
    /// Converts integers to the nearest `f32`.
    fn to_f(self, a: Self::I) -> Self::F;
    /// The bits of `f32`, as [`f32::to_bits`].
    fn to_bits(self, a: Self::F) -> Self::I;
    /// `f32` from their bits, as [`f32::from_bits`].
    fn from_bits(self, a: Self::I) -> Self::F;
    /// Transposes a square: row `i`, lane `k` becomes row `k`, lane `i`.
    fn transpose(self, rows: [Self::F; LANES_8]) -> [Self::F; LANES_8];

    /// A vector from an array.
    fn load_i(self, from: [i32; LANES_8]) -> Self::I;
    /// The lanes as an array.
    fn store_i(self, a: Self::I) -> [i32; LANES_8];
    /// `a` in every lane.
    fn splat_i(self, a: i32) -> Self::I;
    /// `a + b`, wrapping.
    fn add_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a - b`, wrapping.
    fn sub_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a · b`, wrapping.
    fn mul_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// Maximum of each lane, signed.
    fn max_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// Minimum of each lane, signed.
    fn min_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// Mask of `a > b`.
    fn gt_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a & b`.
    fn and(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a | b`.
    fn or(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a & !b`.
    fn and_not(self, a: Self::I, b: Self::I) -> Self::I;
    /// Mask of the negative lanes.
    fn sign_mask(self, a: Self::I) -> Self::I;
    /// Logical shift: zeros come in from the left.
    fn shift_right<const BITS: i32>(self, a: Self::I) -> Self::I;
    /// Arithmetic shift: the sign comes in from the left.
    fn shift_right_signed<const BITS: i32>(self, a: Self::I) -> Self::I;
    /// The sign bits of a mask: bit `k` is lane `k`.
    fn to_bitmask(self, mask: Self::I) -> u32;
    /// Gathers 8 rows of 4 from any addresses and transposes them: column `i`, lane `k` is row `k`,
    /// element `i`.
    fn gather_columns(self, rows: [&[i32; 4]; LANES_8]) -> [Self::I; 4];
    /// Transposes 4 columns into 8 rows: the inverse of [`gather_columns`](Self::gather_columns).
    fn scatter_columns(self, columns: [Self::I; 4], out: &mut [[i32; 4]; LANES_8]);
    /// `a` where the mask is set, else `b`.
    fn select(self, mask: Self::I, a: Self::I, b: Self::I) -> Self::I;
}

/// A kernel over vectors of 8 lanes, compiled for every level.
pub trait Kernel8 {
    /// Result of the kernel.
    type Output;
    /// Computes the kernel. Mark it, and everything it calls, `#[inline(always)]`.
    fn run<L: Lanes8>(self, lanes: L) -> Self::Output;
}

/// Runs a kernel as compiled for this processor.
#[inline(always)]
pub fn dispatch<K: Kernel8>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(
            #[inline(always)]
            || kernel.run(avx2::Avx2(simd)),
        );
    }
    kernel.run(portable::Portable)
}

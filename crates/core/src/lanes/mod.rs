//! Eight numbers at a time, in words that name vector instructions.
//!
//! Loops over slices are left to the compiler ([`wide`](crate::wide())). Where a loop gathers, masks
//! or goes on by a comparison it makes branches or shuffles of them; such kernels are written here
//! once, over [`Lanes`], and compiled for AVX2 and for any processor.
//!
//! Operations are those of IEEE 754, none contracted: both give the same bits.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod portable;
#[cfg(test)]
mod tests;

use std::fmt::Debug;

/// Numbers in a vector.
pub const LANES: usize = 8;

/// Vectors of eight `f32` and of eight `i32`. A mask is a vector of integers, all bits one or zero.
pub trait Lanes: Copy + Debug {
    /// Eight `f32`.
    type F: Copy + Debug;
    /// Eight `i32`.
    type I: Copy + Debug;

    /// From an array.
    fn load(self, from: [f32; LANES]) -> Self::F;
    /// Into an array.
    fn store(self, a: Self::F) -> [f32; LANES];
    /// One number eight times.
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
    /// The smaller one, or `b` where one is no number.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// The larger one, or `b` where one is no number.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// Mask of `a < b`.
    fn less(self, a: Self::F, b: Self::F) -> Self::I;
    /// The largest integers not above `a`, as numbers.
    fn floor(self, a: Self::F) -> Self::F;
    /// Integers below 2³¹ in magnitude, as such.
    fn to_i(self, a: Self::F) -> Self::I;
    /// The nearest numbers to integers.
    fn to_f(self, a: Self::I) -> Self::F;
    /// The bits of numbers.
    fn bits(self, a: Self::F) -> Self::I;
    /// Numbers from their bits.
    fn numbers(self, a: Self::I) -> Self::F;
    /// Eight numbers of each of eight vectors exchanged: row `i`, lane `k` becomes row `k`, lane `i`.
    fn transpose(self, rows: [Self::F; LANES]) -> [Self::F; LANES];

    /// From an array.
    fn load_i(self, from: [i32; LANES]) -> Self::I;
    /// Into an array.
    fn store_i(self, a: Self::I) -> [i32; LANES];
    /// One integer eight times.
    fn splat_i(self, a: i32) -> Self::I;
    /// `a + b`, wrapping.
    fn add_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a - b`, wrapping.
    fn sub_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a · b`, wrapping.
    fn mul_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// The larger one.
    fn max_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// The smaller one.
    fn min_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// Mask of `a > b`.
    fn greater_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a & b`.
    fn and(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a | b`.
    fn or(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a & !b`.
    fn and_not(self, a: Self::I, b: Self::I) -> Self::I;
    /// Mask of the negative ones.
    fn negative(self, a: Self::I) -> Self::I;
    /// Zeros shifted in from the left.
    fn shift_right<const BITS: i32>(self, a: Self::I) -> Self::I;
    /// The sign shifted in from the left.
    fn shift_right_signed<const BITS: i32>(self, a: Self::I) -> Self::I;
    /// Bit `k` is that of lane `k` of a mask.
    fn mask_bits(self, mask: Self::I) -> u32;
    /// The columns of eight rows of four, wherever these are.
    fn columns(self, rows: [&[i32; 4]; LANES]) -> [Self::I; 4];
    /// Writes the eight rows of four columns.
    fn rows(self, columns: [Self::I; 4], out: &mut [[i32; 4]; LANES]);
    /// `a` where the mask is set, else `b`.
    fn select(self, mask: Self::I, a: Self::I, b: Self::I) -> Self::I;
}

/// A kernel over vectors.
pub trait LaneWork {
    /// What comes out.
    type Output;
    /// Mark it, and everything it calls, `#[inline(always)]`.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Runs `work` as compiled for the processor at hand.
#[inline(always)]
pub fn in_lanes<W: LaneWork>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(
            #[inline(always)]
            || work.run(avx2::Avx2(simd)),
        );
    }
    work.run(portable::Portable)
}

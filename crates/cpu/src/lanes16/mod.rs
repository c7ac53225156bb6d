//! Vectors of 16 `f32` in whatever registers the processor has.
//!
//! A kernel is written once, generic over [`Lanes16`], and compiled for every [`Level`]; the level
//! is chosen when the program runs.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) mod avx512;
mod portable;

use crate::level::Level;
use crate::reduced::Bf16;

/// Lanes of a [`Lanes16`] vector.
pub const LANES_16: usize = 16;

/// A vector of 16 `f32`.
///
/// # Safety
/// Every method requires that the processor has the instructions of the type, which [`Level::run`]
/// ensures. Methods that take a pointer require 16 elements there, of any alignment: readable for a
/// load, writable for a store.
#[allow(clippy::missing_safety_doc, reason = "one contract for all methods, at the trait")]
pub trait Lanes16: Copy {
    /// Pixels of a register tile whose accumulators stay in registers: for one, and for two, blocks
    /// of 16 output channels.
    const TILE: [usize; 2];

    /// `value` in every lane.
    unsafe fn splat(value: f32) -> Self;
    /// 16 consecutive `f32`.
    unsafe fn load(from: *const f32) -> Self;
    /// Writes the lanes to 16 consecutive `f32`.
    unsafe fn store(self, to: *mut f32);
    /// `self + other`.
    unsafe fn add(self, other: Self) -> Self;
    /// `self - other`.
    unsafe fn sub(self, other: Self) -> Self;
    /// `self · other`.
    unsafe fn mul(self, other: Self) -> Self;
    /// `self · factor + term`, rounded once where the processor can.
    unsafe fn mul_add(self, factor: Self, term: Self) -> Self;
    /// The larger, or `other` where either is NaN.
    unsafe fn max(self, other: Self) -> Self;
    /// The smaller, or `other` where either is NaN.
    unsafe fn min(self, other: Self) -> Self;

    /// 16 bfloat16 values, the upper halves of `f32`.
    #[inline(always)]
    unsafe fn load_bf16(from: *const u16) -> Self {
        // SAFETY: the caller's.
        let halves = unsafe { from.cast::<[u16; LANES_16]>().read_unaligned() };
        let values = halves.map(|half| f32::from_bits(u32::from(half) << 16));
        // SAFETY: the caller's.
        unsafe { Self::load(values.as_ptr()) }
    }

    /// Rounds to the nearest bfloat16 values, ties to even.
    #[inline(always)]
    unsafe fn store_bf16(self, to: *mut u16) {
        // SAFETY: the caller's.
        let halves = unsafe { self.to_array() }.map(|value| Bf16::nearest(value).0);
        // SAFETY: the caller's.
        unsafe { to.cast::<[u16; LANES_16]>().write_unaligned(halves) }
    }

    /// 16 unsigned bytes.
    #[inline(always)]
    unsafe fn load_u8(from: *const u8) -> Self {
        // SAFETY: the caller's.
        let bytes = unsafe { from.cast::<[u8; LANES_16]>().read_unaligned() };
        // SAFETY: the caller's.
        unsafe { Self::load(bytes.map(f32::from).as_ptr()) }
    }

    /// 16 signed bytes.
    #[inline(always)]
    unsafe fn load_i8(from: *const i8) -> Self {
        // SAFETY: the caller's.
        let bytes = unsafe { from.cast::<[i8; LANES_16]>().read_unaligned() };
        // SAFETY: the caller's.
        unsafe { Self::load(bytes.map(f32::from).as_ptr()) }
    }

    /// Rounds to the nearest integers, ties to even, clamped to 0..=255.
    #[inline(always)]
    unsafe fn store_u8(self, to: *mut u8) {
        // SAFETY: the caller's.
        let bytes = unsafe { self.to_array() }.map(|value| value.round_ties_even() as u8);
        // SAFETY: the caller's.
        unsafe { to.cast::<[u8; LANES_16]>().write_unaligned(bytes) }
    }

    /// [`store_u8`](Self::store_u8) of values that are not negative.
    #[inline(always)]
    unsafe fn store_nonnegative_u8(self, to: *mut u8) {
        // SAFETY: the caller's.
        unsafe { self.store_u8(to) }
    }

    /// The lanes as an array.
    #[inline(always)]
    unsafe fn to_array(self) -> [f32; LANES_16] {
        let mut values = [0.0; LANES_16];
        // SAFETY: the caller's, and there is room for all.
        unsafe { self.store(values.as_mut_ptr()) };
        values
    }

    /// Prefetches the cache line of an address, which need not be readable, into the second level.
    unsafe fn prefetch(from: *const f32);
}

/// A kernel over vectors of 16 lanes, compiled for every level. Mark `run` `#[inline(always)]`.
pub trait Kernel16 {
    /// Computes the whole kernel.
    ///
    /// # Safety
    /// That of the kernel's own constructor, and the processor has the instructions of `V`.
    unsafe fn run<V: Lanes16>(&self);
}

impl Level {
    /// Runs a kernel as compiled for this level.
    ///
    /// # Safety
    /// That of the kernel. The level is one of [`Level::available`].
    pub unsafe fn run(self, kernel: &impl Kernel16) {
        // SAFETY: the caller's, and that a level is only made where it is available.
        unsafe {
            match self {
                Self::Portable => kernel.run::<portable::Array>(),
                #[cfg(target_arch = "x86_64")]
                Self::Avx2 => run_avx2(kernel),
                #[cfg(target_arch = "x86_64")]
                Self::Avx512 => run_avx512(kernel),
            }
        }
    }
}

/// # Safety
/// That of the kernel, on a processor with AVX2 and FMA.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
unsafe fn run_avx2(kernel: &impl Kernel16) {
    // SAFETY: the caller's.
    unsafe { kernel.run::<avx2::Ymm2>() }
}

/// # Safety
/// That of the kernel, on a processor with AVX-512F, AVX-512BW, AVX2 and FMA.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx2,fma")]
unsafe fn run_avx512(kernel: &impl Kernel16) {
    // SAFETY: the caller's.
    unsafe { kernel.run::<avx512::Zmm>() }
}

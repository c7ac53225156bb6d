//! Sixteen numbers at a time, as wide as the processor does it.
//!
//! A kernel is written once, generic over [`Lanes`], and compiled for every [`Level`]; which of them
//! runs is decided when the program runs. Everything between [`Level::run`] and the methods of
//! [`Lanes`] has to be inlined: what is not is compiled for any processor.

#![allow(unsafe_code, reason = "vector instructions; contracts are written at each function")]

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;

use std::fmt;

/// Lanes of a vector, and channels of a block of an image.
pub(crate) const LANES: usize = 16;

/// Sixteen `f32`.
///
/// # Safety
/// Every method requires that the processor has the instructions of the type, which [`Level::run`]
/// sees to. Those that take a pointer require that sixteen `f32` are there.
pub(crate) trait Lanes: Copy {
    /// Pixels of a tile of one and of two blocks of channels whose sums stay in registers.
    const TILE: [usize; 2];

    unsafe fn splat(value: f32) -> Self;
    unsafe fn load(from: *const f32) -> Self;
    unsafe fn store(self, to: *mut f32);
    unsafe fn add(self, other: Self) -> Self;
    unsafe fn sub(self, other: Self) -> Self;
    unsafe fn mul(self, other: Self) -> Self;
    /// `self * factor + term`, rounded once where the processor can.
    unsafe fn mul_add(self, factor: Self, term: Self) -> Self;
    unsafe fn max(self, other: Self) -> Self;
    unsafe fn min(self, other: Self) -> Self;
    /// Asks for the cache line at an address, which need not be readable, for what reads it soon.
    unsafe fn fetch(from: *const f32);
}

/// Work that is compiled for every level. Mark `run` `#[inline(always)]`.
pub(crate) trait Kernel {
    /// # Safety
    /// That of the kernel's own constructor, and the processor has the instructions of `V`.
    unsafe fn run<V: Lanes>(&self);
}

/// Instructions that kernels are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Level {
    /// Whatever the program was compiled for.
    Portable,
    /// AVX2 and FMA: eight numbers at a time.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512F: sixteen numbers at a time.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// All levels of this processor, the best first.
    pub fn available() -> Vec<Self> {
        let mut levels = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            let has_avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            if has_avx2 && is_x86_feature_detected!("avx512f") {
                levels.push(Self::Avx512);
            }
            if has_avx2 {
                levels.push(Self::Avx2);
            }
        }
        levels.push(Self::Portable);
        levels
    }

    /// The best level of this processor.
    pub fn best() -> Self {
        Self::available()[0]
    }

    /// Whether registers hold the sums of two blocks of channels for many pixels.
    pub(crate) fn holds_two(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return self == Self::Avx512;
        #[cfg(not(target_arch = "x86_64"))]
        false
    }

    /// Runs a kernel as compiled for this level.
    ///
    /// # Safety
    /// That of the kernel. The level is one of [`Level::available`].
    pub(crate) unsafe fn run(self, kernel: &impl Kernel) {
        // SAFETY: the caller's, and that a level is only made where it is available.
        unsafe {
            match self {
                Self::Portable => kernel.run::<portable::Array>(),
                #[cfg(target_arch = "x86_64")]
                Self::Avx2 => with_avx2(kernel),
                #[cfg(target_arch = "x86_64")]
                Self::Avx512 => with_avx512(kernel),
            }
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "avx512",
        })
    }
}

/// # Safety
/// That of the kernel, on a processor with AVX2 and FMA.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
unsafe fn with_avx2(kernel: &impl Kernel) {
    // SAFETY: the caller's.
    unsafe { kernel.run::<avx2::Pair>() }
}

/// # Safety
/// That of the kernel, on a processor with AVX-512F, AVX2 and FMA.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
unsafe fn with_avx512(kernel: &impl Kernel) {
    // SAFETY: the caller's.
    unsafe { kernel.run::<avx512::Whole>() }
}

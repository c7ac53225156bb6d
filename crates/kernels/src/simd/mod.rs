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
#[cfg(target_arch = "x86_64")]
mod avx512_dots;
pub(crate) mod dots;
mod portable;

use std::fmt;
use std::marker::PhantomData;

use dots::{Bf16, Dots, Stored, Widened};

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

    /// Numbers of sixteen bits, the upper halves of `f32`.
    #[inline(always)]
    unsafe fn load_halves(from: *const u16) -> Self {
        // SAFETY: the caller's.
        let halves = unsafe { from.cast::<[u16; LANES]>().read_unaligned() };
        let values = halves.map(|half| f32::from_bits(u32::from(half) << 16));
        // SAFETY: the caller's.
        unsafe { Self::load(values.as_ptr()) }
    }

    /// Rounds to the nearest numbers of sixteen bits.
    #[inline(always)]
    unsafe fn store_halves(self, to: *mut u16) {
        // SAFETY: the caller's.
        let halves = unsafe { self.array() }.map(|value| Bf16::nearest(value).0);
        // SAFETY: the caller's.
        unsafe { to.cast::<[u16; LANES]>().write_unaligned(halves) }
    }

    #[inline(always)]
    unsafe fn load_bytes(from: *const u8) -> Self {
        // SAFETY: the caller's.
        let bytes = unsafe { from.cast::<[u8; LANES]>().read_unaligned() };
        // SAFETY: the caller's.
        unsafe { Self::load(bytes.map(f32::from).as_ptr()) }
    }

    #[inline(always)]
    unsafe fn load_signed_bytes(from: *const i8) -> Self {
        // SAFETY: the caller's.
        let bytes = unsafe { from.cast::<[i8; LANES]>().read_unaligned() };
        // SAFETY: the caller's.
        unsafe { Self::load(bytes.map(f32::from).as_ptr()) }
    }

    /// Rounds to the nearest, of two that are as near the even one; beyond 0 and 255 these.
    #[inline(always)]
    unsafe fn store_bytes(self, to: *mut u8) {
        // SAFETY: the caller's.
        let bytes = unsafe { self.array() }.map(|value| value.round_ties_even() as u8);
        // SAFETY: the caller's.
        unsafe { to.cast::<[u8; LANES]>().write_unaligned(bytes) }
    }

    /// As [`store_bytes`](Self::store_bytes), of values that are not below 0.
    #[inline(always)]
    unsafe fn store_positive_bytes(self, to: *mut u8) {
        // SAFETY: the caller's.
        unsafe { self.store_bytes(to) }
    }

    #[inline(always)]
    unsafe fn array(self) -> [f32; LANES] {
        let mut values = [0.0; LANES];
        // SAFETY: the caller's, and there is room for all.
        unsafe { self.store(values.as_mut_ptr()) };
        values
    }

    /// Asks for the cache line at an address, which need not be readable, for what reads it soon.
    unsafe fn fetch(from: *const f32);
}

/// Work that is compiled for every level. Mark `run` `#[inline(always)]`.
pub(crate) trait Kernel {
    /// # Safety
    /// That of the kernel's own constructor, and the processor has the instructions of `V`.
    unsafe fn run<V: Lanes>(&self);
}

/// Work on numbers of fewer bits that is compiled for every level. Mark `run` `#[inline(always)]`.
pub(crate) trait PackedKernel<S: Stored> {
    /// # Safety
    /// That of the kernel's own constructor, and the processor has the instructions of `D`.
    unsafe fn run<D: Dots<Stored = S>>(&self);
}

/// Such work, in `f32`.
struct InWhole<'a, K, S>(&'a K, PhantomData<S>);

impl<K: PackedKernel<S>, S: Stored> Kernel for InWhole<'_, K, S> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        // SAFETY: the caller's.
        unsafe { self.0.run::<Widened<V, S>>() }
    }
}

/// Numbers of fewer bits, and the instructions that there may be for them.
pub(crate) trait Packed: Stored + Sized {
    /// Channels that are multiplied at once.
    fn per(level: Level) -> usize;

    /// # Safety
    /// That of the kernel. The level is one of [`Level::available`].
    unsafe fn run(level: Level, kernel: &impl PackedKernel<Self>);
}

impl Packed for u8 {
    fn per(level: Level) -> usize {
        if level.has_fours() { 4 } else { 1 }
    }

    unsafe fn run(level: Level, kernel: &impl PackedKernel<Self>) {
        // SAFETY: the caller's, and what the processor has was asked for.
        unsafe {
            #[cfg(target_arch = "x86_64")]
            if level.has_fours() {
                return with_fours(kernel);
            }
            level.run(&InWhole(kernel, PhantomData));
        }
    }
}

impl Packed for Bf16 {
    fn per(level: Level) -> usize {
        if level.has_pairs() { 2 } else { 1 }
    }

    unsafe fn run(level: Level, kernel: &impl PackedKernel<Self>) {
        // SAFETY: the caller's, and what the processor has was asked for.
        unsafe {
            #[cfg(target_arch = "x86_64")]
            if level.has_pairs() {
                return with_pairs(kernel);
            }
            level.run(&InWhole(kernel, PhantomData));
        }
    }
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

    /// Whether four bytes are multiplied at once.
    fn has_fours(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return self == Self::Avx512
            && is_x86_feature_detected!("avx512vnni")
            && is_x86_feature_detected!("avx512bw");
        #[cfg(not(target_arch = "x86_64"))]
        false
    }

    /// Whether two numbers of sixteen bits are multiplied at once.
    fn has_pairs(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return self == Self::Avx512
            && is_x86_feature_detected!("avx512bf16")
            && is_x86_feature_detected!("avx512bw");
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

/// # Safety
/// That of the kernel, on a processor with these.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512vnni,avx2,fma")]
unsafe fn with_fours(kernel: &impl PackedKernel<u8>) {
    // SAFETY: the caller's.
    unsafe { kernel.run::<avx512_dots::Fours>() }
}

/// # Safety
/// That of the kernel, on a processor with these.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512bf16,avx2,fma")]
unsafe fn with_pairs(kernel: &impl PackedKernel<Bf16>) {
    // SAFETY: the caller's.
    unsafe { kernel.run::<avx512_dots::Pairs>() }
}

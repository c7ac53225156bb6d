//! Elements of reduced precision (bfloat16 and bytes), and kernels over them.

#[cfg(target_arch = "x86_64")]
mod avx512;
mod dot_product;
mod element;

use std::marker::PhantomData;

pub use dot_product::DotProduct;
pub use element::{Bf16, ReducedPrecision, weight_vector_bytes};

use crate::lanes16::{Kernel16, Lanes16};
use crate::level::Level;
use dot_product::Widened;

/// A kernel over elements of reduced precision, compiled for every level. Mark `run`
/// `#[inline(always)]`.
pub trait ReducedKernel<S: ReducedPrecision> {
    /// Computes the whole kernel.
    ///
    /// # Safety
    /// That of the kernel's own constructor, and the processor has the instructions of `D`.
    unsafe fn run<D: DotProduct<Element = S>>(&self);
}

/// Chooses the dot product of an element type that this processor has instructions for.
pub trait ReducedDispatch: ReducedPrecision {
    /// Neighbouring input channels that are multiplied at once: [`DotProduct::DEPTH`] of a level.
    fn dot_depth(level: Level) -> usize;

    /// Runs a kernel as compiled for a level.
    ///
    /// # Safety
    /// That of the kernel. The level is one of [`Level::available`].
    unsafe fn run(level: Level, kernel: &impl ReducedKernel<Self>);
}

impl ReducedDispatch for u8 {
    fn dot_depth(level: Level) -> usize {
        if level.has_vnni() { 4 } else { 1 }
    }

    unsafe fn run(level: Level, kernel: &impl ReducedKernel<Self>) {
        // SAFETY: the caller's, and the instructions were detected.
        unsafe {
            #[cfg(target_arch = "x86_64")]
            if level.has_vnni() {
                return run_vnni(kernel);
            }
            level.run(&InF32(kernel, PhantomData));
        }
    }
}

impl ReducedDispatch for Bf16 {
    fn dot_depth(level: Level) -> usize {
        if level.has_bf16() { 2 } else { 1 }
    }

    unsafe fn run(level: Level, kernel: &impl ReducedKernel<Self>) {
        // SAFETY: the caller's, and the instructions were detected.
        unsafe {
            #[cfg(target_arch = "x86_64")]
            if level.has_bf16() {
                return run_bf16(kernel);
            }
            level.run(&InF32(kernel, PhantomData));
        }
    }
}

/// A kernel whose elements are widened to `f32`.
struct InF32<'a, K, S>(&'a K, PhantomData<S>);

impl<K: ReducedKernel<S>, S: ReducedPrecision> Kernel16 for InF32<'_, K, S> {
    #[inline(always)]
    unsafe fn run<V: Lanes16>(&self) {
        // SAFETY: the caller's.
        unsafe { self.0.run::<Widened<V, S>>() }
    }
}

/// # Safety
/// That of the kernel, on a processor with these.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512vnni,avx2,fma")]
unsafe fn run_vnni(kernel: &impl ReducedKernel<u8>) {
    // SAFETY: the caller's.
    unsafe { kernel.run::<avx512::Vnni>() }
}

/// # Safety
/// That of the kernel, on a processor with these.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512bf16,avx2,fma")]
unsafe fn run_bf16(kernel: &impl ReducedKernel<Bf16>) {
    // SAFETY: the caller's.
    unsafe { kernel.run::<avx512::Avx512Bf16>() }
}

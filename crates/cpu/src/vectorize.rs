//! Loops compiled for the widest vectors that the processor has.
//!
//! A loop compiled for the baseline of x86-64 works on four values at a time; the same loop
//! compiled for AVX2 works on eight, for AVX-512 on sixteen. Results do not depend on it: no
//! operation is contracted or reordered.

/// Runs `work` as compiled for the widest vectors of this processor.
///
/// Mark the closure and everything it calls `#[inline(always)]`: a function that is not inlined is
/// compiled for the baseline of the target.
#[inline(always)]
pub fn vectorize<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

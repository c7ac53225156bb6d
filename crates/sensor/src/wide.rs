//! Loops compiled for the widest vectors that the processor has.
//!
//! The chain is a row of short loops over a block of pixels. Compiled for any x86-64 they work on
//! four pixels at a time; the same loops compiled for AVX2 work on eight. Results do not depend on
//! it: no operation is contracted or reordered.

/// Runs `work` as compiled for the processor at hand.
#[inline(always)]
pub(crate) fn wide<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

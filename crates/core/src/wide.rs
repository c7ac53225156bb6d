//! Loops compiled for the widest vectors that the processor has.
//!
//! Compiled for any x86-64, a loop works on four numbers at a time; the same loop compiled for AVX2
//! works on eight, for AVX-512 on sixteen. Results do not depend on it: no operation is contracted
//! or reordered.

/// Runs `work` as compiled for the processor at hand.
///
/// Mark the closure and everything it calls `#[inline(always)]`: what is not inlined is compiled
/// for any processor.
#[inline(always)]
pub fn wide<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

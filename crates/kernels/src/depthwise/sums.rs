//! Sums over runs, in blocks that stay in registers.

/// Numbers summed at a time.
pub(super) const BLOCK: usize = 32;

/// Numbers from a start on, and what they are multiplied by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    pub(super) start: usize,
    pub(super) weight: f32,
}

/// Fills `out`, of whole blocks, with `bias` plus the runs out of `from`, weighted.
#[inline(always)]
pub(super) fn weighted(
    out: &mut [f32],
    bias: f32,
    from: &[f32],
    runs: impl Iterator<Item = Run> + Clone,
) {
    let (blocks, rest) = out.as_chunks_mut::<BLOCK>();
    debug_assert!(rest.is_empty(), "whole blocks");
    for (index, out) in blocks.iter_mut().enumerate() {
        let mut sums = [bias; BLOCK];
        for Run { start, weight } in runs.clone() {
            let from = &from[start + index * BLOCK..][..BLOCK];
            for (sum, value) in sums.iter_mut().zip(from) {
                *sum += weight * value;
            }
        }
        *out = sums;
    }
}

/// The sum of products of two runs, the first of whole blocks and no longer than the second.
#[inline(always)]
pub(super) fn dot(a: &[f32], b: &[f32]) -> f32 {
    let (a, rest) = a.as_chunks::<BLOCK>();
    debug_assert!(rest.is_empty(), "whole blocks");
    let mut sums = [0.0_f32; BLOCK];
    for (a, b) in a.iter().zip(b.as_chunks::<BLOCK>().0) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    sums.iter().sum()
}

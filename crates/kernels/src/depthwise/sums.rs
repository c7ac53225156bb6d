//! Sums over runs, in blocks that stay in registers, compiled for every width of vectors.

use pulp::NullaryFnOnce;

use super::phases::Tap;

/// Numbers summed at a time.
pub(super) const BLOCK: usize = 32;

/// Numbers from a start on, and what they are multiplied by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    pub(super) start: usize,
    pub(super) weight: f32,
}

/// Fills `out`, of whole blocks, with `bias` plus the runs out of `from`, weighted.
pub(super) struct Weighted<'a, R> {
    pub(super) out: &'a mut [f32],
    pub(super) bias: f32,
    pub(super) from: &'a [f32],
    pub(super) runs: R,
}

impl<R: Iterator<Item = Run> + Clone> NullaryFnOnce for Weighted<'_, R> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { out, bias, from, runs } = self;
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
}

/// Adds the products of a gradient, of whole blocks, with what each tap reads.
pub(super) struct Products<'a> {
    pub(super) sums: &'a mut [f32],
    pub(super) gradient: &'a [f32],
    pub(super) from: &'a [f32],
    pub(super) taps: &'a [Tap],
}

impl NullaryFnOnce for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (gradient, rest) = self.gradient.as_chunks::<BLOCK>();
        debug_assert!(rest.is_empty(), "whole blocks");
        for (sum, tap) in self.sums.iter_mut().zip(self.taps) {
            let from = self.from[tap.at..].as_chunks::<BLOCK>().0;
            let mut lanes = [0.0_f32; BLOCK];
            for (gradient, from) in gradient.iter().zip(from) {
                for ((lane, dy), x) in lanes.iter_mut().zip(gradient).zip(from) {
                    *lane += dy * x;
                }
            }
            *sum += lanes.iter().sum::<f32>();
        }
    }
}

//! Operations of one input.

use evpose_kernels::training::{Blocks, MaxPool, NormalizedInput, Upsample};

/// An operation that reads one batch, normalised if it is to be.
#[derive(Debug, Clone, Copy)]
pub(super) enum UnaryOp {
    /// Nothing but the normalisation, written to memory.
    Materialize,
    MaxPool(MaxPool),
    Upsample(Upsample),
}

impl UnaryOp {
    /// The output and its shape, and for a max-pooling the index of the largest value in every
    /// window.
    pub(super) fn forward(
        &self,
        shape: Blocks,
        input: NormalizedInput<'_>,
    ) -> (Vec<f32>, Blocks, Vec<u8>) {
        match self {
            Self::Materialize => (input.materialized(&shape), shape, Vec::new()),
            Self::MaxPool(pool) => {
                let (output, taps) = pool.forward(input);
                (output, pool.output(), taps)
            }
            Self::Upsample(upsample) => (upsample.forward(input), upsample.output(), Vec::new()),
        }
    }

    /// The gradient by the normalised input, from that by the output and the indices of the forward
    /// pass.
    pub(super) fn backward(&self, gradient: &[f32], taps: &[u8]) -> Vec<f32> {
        match self {
            Self::Materialize => gradient.to_vec(),
            Self::MaxPool(pool) => pool.backward(gradient, taps),
            Self::Upsample(upsample) => upsample.backward(gradient),
        }
    }
}

//! The shape of a convolution, which every algorithm of it reads.

use super::blocks::Blocks;
use super::weights::Weights;
use crate::simd::Level;

/// Pixels of a batch from which the weights are worth their transforms, which are four times as
/// large.
const MIN_WINOGRAD_PIXELS: usize = 1500;
/// Input channels from which Winograd's transforms of a whole block cost less than they save.
const MIN_WINOGRAD_CHANNELS: usize = 4;

/// A square convolution of stride 1 or 2, padded with zeros by half its kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Conv {
    /// Shape of the input.
    pub input: Blocks,
    /// Channels of the output.
    pub channels_out: usize,
    /// Rows and columns of the kernel; odd.
    pub kernel: usize,
    /// Pixels between outputs: 1 or 2.
    pub stride: usize,
    /// The instructions to compute with.
    pub level: Level,
}

impl Conv {
    /// Shape of the output.
    pub fn output(&self) -> Blocks {
        Blocks { channels: self.channels_out, ..self.input.strided(self.stride) }
    }

    /// Blocks of output channels whose sums registers hold at once.
    pub(super) fn blocks_at_once(&self) -> usize {
        blocks_at_once(self.level)
    }

    /// Whether Winograd's algorithm is used.
    pub(super) fn is_winograd(&self) -> bool {
        let pixels = self.input.batch * self.input.height * self.input.width;
        self.kernel == 3
            && self.stride == 1
            && pixels >= MIN_WINOGRAD_PIXELS
            && self.input.channels >= MIN_WINOGRAD_CHANNELS
    }

    /// Values of the weight.
    pub(super) fn weight_count(&self) -> usize {
        self.channels_out * self.input.channels * self.kernel.pow(2)
    }

    /// The weight as the forward pass takes it, or transposed, as the gradient by the input does.
    pub(super) fn weights<'a>(&self, values: &'a [f32], is_transposed: bool) -> Weights<'a> {
        let shape = [self.channels_out, self.input.channels, self.kernel.pow(2)];
        Weights { values, shape, is_transposed }
    }
}

/// Blocks of output channels whose sums the registers of a level hold at once.
pub(super) fn blocks_at_once(level: Level) -> usize {
    if level.has_room_for_two_blocks() { 2 } else { 1 }
}

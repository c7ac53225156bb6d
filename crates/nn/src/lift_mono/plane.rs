//! The network of one plane: features to the scores of each joint on it.

use burn::module::Module;
use burn::tensor::{Device, Tensor};

use super::blocks::{ResidualBlock, UpsamplingBlock};

/// An hourglass of residual blocks: to half the size and back.
#[derive(Module, Debug)]
pub(super) struct PlaneNet {
    down: Vec<ResidualBlock>,
    middle: Vec<ResidualBlock>,
    upsampling: UpsamplingBlock,
    up: Vec<ResidualBlock>,
}

/// Channels of a [`PlaneNet`].
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaneChannels {
    /// Of the features.
    pub(super) features: usize,
    /// At the size of the features.
    pub(super) fine: usize,
    /// At half of it.
    pub(super) coarse: usize,
    /// Of the scores: joints.
    pub(super) joints: usize,
}

impl PlaneNet {
    pub(super) fn new(channels: PlaneChannels, device: &Device) -> Self {
        let PlaneChannels { features, fine, coarse, joints } = channels;
        let block = |from, to, stride| ResidualBlock::new(from, to, stride, device);
        Self {
            down: vec![
                block(features, fine, 1),
                block(fine, fine, 1),
                block(fine, coarse, 2),
                block(coarse, coarse, 1),
                block(coarse, coarse, 1),
            ],
            middle: vec![block(coarse, coarse, 1), block(coarse, coarse, 1)],
            upsampling: UpsamplingBlock::new(coarse, fine, device),
            up: vec![block(fine, fine, 1), block(fine, joints, 1)],
        }
    }

    /// # Shapes
    /// - features: `[batch, channels, height, width]`
    /// - output: `[batch, joints, height, width]`
    pub(super) fn forward(&self, features: Tensor<4>) -> Tensor<4> {
        let [_, _, height, width] = features.dims();
        let x = self.down.iter().chain(&self.middle).fold(features, |x, block| block.forward(x));
        let x = self.upsampling.forward(x, [height, width]);
        self.up.iter().fold(x, |x, block| block.forward(x))
    }
}

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

impl PlaneNet {
    /// `fine` channels at the size of the features, `coarse` ones at half of it and of the features.
    pub(super) fn new(fine: usize, coarse: usize, joints: usize, device: &Device) -> Self {
        let block = |from, to, stride| ResidualBlock::new(from, to, stride, device);
        Self {
            down: vec![
                block(coarse, fine, 1),
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

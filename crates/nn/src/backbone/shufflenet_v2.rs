//! ShuffleNetV2: half of the channels pass by, the halves are shuffled; layout and weights as
//! torchvision's.
//!
//! # Source
//! Ma et al.: *ShuffleNet V2: Practical Guidelines for Efficient CNN Architecture Design*, ECCV
//! 2018, Table 5.

use burn::module::Module;
use burn::nn::Linear;
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig, MaxPool2d};
use burn::tensor::Device;

use super::resnet::stem_pool;
use super::spec::{BackboneNet, BackboneSpec};
use crate::channels::scaled;
use crate::conv_norm::{ConvNorm, ConvNormConfig};
use crate::initializer::Initializer;
use crate::linear::linear;
use crate::net_ops::{NetOps, VectorOps};
use crate::parameters::Slot;

/// Channels of the first convolution, the same at every published width.
const STEM_CHANNELS: usize = 24;
/// Channels of one half of the first stage; each stage has twice as many as the one before.
const BRANCH_CHANNELS: usize = 58;
/// Units of the three stages.
const UNITS: [usize; 3] = [4, 8, 4];
/// Channels of the last convolution, which narrower networks keep.
const HEAD_CHANNELS: usize = 1024;

/// ShuffleNetV2, "1x".
pub(super) const SHUFFLENET_V2: BackboneSpec<ShuffleNetV2> = BackboneSpec {
    name: "shufflenet_v2",
    about: "ShuffleNetV2 (Ma et al. 2018): a ninth of the parameters",
    smallest_px: 1,
    narrowest: 1.0 / 58.0,
    build: ShuffleNetV2::new,
};

/// A network of shuffled units.
#[derive(Module, Debug)]
pub(crate) struct ShuffleNetV2 {
    stem: ConvNorm,
    pool: MaxPool2d,
    stages: Vec<Vec<Unit>>,
    last: ConvNorm,
    mean: AdaptiveAvgPool2d,
    head: Linear,
}

/// Two branches beside each other, then a shuffle of their channels.
#[derive(Module, Debug)]
struct Unit {
    /// The first branch where the unit halves the image. Elsewhere it is the identity, and each
    /// branch has half of the input channels.
    halving: Option<Halving>,
    expand: ConvNorm,
    depthwise: ConvNorm,
    project: ConvNorm,
}

/// Filter each channel with 3x3 at stride 2, then mix them.
#[derive(Module, Debug)]
struct Halving {
    depthwise: ConvNorm,
    project: ConvNorm,
}

impl ShuffleNetV2 {
    /// The network with all weights zero. `width` multiplies the channels of the stages and is 1 for the
    /// published "1x"; those published as 0.5x, 1.5x and 2x follow no formula and are not among these.
    fn new(width: f32, outputs: usize, device: &Device) -> Self {
        let mut channels = STEM_CHANNELS;
        let mut stages = Vec::new();
        for (index, units) in UNITS.into_iter().enumerate() {
            // Each stage doubles the channels as it halves the sides.
            let branch = scaled(BRANCH_CHANNELS << index, width);
            let first = Unit::new(true, channels, branch, device);
            let rest = (1..units).map(|_| Unit::new(false, branch, branch, device));
            stages.push(std::iter::once(first).chain(rest).collect());
            channels = 2 * branch;
        }
        // As published: a narrower network keeps the width of its head.
        let last = scaled(HEAD_CHANNELS, width.max(1.0));
        Self {
            stem: ConvNormConfig::new(3, STEM_CHANNELS, 3).with_stride(2).init(device),
            pool: stem_pool(),
            stages,
            last: ConvNormConfig::new(channels, last, 1).init(device),
            mean: AdaptiveAvgPool2dConfig::new([1, 1]).init(),
            head: linear(last, outputs, device),
        }
    }
}

impl BackboneNet for ShuffleNetV2 {
    fn forward<N: NetOps>(&self, input: N) -> N::Vector {
        let mut x = self.stem.forward_relu(input).max_pool(&self.pool);
        for unit in self.stages.iter().flatten() {
            x = unit.forward(x);
        }
        let x = self.last.forward_relu(x);
        x.avg_pool(&self.mean).linear(&self.head)
    }

    /// As torchvision initialises: PyTorch's defaults everywhere.
    fn initializer(&self, slot: &Slot) -> Initializer {
        match slot.layer.as_str() {
            "Conv2d" => Initializer::torch_default(slot.shape.iter().skip(1).product()),
            "BatchNorm" => Initializer::batch_norm(slot.name()),
            _ => Initializer::torch_default(self.head.weight.dims()[0]),
        }
    }

    /// `stages.0.3.expand.conv.x` is `stage2.3.branch2.0.x`.
    fn torchvision_path(&self, path: &str) -> String {
        let parts: Vec<&str> = path.split('.').collect();
        let inner = |kind: &str| usize::from(kind == "norm");
        match *parts.as_slice() {
            ["stem", kind, name] => format!("conv1.{}.{name}", inner(kind)),
            ["last", kind, name] => format!("conv5.{}.{name}", inner(kind)),
            ["head", name] => format!("fc.{name}"),
            ["stages", stage, unit, ref part @ .., kind, name] => {
                // torchvision's stages begin at 2.
                let stage = stage.parse::<usize>().map_or(0, |index| index + 2);
                // ReLUs count among the layers of a branch.
                let (branch, layer) = match part {
                    ["halving", "depthwise"] => (1, 0),
                    ["halving", _] => (1, 2),
                    ["expand"] => (2, 0),
                    ["depthwise"] => (2, 3),
                    _ => (2, 5),
                };
                format!("stage{stage}.{unit}.branch{branch}.{}.{name}", layer + inner(kind))
            }
            _ => path.to_owned(),
        }
    }
}

impl Unit {
    /// A unit of `branch` channels a branch; it halves the image if `halves`.
    fn new(halves: bool, channels_in: usize, branch: usize, device: &Device) -> Self {
        let stride = if halves { 2 } else { 1 };
        // A unit that halves cannot pass half of its input through, so its first branch has layers
        // too.
        Self {
            halving: halves.then(|| Halving {
                depthwise: depthwise(channels_in, 2, device),
                project: ConvNormConfig::new(channels_in, branch, 1).init(device),
            }),
            expand: ConvNormConfig::new(channels_in, branch, 1).init(device),
            depthwise: depthwise(branch, stride, device),
            project: ConvNormConfig::new(branch, branch, 1).init(device),
        }
    }

    /// # Shapes
    /// - input: `[batch, channels_in, height, width]`
    /// - output: `[batch, 2 branch, ceil(height / stride), ceil(width / stride)]`
    fn forward<N: NetOps>(&self, input: N) -> N {
        let (first, second) = match &self.halving {
            Some(halving) => (halving.forward(input.clone()), input),
            None => {
                let branch = input.channels() / 2;
                (input.clone().narrow(0..branch), input.narrow(branch..2 * branch))
            }
        };
        let second = self.depthwise.forward(self.expand.forward_relu(second));
        let second = self.project.forward_relu(second);
        // Without interleaving, the two halves would never exchange information.
        first.interleave(second)
    }
}

impl Halving {
    fn forward<N: NetOps>(&self, input: N) -> N {
        self.project.forward_relu(self.depthwise.forward(input))
    }
}

/// A 3x3 convolution of each channel by itself.
fn depthwise(channels: usize, stride: usize, device: &Device) -> ConvNorm {
    ConvNormConfig::new(channels, channels, 3)
        .with_stride(stride)
        .with_groups(channels)
        .init(device)
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::tensor::Tensor;

    #[test]
    fn channels_come_in_turn() {
        let device = Device::flex();
        let one = Tensor::<1>::from_floats([1., 2., 3.], &device).reshape([1, 3, 1, 1]);
        let other = Tensor::<1>::from_floats([4., 5., 6.], &device).reshape([1, 3, 1, 1]);
        let values: Vec<f32> = one.interleave(other).into_data().iter().collect();
        assert_eq!(values, [1., 4., 2., 5., 3., 6.]);
    }
}

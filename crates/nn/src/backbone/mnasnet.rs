//! MnasNet-B1: inverted residuals from an architecture search, layout and weights as torchvision's.
//!
//! Two things in which training departs from torchvision's. Its dropout of 0.2 before the head is
//! left out, for the reasons given in [`mobilenet_v2`](super::mobilenet_v2). And its running
//! statistics follow a batch by 1/10 as everywhere else, not by 3/10,000: at that pace they need
//! tens of thousands of steps to forget their initial values, and a network evaluated earlier would
//! normalise with meaningless statistics.
//!
//! # Source
//! Tan et al.: *MnasNet: Platform-Aware Neural Architecture Search for Mobile*, CVPR 2019, Figure
//! 7a.

use burn::module::Module;
use burn::nn::Linear;
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig};
use burn::tensor::Device;

use super::spec::{BackboneNet, BackboneSpec};
use crate::channels::multiple_of_eight;
use crate::conv_norm::{ConvNorm, ConvNormConfig};
use crate::initializer::Initializer;
use crate::linear::linear;
use crate::net_ops::{NetOps, VectorOps};
use crate::parameters::Slot;

/// Channels of the first convolution and of the block behind it.
const STEM_CHANNELS: [f32; 2] = [32.0, 16.0];
/// Channels of the last convolution at every width.
const HEAD_CHANNELS: usize = 1280;

/// Blocks of one kind, in a row.
struct Stack {
    channels: f32,
    /// Of the depthwise convolutions.
    kernel: usize,
    /// Of the first block.
    stride: usize,
    /// Hidden channels for each channel of a block's input.
    expansion: usize,
    blocks: usize,
}

const STACKS: [Stack; 6] = [
    Stack { channels: 24.0, kernel: 3, stride: 2, expansion: 3, blocks: 3 },
    Stack { channels: 40.0, kernel: 5, stride: 2, expansion: 3, blocks: 3 },
    Stack { channels: 80.0, kernel: 5, stride: 2, expansion: 6, blocks: 3 },
    Stack { channels: 96.0, kernel: 3, stride: 1, expansion: 6, blocks: 2 },
    Stack { channels: 192.0, kernel: 5, stride: 2, expansion: 6, blocks: 4 },
    Stack { channels: 320.0, kernel: 3, stride: 1, expansion: 6, blocks: 1 },
];

pub(super) const MNASNET: BackboneSpec<MnasNet> = BackboneSpec {
    name: "mnasnet",
    about: "MnasNet-B1 (Tan et al. 2019): a quarter of the parameters",
    smallest_px: 1,
    narrowest: 0.01,
    build: MnasNet::new,
};

/// A network of inverted residuals with kernels of two sizes.
#[derive(Module, Debug)]
pub(crate) struct MnasNet {
    stem: ConvNorm,
    /// The first block, which expands nothing and has no residual.
    separable: Separable,
    stacks: Vec<Vec<InvertedResidual>>,
    last: ConvNorm,
    mean: AdaptiveAvgPool2d,
    head: Linear,
}

/// Filter each channel with a square kernel, then mix them.
#[derive(Module, Debug)]
struct Separable {
    depthwise: ConvNorm,
    project: ConvNorm,
}

/// Expand with 1x1, then as [`Separable`]; the input is added where the shape allows.
#[derive(Module, Debug)]
struct InvertedResidual {
    expand: ConvNorm,
    separable: Separable,
    residual: bool,
}

impl MnasNet {
    /// The network with all weights zero.
    fn new(width: f32, outputs: usize, device: &Device) -> Self {
        let [stem, mut channels] =
            STEM_CHANNELS.map(|channels| multiple_of_eight(channels * width));
        let separable = Separable::new(stem, channels, 3, 1, device);
        let mut stacks = Vec::new();
        for stack in &STACKS {
            let output = multiple_of_eight(stack.channels * width);
            let blocks = (0..stack.blocks).map(|block| {
                // Only the first block of a stack halves, and changes the number of channels.
                let input = std::mem::replace(&mut channels, output);
                let stride = if block == 0 { stack.stride } else { 1 };
                InvertedResidual {
                    expand: ConvNormConfig::new(input, input * stack.expansion, 1).init(device),
                    separable: Separable::new(
                        input * stack.expansion,
                        output,
                        stack.kernel,
                        stride,
                        device,
                    ),
                    // A sum of both needs the same side and the same channels.
                    residual: stride == 1 && input == output,
                }
            });
            stacks.push(blocks.collect());
        }
        Self {
            stem: ConvNormConfig::new(3, stem, 3).with_stride(2).init(device),
            separable,
            stacks,
            // As published, the head keeps its width in networks of any width.
            last: ConvNormConfig::new(channels, HEAD_CHANNELS, 1).init(device),
            mean: AdaptiveAvgPool2dConfig::new([1, 1]).init(),
            head: linear(HEAD_CHANNELS, outputs, device),
        }
    }
}

impl BackboneNet for MnasNet {
    fn forward<N: NetOps>(&self, input: N) -> N::Vector {
        let mut x = self.separable.forward(self.stem.forward_relu(input));
        for block in self.stacks.iter().flatten() {
            x = block.forward(x);
        }
        let x = self.last.forward_relu(x);
        x.avg_pool(&self.mean).linear(&self.head)
    }

    /// As torchvision initialises: Kaiming for convolutions; the head uniform with the variance
    /// that keeps gradients, `1 / outputs`.
    fn initializer(&self, slot: &Slot) -> Initializer {
        match (slot.layer.as_str(), slot.shape.as_slice()) {
            ("Conv2d", shape) => Initializer::kaiming_fan_out(shape),
            ("BatchNorm", _) => Initializer::batch_norm(slot.name()),
            (_, &[_, outputs]) => Initializer::Uniform { bound: (3.0 / outputs as f32).sqrt() },
            _ => Initializer::Constant(0.0),
        }
    }

    /// `stacks.1.0.separable.project.conv.x` is `layers.9.0.layers.6.x`: layers are counted
    /// through, a convolution, its normalisation and its ReLU as three, a stack as one.
    fn torchvision_path(&self, path: &str) -> String {
        // Where torchvision's one list of layers has each part.
        const STEM: usize = 0;
        const SEPARABLE: usize = 3;
        const FIRST_STACK: usize = 8;
        const LAST: usize = FIRST_STACK + STACKS.len();
        let parts: Vec<&str> = path.split('.').collect();
        let inner = |kind: &str| usize::from(kind == "norm");
        // A convolution, its normalisation and its ReLU come before the projection.
        let half = |half: &str| if half == "depthwise" { 0 } else { 3 };
        match *parts.as_slice() {
            ["stem", kind, name] => format!("layers.{}.{name}", STEM + inner(kind)),
            ["separable", part, kind, name] => {
                format!("layers.{}.{name}", SEPARABLE + half(part) + inner(kind))
            }
            ["last", kind, name] => format!("layers.{}.{name}", LAST + inner(kind)),
            ["head", name] => format!("classifier.1.{name}"),
            ["stacks", stack, block, ref part @ .., kind, name] => {
                let stack = stack.parse::<usize>().map_or(0, |index| index + FIRST_STACK);
                let layer = match part {
                    ["separable", part] => 3 + half(part),
                    _ => 0,
                };
                format!("layers.{stack}.{block}.layers.{}.{name}", layer + inner(kind))
            }
            _ => path.to_owned(),
        }
    }
}

impl Separable {
    fn new(
        channels_in: usize,
        channels_out: usize,
        kernel: usize,
        stride: usize,
        device: &Device,
    ) -> Self {
        Self {
            depthwise: ConvNormConfig::new(channels_in, channels_in, kernel)
                .with_stride(stride)
                .with_groups(channels_in)
                .init(device),
            project: ConvNormConfig::new(channels_in, channels_out, 1).init(device),
        }
    }

    fn forward<N: NetOps>(&self, input: N) -> N {
        self.project.forward(self.depthwise.forward_relu(input))
    }
}

impl InvertedResidual {
    /// # Shapes
    /// - input: `[batch, channels_in, height, width]`
    /// - output: `[batch, channels_out, ceil(height / stride), ceil(width / stride)]`
    fn forward<N: NetOps>(&self, input: N) -> N {
        let x = self.separable.forward(self.expand.forward_relu(input.clone()));
        if self.residual { x.add(input) } else { x }
    }
}

//! Residual networks of basic blocks: ResNet-18 and ResNet-34, layout and weights as torchvision's.
//!
//! # Source
//! He, Zhang, Ren, Sun: *Deep Residual Learning for Image Recognition*, CVPR 2016, Table 1.

use burn::module::Module;
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig, MaxPool2d, MaxPool2dConfig};
use burn::nn::{Linear, PaddingConfig2d};
use burn::tensor::Device;

use super::spec::{BackboneNet, BackboneSpec};
use crate::channels::scaled;
use crate::conv_norm::{ConvNorm, ConvNormConfig};
use crate::initializer::Initializer;
use crate::linear::linear;
use crate::net_ops::{NetOps, VectorOps};
use crate::parameters::Slot;

/// Channels of the first stage as published.
pub(crate) const PUBLISHED_CHANNELS: usize = 64;
/// Least width relative to that.
pub(crate) const NARROWEST: f32 = 1.0 / 64.0;

/// ResNet-18, the network of EventHands.
pub(super) const RESNET18: BackboneSpec<ResNet> = BackboneSpec {
    name: "resnet18",
    about: "ResNet-18 (He et al. 2016), the network of EventHands",
    smallest_px: 1,
    narrowest: NARROWEST,
    build: |width, outputs, device| ResNet::new([2, 2, 2, 2], width, outputs, device),
};

pub(super) const RESNET34: BackboneSpec<ResNet> = BackboneSpec {
    name: "resnet34",
    about: "ResNet-34 (He et al. 2016): as accurate, twice the work",
    smallest_px: 1,
    narrowest: NARROWEST,
    build: |width, outputs, device| ResNet::new([3, 4, 6, 3], width, outputs, device),
};

/// A residual network of basic blocks.
#[derive(Module, Debug)]
pub(crate) struct ResNet {
    stem: ConvNorm,
    pool: MaxPool2d,
    stages: Vec<Vec<BasicBlock>>,
    mean: AdaptiveAvgPool2d,
    head: Linear,
}

/// Two 3x3 convolutions around which the input is added.
#[derive(Module, Debug)]
pub(crate) struct BasicBlock {
    first: ConvNorm,
    second: ConvNorm,
    /// A 1x1 convolution where the block changes the size; nothing elsewhere.
    shortcut: Option<ConvNorm>,
}

impl ResNet {
    /// The network with all weights zero, of `blocks` basic blocks in each stage.
    fn new(blocks: [usize; 4], width: f32, outputs: usize, device: &Device) -> Self {
        let channels = scaled(PUBLISHED_CHANNELS, width);
        // Each stage has twice the channels of the one before, at half of its sides.
        let stage = |index: usize| stage(channels << index, blocks[index], index > 0, device);
        Self {
            stem: ConvNormConfig::new(3, channels, 7).with_stride(2).init(device),
            pool: stem_pool(),
            stages: (0..4).map(stage).collect(),
            mean: AdaptiveAvgPool2dConfig::new([1, 1]).init(),
            head: linear(channels * 8, outputs, device),
        }
    }
}

/// The pooling behind the first layer: 3x3 pixels, stride 2.
pub(crate) fn stem_pool() -> MaxPool2d {
    MaxPool2dConfig::new([3, 3])
        .with_strides([2, 2])
        .with_padding(PaddingConfig2d::Explicit(1, 1, 1, 1))
        .init()
}

/// A stage of `blocks` blocks of `channels` channels. One that is `halved` halves the size of
/// images, which have half as many channels before it.
pub(crate) fn stage(
    channels: usize,
    blocks: usize,
    halved: bool,
    device: &Device,
) -> Vec<BasicBlock> {
    let first = match halved {
        false => BasicBlock::new(channels, channels, 1, device),
        true => BasicBlock::new(channels / 2, channels, 2, device),
    };
    let rest = (1..blocks).map(|_| BasicBlock::new(channels, channels, 1, device));
    std::iter::once(first).chain(rest).collect()
}

impl BackboneNet for ResNet {
    fn forward<N: NetOps>(&self, input: N) -> N::Vector {
        let mut x = self.stem.forward_relu(input).max_pool(&self.pool);
        for block in self.stages.iter().flatten() {
            x = block.forward(x);
        }
        x.avg_pool(&self.mean).linear(&self.head)
    }

    /// As torchvision initialises: Kaiming for convolutions, PyTorch's default for the head.
    fn initializer(&self, slot: &Slot) -> Initializer {
        match slot.layer.as_str() {
            "Conv2d" => Initializer::kaiming_fan_out(&slot.shape),
            "BatchNorm" => Initializer::batch_norm(slot.name()),
            _ => Initializer::torch_default(self.head.weight.dims()[0]),
        }
    }

    fn torchvision_path(&self, path: &str) -> String {
        torchvision_path(path)
    }
}

impl BasicBlock {
    fn new(channels_in: usize, channels_out: usize, stride: usize, device: &Device) -> Self {
        let conv = |channels_in, kernel| ConvNormConfig::new(channels_in, channels_out, kernel);
        Self {
            first: conv(channels_in, 3).with_stride(stride).init(device),
            second: conv(channels_out, 3).init(device),
            // Side and channels change together: with equal channels the input can be added
            // unchanged.
            shortcut: (channels_in != channels_out)
                .then(|| conv(channels_in, 1).with_stride(stride).init(device)),
        }
    }

    /// # Shapes
    /// - input: `[batch, channels_in, height, width]`
    /// - output: `[batch, channels_out, ceil(height / stride), ceil(width / stride)]`
    pub(crate) fn forward<N: NetOps>(&self, input: N) -> N {
        let x = self.second.forward(self.first.forward_relu(input.clone()));
        let shortcut = match &self.shortcut {
            Some(shortcut) => shortcut.forward(input),
            None => input,
        };
        x.add(shortcut).relu()
    }
}

/// `stages.0.1.first.conv.x` is `layer1.1.conv1.x`.
pub(crate) fn torchvision_path(path: &str) -> String {
    let parts: Vec<&str> = path.split('.').collect();
    match *parts.as_slice() {
        ["stem", "conv", name] => format!("conv1.{name}"),
        ["stem", "norm", name] => format!("bn1.{name}"),
        ["stages", stage, block, half, kind, name] => {
            // torchvision's layers begin at 1.
            let stage = stage.parse::<usize>().map_or(0, |index| index + 1);
            let layer = match (half, kind) {
                ("first", "conv") => "conv1",
                ("first", _) => "bn1",
                ("second", "conv") => "conv2",
                ("second", _) => "bn2",
                (_, "conv") => "downsample.0",
                _ => "downsample.1",
            };
            format!("layer{stage}.{block}.{layer}.{name}")
        }
        ["head", name] => format!("fc.{name}"),
        _ => path.to_owned(),
    }
}

//! MobileNetV2: inverted residuals of depthwise convolutions, layout and weights as torchvision's.
//!
//! torchvision's dropout of 0.2 before the head is left out: a regressor's output would be scaled
//! differently in training, and Burn draws dropout from one generator for all threads, which
//! would end the reproducibility of training.
//!
//! # Source
//! Sandler et al.: *MobileNetV2: Inverted Residuals and Linear Bottlenecks*, CVPR 2018, Table 2.

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

/// Table 2: expansion of the hidden channels, output channels, blocks, stride of the first block.
const STAGES: [(usize, f32, usize, usize); 7] = [
    (1, 16.0, 1, 1),
    (6, 24.0, 2, 2),
    (6, 32.0, 3, 2),
    (6, 64.0, 4, 2),
    (6, 96.0, 3, 1),
    (6, 160.0, 3, 2),
    (6, 320.0, 1, 1),
];
/// Channels of the first convolution.
const STEM_CHANNELS: f32 = 32.0;
/// Channels of the last convolution, which narrower networks keep.
const HEAD_CHANNELS: f32 = 1280.0;

pub(super) const MOBILENET_V2: BackboneSpec<MobileNetV2> = BackboneSpec {
    name: "mobilenet_v2",
    about: "MobileNetV2 (Sandler et al. 2018): a fifth of the parameters",
    smallest_px: 1,
    narrowest: 0.01,
    build: MobileNetV2::new,
};

/// A network of inverted residuals.
#[derive(Module, Debug)]
pub(crate) struct MobileNetV2 {
    stem: ConvNorm,
    blocks: Vec<InvertedResidual>,
    last: ConvNorm,
    mean: AdaptiveAvgPool2d,
    head: Linear,
}

/// Expand with 1x1, filter each channel with 3x3, project with 1x1; the input is added where the
/// shape allows.
#[derive(Module, Debug)]
struct InvertedResidual {
    /// Missing where the expansion is 1.
    expand: Option<ConvNorm>,
    depthwise: ConvNorm,
    project: ConvNorm,
    residual: bool,
}

impl MobileNetV2 {
    /// The network with all weights zero.
    fn new(width: f32, outputs: usize, device: &Device) -> Self {
        let stem = multiple_of_eight(STEM_CHANNELS * width);
        // As published: a narrower network keeps the width of its head.
        let last = multiple_of_eight(HEAD_CHANNELS * width.max(1.0));
        let mut blocks = Vec::new();
        let mut channels = stem;
        for (expansion, base, count, stride) in STAGES {
            let output = multiple_of_eight(base * width);
            for block in 0..count {
                // Only the first block of a stage halves the sides.
                let stride = if block == 0 { stride } else { 1 };
                blocks.push(InvertedResidual::new(channels, output, stride, expansion, device));
                channels = output;
            }
        }
        Self {
            stem: ConvNormConfig::new(3, stem, 3).with_stride(2).init(device),
            blocks,
            last: ConvNormConfig::new(channels, last, 1).init(device),
            mean: AdaptiveAvgPool2dConfig::new([1, 1]).init(),
            head: linear(last, outputs, device),
        }
    }
}

impl BackboneNet for MobileNetV2 {
    fn forward<N: NetOps>(&self, input: N) -> N::Vector {
        let mut x = self.stem.forward_relu6(input);
        for block in &self.blocks {
            x = block.forward(x);
        }
        let x = self.last.forward_relu6(x);
        x.avg_pool(&self.mean).linear(&self.head)
    }

    /// As torchvision initialises: Kaiming for convolutions, a narrow normal for the head.
    fn initializer(&self, slot: &Slot) -> Initializer {
        match slot.layer.as_str() {
            "Conv2d" => Initializer::kaiming_fan_out(&slot.shape),
            "BatchNorm" => Initializer::batch_norm(slot.name()),
            _ if slot.is_linear_weight() => Initializer::Normal { deviation: 0.01 },
            _ => Initializer::Constant(0.0),
        }
    }

    /// `blocks.3.depthwise.conv.x` is `features.4.conv.1.0.x`.
    fn torchvision_path(&self, path: &str) -> String {
        let parts: Vec<&str> = path.split('.').collect();
        let inner = |kind: &str| if kind == "conv" { 0 } else { 1 };
        match *parts.as_slice() {
            ["stem", kind, name] => format!("features.0.{}.{name}", inner(kind)),
            ["last", kind, name] => format!("features.18.{}.{name}", inner(kind)),
            ["head", name] => format!("classifier.1.{name}"),
            ["blocks", index, part, kind, name] => {
                let feature = index.parse::<usize>().map_or(0, |index| index + 1);
                // The first block does not expand: its parts stand one position earlier.
                let expanded = usize::from(feature > 1);
                let part = match part {
                    "expand" => format!("0.{}", inner(kind)),
                    "depthwise" => format!("{expanded}.{}", inner(kind)),
                    _ => format!("{}", 1 + expanded + inner(kind)),
                };
                format!("features.{feature}.conv.{part}.{name}")
            }
            _ => path.to_owned(),
        }
    }
}

impl InvertedResidual {
    fn new(
        channels_in: usize,
        channels_out: usize,
        stride: usize,
        expansion: usize,
        device: &Device,
    ) -> Self {
        let hidden = channels_in * expansion;
        Self {
            // Without an expansion the published block has no layer for it.
            expand: (expansion != 1)
                .then(|| ConvNormConfig::new(channels_in, hidden, 1).init(device)),
            depthwise: ConvNormConfig::new(hidden, hidden, 3)
                .with_stride(stride)
                .with_groups(hidden)
                .init(device),
            project: ConvNormConfig::new(hidden, channels_out, 1).init(device),
            residual: stride == 1 && channels_in == channels_out,
        }
    }

    /// # Shapes
    /// - input: `[batch, channels_in, height, width]`
    /// - output: `[batch, channels_out, ceil(height / stride), ceil(width / stride)]`
    fn forward<N: NetOps>(&self, input: N) -> N {
        let x = match &self.expand {
            Some(expand) => expand.forward_relu6(input.clone()),
            None => input.clone(),
        };
        let x = self.project.forward(self.depthwise.forward_relu6(x));
        if self.residual { x.add(input) } else { x }
    }
}

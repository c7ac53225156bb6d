//! VGG with batch normalisation: VGG-11, 13, 16 and 19, layout and weights as torchvision's.
//!
//! Stages of 3x3 convolutions, each halved by a 2x2 max-pool, an average over 7x7 fields whatever
//! the size of the image, and three fully connected layers that hold most of the parameters.
//! torchvision's dropout of 0.5 between those is left out, for the reasons given in
//! [`mobilenet_v2`](super::mobilenet_v2).
//!
//! # Source
//! Simonyan and Zisserman: *Very Deep Convolutional Networks for Large-Scale Image Recognition*,
//! ICLR 2015, Table 1, columns A, B, D and E.

use burn::module::Module;
use burn::nn::Linear;
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig, MaxPool2d, MaxPool2dConfig};
use burn::tensor::Device;

use super::spec::{BackboneNet, BackboneSpec};
use crate::channels::scaled;
use crate::conv_norm::{ConvNorm, ConvNormConfig};
use crate::initializer::Initializer;
use crate::linear::linear;
use crate::net_ops::{NetOps, VectorOps};
use crate::parameters::Slot;

/// Channels of the five stages as published.
const STAGE_CHANNELS: [usize; 5] = [64, 128, 256, 512, 512];
/// Outputs of the two fully connected layers before the last as published.
const HIDDEN: usize = 4096;
/// Fields along each axis that the last stage is averaged to.
const FIELDS: usize = 7;

/// The smallest side of an image: five times halved, it is still a pixel.
const SMALLEST_PX: usize = 1 << STAGE_CHANNELS.len();

/// VGG-11 with batch normalisation, configuration A of Table 1.
pub(super) const VGG11_BN: BackboneSpec<Vgg> = spec(
    "vgg11_bn",
    "VGG-11 with batch normalisation (Simonyan and Zisserman 2015): eleven times the parameters",
    |width, outputs, device| Vgg::new([1, 1, 2, 2, 2], width, outputs, device),
);

/// VGG-13 with batch normalisation, configuration B.
pub(super) const VGG13_BN: BackboneSpec<Vgg> = spec(
    "vgg13_bn",
    "VGG-13 with batch normalisation: two convolutions in every stage",
    |width, outputs, device| Vgg::new([2; 5], width, outputs, device),
);

/// VGG-16 with batch normalisation, configuration D.
pub(super) const VGG16_BN: BackboneSpec<Vgg> = spec(
    "vgg16_bn",
    "VGG-16 with batch normalisation: three convolutions in each of the last three stages",
    |width, outputs, device| Vgg::new([2, 2, 3, 3, 3], width, outputs, device),
);

/// VGG-19 with batch normalisation, configuration E.
pub(super) const VGG19_BN: BackboneSpec<Vgg> = spec(
    "vgg19_bn",
    "VGG-19 with batch normalisation: four convolutions in each of the last three stages",
    |width, outputs, device| Vgg::new([2, 2, 4, 4, 4], width, outputs, device),
);

const fn spec(
    name: &'static str,
    about: &'static str,
    build: fn(f32, usize, &Device) -> Vgg,
) -> BackboneSpec<Vgg> {
    BackboneSpec { name, about, smallest_px: SMALLEST_PX, narrowest: 1.0 / 64.0, build }
}

/// Stages of convolutions, then fully connected layers.
#[derive(Module, Debug)]
pub(crate) struct Vgg {
    stages: Vec<Vec<ConvNorm>>,
    pool: MaxPool2d,
    mean: AdaptiveAvgPool2d,
    hidden: Vec<Linear>,
    head: Linear,
}

impl Vgg {
    /// The network with all weights zero, of `convolutions` in each stage.
    fn new(convolutions: [usize; 5], width: f32, outputs: usize, device: &Device) -> Self {
        let mut channels = 3;
        let stages = STAGE_CHANNELS.iter().zip(convolutions).map(|(&published, count)| {
            let output = scaled(published, width);
            let stage = (0..count).map(|_| {
                // With a bias although a normalisation follows: torchvision's weights have one.
                let input = std::mem::replace(&mut channels, output);
                ConvNormConfig::new(input, output, 3).with_bias().init(device)
            });
            stage.collect()
        });
        // Collected here: the iterator borrows `channels`, which is read below.
        let stages = stages.collect();
        let hidden = scaled(HIDDEN, width);
        Self {
            stages,
            pool: MaxPool2dConfig::new([2, 2]).init(),
            mean: AdaptiveAvgPool2dConfig::new([FIELDS, FIELDS]).init(),
            hidden: vec![
                // Flattened: one weight for each channel and each of the last fields.
                linear(channels * FIELDS * FIELDS, hidden, device),
                linear(hidden, hidden, device),
            ],
            head: linear(hidden, outputs, device),
        }
    }
}

impl BackboneNet for Vgg {
    fn forward<N: NetOps>(&self, input: N) -> N::Vector {
        let mut x = input;
        for stage in &self.stages {
            for layer in stage {
                x = layer.forward_relu(x);
            }
            x = x.max_pool(&self.pool);
        }
        // Images of any size come to the fields that the linear layers have weights for.
        let mut x = x.avg_pool(&self.mean);
        for layer in &self.hidden {
            x = x.linear(layer).relu();
        }
        x.linear(&self.head)
    }

    /// As torchvision initialises: Kaiming for convolutions, narrow normals for the rest.
    fn initializer(&self, slot: &Slot) -> Initializer {
        match slot.layer.as_str() {
            "Conv2d" => Initializer::kaiming_fan_out(&slot.shape),
            "BatchNorm" => Initializer::batch_norm(slot.name()),
            _ if slot.is_linear_weight() => Initializer::Normal { deviation: 0.01 },
            _ => Initializer::Constant(0.0),
        }
    }

    /// `stages.2.1.conv.x` is `features.11.x`: layers are counted through, a convolution, its
    /// normalisation and its ReLU as three, a pooling as one.
    fn torchvision_path(&self, path: &str) -> String {
        let parts: Vec<&str> = path.split('.').collect();
        let index_of = |text: &str| text.parse::<usize>().unwrap_or(0);
        match *parts.as_slice() {
            ["stages", stage, index, kind, name] => {
                let stage = index_of(stage);
                let before: usize = self.stages.iter().take(stage).map(Vec::len).sum();
                let layer = 3 * (before + index_of(index)) + stage + usize::from(kind == "norm");
                format!("features.{layer}.{name}")
            }
            // A linear layer, its ReLU and its dropout count as three.
            ["hidden", index, name] => format!("classifier.{}.{name}", 3 * index_of(index)),
            ["head", name] => format!("classifier.{}.{name}", 3 * self.hidden.len()),
            _ => path.to_owned(),
        }
    }
}

//! The blocks of the network: depthwise separable convolutions and inverted residuals.

use burn::module::{self, Module};
use burn::nn::PaddingConfig2d;
use burn::nn::conv::{Conv2d, Conv2dConfig};
use burn::tensor::Device;

use crate::conv_norm::{ConvNorm, ConvNormConfig};
use crate::net_ops::NetOps;

/// A depthwise separable convolution: 3x3 of each channel, then 1x1.
#[derive(Module, Debug)]
pub(super) struct Separable {
    depthwise: ConvNorm,
    mix: ConvNorm,
}

impl Separable {
    pub(super) fn new(channels_in: usize, channels_out: usize, device: &Device) -> Self {
        Self {
            depthwise: depthwise(channels_in, 1).init(device),
            mix: ConvNormConfig::new(channels_in, channels_out, 1).init(device),
        }
    }

    /// With a ReLU between the two, and none at the end.
    pub(super) fn forward_relu_between<F: NetOps>(&self, input: F) -> F {
        self.mix.forward(self.depthwise.forward_relu(input))
    }

    /// With a ReLU at the end, and none between the two.
    pub(super) fn forward_relu_behind<F: NetOps>(&self, input: F) -> F {
        self.mix.forward_relu(self.depthwise.forward(input))
    }
}

/// An inverted bottleneck: 1x1 to more channels, 3x3 depthwise, 1x1 back.
#[derive(Module, Debug)]
struct Bottleneck {
    expand: ConvNorm,
    depthwise: ConvNorm,
    project: ConvNorm,
}

impl Bottleneck {
    fn forward<F: NetOps>(&self, input: F) -> F {
        let hidden = self.expand.forward_relu(input);
        self.project.forward(self.depthwise.forward_relu(hidden))
    }
}

/// A bottleneck that changes the shape, then one that is added to its own input again and again,
/// with the same weights each time.
///
/// In training each of its passes moves the running statistics of its normalisations.
#[derive(Module, Debug)]
pub(super) struct InvertedResidual {
    first: Bottleneck,
    /// Kept even if there are no repetitions, as the published checkpoints do.
    repeated: Bottleneck,
    repetitions: usize,
}

impl InvertedResidual {
    /// `channels` of the input, of both bottlenecks' insides and of the output.
    pub(super) fn new(
        [channels_in, hidden, channels_out]: [usize; 3],
        stride: usize,
        repetitions: usize,
        device: &Device,
    ) -> Self {
        let first = Bottleneck {
            expand: ConvNormConfig::new(channels_in, hidden, 1).init(device),
            // The published network has this bias, which the normalisation takes out again.
            depthwise: depthwise(hidden, stride).with_bias().init(device),
            project: ConvNormConfig::new(hidden, channels_out, 1).init(device),
        };
        // The published code repeats one module: all repetitions share its weights.
        let repeated = Bottleneck {
            expand: ConvNormConfig::new(channels_out, hidden, 1).init(device),
            depthwise: depthwise(hidden, 1).init(device),
            project: ConvNormConfig::new(hidden, channels_out, 1).init(device),
        };
        Self { first, repeated, repetitions }
    }

    /// # Shapes
    /// - input: `[batch, channels_in, height, width]`
    /// - output: `[batch, channels_out, ceil(height / stride), ceil(width / stride)]`
    pub(super) fn forward<F: NetOps>(&self, input: F) -> F {
        let mut x = self.first.forward(input);
        for _ in 0..self.repetitions {
            x = x.clone().add(self.repeated.forward(x));
        }
        x
    }
}

/// A depthwise separable convolution, then bilinear interpolation to twice the rows and columns.
#[derive(Module, Debug)]
pub(super) struct Upsampling {
    /// With a bias and without normalisation.
    depthwise: Conv2d,
    mix: ConvNorm,
}

impl Upsampling {
    pub(super) fn new(channels_in: usize, channels_out: usize, device: &Device) -> Self {
        let depthwise = Conv2dConfig::new([channels_in, channels_in], [3, 3])
            .with_padding(PaddingConfig2d::Explicit(1, 1, 1, 1))
            .with_groups(channels_in)
            .with_initializer(module::Initializer::Zeros)
            .init(device);
        Self { depthwise, mix: ConvNormConfig::new(channels_in, channels_out, 1).init(device) }
    }

    /// # Shapes
    /// - input: `[batch, channels_in, height, width]`
    /// - output: `[batch, channels_out, 2 height, 2 width]`
    pub(super) fn forward<F: NetOps>(&self, input: F) -> F {
        self.mix.forward_relu(input.conv(&self.depthwise).relu()).upsample()
    }
}

/// A 1x1 convolution without normalisation.
pub(crate) fn pointwise(
    channels_in: usize,
    channels_out: usize,
    bias: bool,
    device: &Device,
) -> Conv2d {
    Conv2dConfig::new([channels_in, channels_out], [1, 1])
        .with_padding(PaddingConfig2d::Explicit(0, 0, 0, 0))
        .with_bias(bias)
        .with_initializer(module::Initializer::Zeros)
        .init(device)
}

fn depthwise(channels: usize, stride: usize) -> ConvNormConfig {
    ConvNormConfig::new(channels, channels, 3).with_stride(stride).with_groups(channels)
}

//! The residual blocks of the heatmap networks: at the same size, to half of it, and to twice.

use burn::module::{self, Module};
use burn::nn::BatchNorm;
use burn::nn::conv::{ConvTranspose2d, ConvTranspose2dConfig};
use burn::tensor::module::conv_transpose2d;
use burn::tensor::ops::ConvTransposeOptions;
use burn::tensor::{Device, Tensor};

use crate::conv_norm::{ConvNorm, ConvNormConfig, EPSILON, batch_norm};
use crate::ops::{self, Activation};

/// Two 3x3 convolutions with a ReLU behind each, around which a 1x1 convolution of the input is
/// added.
#[derive(Module, Debug)]
pub(super) struct ResidualBlock {
    first: ConvNorm,
    second: ConvNorm,
    shortcut: ConvNorm,
}

impl ResidualBlock {
    pub(super) fn new(
        channels_in: usize,
        channels_out: usize,
        stride: usize,
        device: &Device,
    ) -> Self {
        let conv = |channels_in, kernel| ConvNormConfig::new(channels_in, channels_out, kernel);
        Self {
            first: conv(channels_in, 3).with_stride(stride).init(device),
            second: conv(channels_out, 3).init(device),
            // As published, the shortcut has a convolution even where the input could be added
            // unchanged.
            shortcut: conv(channels_in, 1).with_stride(stride).init(device),
        }
    }

    /// # Shapes
    /// - input: `[batch, channels_in, height, width]`
    /// - output: `[batch, channels_out, ceil(height / stride), ceil(width / stride)]`
    pub(super) fn forward(&self, input: Tensor<4>) -> Tensor<4> {
        let main = self.second.forward_relu(self.first.forward_relu(input.clone()));
        main + self.shortcut.forward(input)
    }
}

/// A [`ResidualBlock`] at twice the rows and columns: its first convolutions are transposed.
#[derive(Module, Debug)]
pub(super) struct UpsamplingBlock {
    first: TransposedNorm,
    second: ConvNorm,
    shortcut: TransposedNorm,
}

impl UpsamplingBlock {
    pub(super) fn new(channels_in: usize, channels_out: usize, device: &Device) -> Self {
        Self {
            first: TransposedNorm::new(channels_in, channels_out, 3, device),
            second: ConvNormConfig::new(channels_out, channels_out, 3).init(device),
            shortcut: TransposedNorm::new(channels_in, channels_out, 1, device),
        }
    }

    /// # Shapes
    /// - input: `[batch, channels_in, ceil(height / 2), ceil(width / 2)]`
    /// - output: `[batch, channels_out, height, width]`, its size as given
    pub(super) fn forward(&self, input: Tensor<4>, size: [usize; 2]) -> Tensor<4> {
        let main = self.first.forward(input.clone(), size, Activation::Relu);
        let shortcut = self.shortcut.forward(input, size, Activation::Identity);
        self.second.forward_relu(main) + shortcut
    }
}

/// A transposed convolution of stride 2, then batch normalisation.
#[derive(Module, Debug)]
struct TransposedNorm {
    conv: ConvTranspose2d,
    norm: BatchNorm,
}

impl TransposedNorm {
    fn new(channels_in: usize, channels_out: usize, kernel: usize, device: &Device) -> Self {
        let conv = ConvTranspose2dConfig::new([channels_in, channels_out], [kernel; 2])
            .with_stride([2, 2])
            .with_padding([kernel / 2; 2])
            .with_bias(false)
            .with_initializer(module::Initializer::Zeros)
            .init(device);
        Self { conv, norm: batch_norm(channels_out, EPSILON, device) }
    }

    fn forward(
        &self,
        input: Tensor<4>,
        [height, width]: [usize; 2],
        activation: Activation,
    ) -> Tensor<4> {
        let [_, _, rows, columns] = input.dims();
        // Odd sizes need nothing beyond what the pixels of the input reach, even ones a line.
        let beyond = [height + 1 - 2 * rows, width + 1 - 2 * columns];
        let ConvTranspose2d { stride, padding, dilation, groups, .. } = self.conv;
        let options = ConvTransposeOptions::new(stride, padding, beyond, dilation, groups);
        let output = conv_transpose2d(input, self.conv.weight.val(), None, options);
        ops::batch_norm(&self.norm, output, activation)
    }
}

//! A convolution followed by batch normalisation, of which every backbone is built.

use burn::module::{Initializer, Module, RunningState};
use burn::nn::conv::{Conv2d, Conv2dConfig};
use burn::nn::{BatchNorm, BatchNormConfig, PaddingConfig2d};
use burn::tensor::Device;

use crate::net_ops::NetOps;
use crate::ops::Activation;

/// Shape of a [`ConvNorm`]: by default a square kernel that keeps the image size, up to its stride.
#[derive(Debug, Clone, Copy)]
pub struct ConvNormConfig {
    /// Channels of the input.
    pub channels_in: usize,
    /// Channels of the output.
    pub channels_out: usize,
    /// Rows and columns of the kernel.
    pub kernel: [usize; 2],
    /// Zeros above and below, and on the left and on the right.
    pub padding: [usize; 2],
    /// Vertical and horizontal stride, in pixels.
    pub stride: usize,
    /// Groups of channels; each is convolved by itself.
    pub groups: usize,
    /// Whether the convolution has a bias, which the normalisation takes out again.
    pub bias: bool,
    /// Summand of the variance in the normalisation.
    pub epsilon: f64,
}

/// PyTorch's default.
pub(crate) const EPSILON: f64 = 1e-5;
/// Ids of the running statistics, the same in every layer: see [`batch_norm`].
const MEAN: u64 = 1;
const VARIANCE: u64 = 2;

/// `norm(conv(x))`.
#[derive(Module, Debug)]
pub struct ConvNorm {
    /// Weight of shape `[channels_out, channels_in / groups, rows, columns]`.
    pub conv: Conv2d,
    /// All tensors of shape `[channels_out]`.
    pub norm: BatchNorm,
}

impl ConvNormConfig {
    /// A `kernel` x `kernel` convolution, of odd `kernel`, that mixes all channels.
    pub fn new(channels_in: usize, channels_out: usize, kernel: usize) -> Self {
        Self::rectangular(channels_in, channels_out, [kernel; 2])
    }

    /// A convolution with a kernel of these rows and columns, over all channels.
    pub fn rectangular(channels_in: usize, channels_out: usize, kernel: [usize; 2]) -> Self {
        let padding = kernel.map(|side| side / 2);
        let (stride, groups, bias) = (1, 1, false);
        Self { channels_in, channels_out, kernel, padding, stride, groups, bias, epsilon: EPSILON }
    }

    /// Without padding: the image shrinks by the kernel less one.
    pub fn without_padding(self) -> Self {
        Self { padding: [0; 2], ..self }
    }

    /// With another summand of the variance than 1e-5.
    pub fn with_epsilon(self, epsilon: f64) -> Self {
        Self { epsilon, ..self }
    }

    /// With another stride than 1.
    pub fn with_stride(self, stride: usize) -> Self {
        Self { stride, ..self }
    }

    /// With more groups than 1; as many as channels make a depthwise convolution.
    pub fn with_groups(self, groups: usize) -> Self {
        Self { groups, ..self }
    }

    /// With a bias.
    pub fn with_bias(self) -> Self {
        Self { bias: true, ..self }
    }

    /// The layers; weights are zero until [`crate::parameters::fill`] gives them values.
    pub fn init(self, device: &Device) -> ConvNorm {
        let Self { channels_in, channels_out, kernel, padding, stride, groups, bias, epsilon } =
            self;
        let [rows, columns] = padding;
        let conv = Conv2dConfig::new([channels_in, channels_out], kernel)
            .with_stride([stride, stride])
            .with_padding(PaddingConfig2d::Explicit(rows, columns, rows, columns))
            .with_groups(groups)
            .with_bias(bias)
            .with_initializer(Initializer::Zeros)
            .init(device);
        ConvNorm { conv, norm: batch_norm(channels_out, epsilon, device) }
    }
}

/// A batch normalisation of `channels` channels, with fixed ids of its running statistics.
pub(crate) fn batch_norm(channels: usize, epsilon: f64, device: &Device) -> BatchNorm {
    let mut norm = BatchNormConfig::new(channels).with_epsilon(epsilon).init(device);
    // Burn draws the ids of running statistics at random and never changes them afterwards.
    // No optimiser asks for them; fixed ones make checkpoints the same bytes in every run.
    norm.running_mean = RunningState::with_id(MEAN.into(), norm.running_mean.value());
    norm.running_var = RunningState::with_id(VARIANCE.into(), norm.running_var.value());
    norm
}

impl ConvNorm {
    /// `norm(conv(x))`.
    ///
    /// # Shapes
    /// - input: `[batch, channels_in, height, width]`
    /// - output: `[batch, channels_out, ceil(height / stride), ceil(width / stride)]`, or less
    ///   without padding
    pub fn forward<F: NetOps>(&self, input: F) -> F {
        input.conv_norm(self, Activation::Identity)
    }

    /// `relu(norm(conv(x)))`, shapes as in [`forward`](Self::forward).
    pub fn forward_relu<F: NetOps>(&self, input: F) -> F {
        input.conv_norm(self, Activation::Relu)
    }

    /// `min(relu(norm(conv(x))), 6)`, shapes as in [`forward`](Self::forward).
    pub fn forward_relu6<F: NetOps>(&self, input: F) -> F {
        input.conv_norm(self, Activation::Relu6)
    }
}

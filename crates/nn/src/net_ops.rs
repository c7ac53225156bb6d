//! The operations of networks, over which every forward pass is generic.
//!
//! One forward pass serves three purposes: with tensors it computes, with blocked tensors it trains
//! on the CPU, and with the nodes of a [`Graph`] it is traced, for engines that compile networks.
//!
//! [`Graph`]: crate::graph::Graph

use std::ops::Range;

use burn::nn::Linear;
use burn::nn::conv::Conv2d;
use burn::nn::pool::{AdaptiveAvgPool2d, MaxPool2d};
use burn::tensor::Tensor;
use burn::tensor::activation::{relu, sigmoid};
use burn::tensor::module::avg_pool2d;
use burn::tensor::ops::AvgPoolOptions;

use crate::conv_norm::ConvNorm;
use crate::ops::{self, Activation};

/// A batch of feature maps `[batch, channels, height, width]` and the operations on it, named as in
/// PyTorch.
pub trait NetOps: Clone + 'static {
    /// A batch of vectors: the input of fully connected layers.
    type Vector: VectorOps;

    /// Number of channels.
    fn channels(&self) -> usize;

    /// `layer.forward(self)`.
    fn conv(self, layer: &Conv2d) -> Self;

    /// Convolution, batch normalisation, then `activation`.
    fn conv_norm(self, layer: &ConvNorm, activation: Activation) -> Self;

    /// `layer.forward(self)`.
    fn max_pool(self, layer: &MaxPool2d) -> Self;

    /// Elementwise sum.
    fn add(self, other: Self) -> Self;

    /// `max(self, 0)`.
    fn relu(self) -> Self;

    /// The feature maps of a range of channels.
    fn narrow(self, channels: Range<usize>) -> Self;

    /// The channels of both, alternating: the channel shuffle of two groups.
    fn interleave(self, other: Self) -> Self;

    /// The channels of several feature maps of one size, one map after the other, as `torch.cat`.
    ///
    /// # Panics
    /// If there are none.
    fn concat(parts: Vec<Self>) -> Self;

    /// The mean of each pixel and its eight neighbours, zeros beyond the edges counted:
    /// `avg_pool2d(kernel_size=3, stride=1, padding=1)`.
    fn local_mean(self) -> Self;

    /// Twice as many rows and columns by bilinear interpolation, as
    /// `interpolate(scale_factor=2, mode="bilinear", align_corners=False)`.
    fn upsample(self) -> Self;

    /// The logistic function, `1 / (1 + exp(-self))`.
    fn sigmoid(self) -> Self;

    /// `factor * self + offset`.
    fn affine(self, factor: f32, offset: f32) -> Self;

    /// Adaptive average pooling, flattened.
    fn avg_pool(self, layer: &AdaptiveAvgPool2d) -> Self::Vector;
}

/// A batch of vectors `[batch, values]` and the operations on it.
pub trait VectorOps: Clone + 'static {
    /// `layer.forward(self)`.
    fn linear(self, layer: &Linear) -> Self;

    /// `max(self, 0)`.
    fn relu(self) -> Self;
}

impl NetOps for Tensor<4> {
    type Vector = Tensor<2>;

    fn channels(&self) -> usize {
        self.dims()[1]
    }

    fn conv(self, layer: &Conv2d) -> Self {
        ops::conv2d(layer, self)
    }

    fn conv_norm(self, layer: &ConvNorm, activation: Activation) -> Self {
        ops::batch_norm(&layer.norm, ops::conv2d(&layer.conv, self), activation)
    }

    fn max_pool(self, layer: &MaxPool2d) -> Self {
        layer.forward(self)
    }

    fn add(self, other: Self) -> Self {
        self + other
    }

    fn relu(self) -> Self {
        relu(self)
    }

    fn narrow(self, channels: Range<usize>) -> Self {
        Tensor::narrow(self, 1, channels.start, channels.len())
    }

    fn interleave(self, other: Self) -> Self {
        let [batch, channels, height, width] = self.dims();
        let pairs: Tensor<5> = Tensor::stack(vec![self, other], 2);
        pairs.reshape([batch, 2 * channels, height, width])
    }

    fn concat(parts: Vec<Self>) -> Self {
        Tensor::cat(parts, 1)
    }

    fn local_mean(self) -> Self {
        let options = AvgPoolOptions::new([3, 3]).with_stride([1, 1]).with_padding([1, 1]);
        avg_pool2d(self, options.with_count_include_pad(true))
    }

    fn upsample(self) -> Self {
        ops::upsample(self)
    }

    fn sigmoid(self) -> Self {
        sigmoid(self)
    }

    fn affine(self, factor: f32, offset: f32) -> Self {
        self * factor + offset
    }

    fn avg_pool(self, layer: &AdaptiveAvgPool2d) -> Self::Vector {
        layer.forward(self).flatten(1, 3)
    }
}

impl VectorOps for Tensor<2> {
    fn linear(self, layer: &Linear) -> Self {
        // Few products: in 32 bits also where the layers before are not.
        layer.forward(ops::widened(self))
    }

    fn relu(self) -> Self {
        relu(self)
    }
}

//! What flows through a network, so that each is written once.
//!
//! The forward pass of a network is generic: with tensors it is computed, with a [`Graph`] it is
//! written down, for engines that compile networks.
//!
//! [`Graph`]: crate::graph::Graph

use std::ops::Range;

use burn::nn::Linear;
use burn::nn::conv::Conv2d;
use burn::nn::pool::{AdaptiveAvgPool2d, MaxPool2d};
use burn::tensor::Tensor;
use burn::tensor::activation::{relu, sigmoid};
use burn::tensor::module::interpolate;
use burn::tensor::ops::{InterpolateMode, InterpolateOptions};

use crate::conv_norm::ConvNorm;
use crate::ops::{self, Activation};

/// Images `[batch, channels, height, width]` on their way through a network.
pub(crate) trait NetOps: Clone {
    /// What images become where layers are fully connected.
    type Vector: VectorOps;

    /// Channels.
    fn channels(&self) -> usize;

    /// `layer.forward(self)`.
    fn conv(self, layer: &Conv2d) -> Self;

    /// The layers of `layer` and the activation behind them.
    fn conv_norm(self, layer: &ConvNorm, activation: Activation) -> Self;

    /// `layer.forward(self)`.
    fn max_pool(self, layer: &MaxPool2d) -> Self;

    /// The sum of both.
    fn add(self, other: Self) -> Self;

    /// Negative values become 0.
    fn relu(self) -> Self;

    /// Some of the channels.
    fn narrow(self, channels: Range<usize>) -> Self;

    /// The channels of both in turn: the first of one, the first of the other, the second of one.
    fn interleave(self, other: Self) -> Self;

    /// Twice as many rows and columns, each value between the four nearest pixels; pixels are squares
    /// about their centres, and beyond the outermost centres the values stay.
    fn upsample(self) -> Self;

    /// `1 / (1 + exp(-self))`.
    fn sigmoid(self) -> Self;

    /// `factor * self + offset`.
    fn affine(self, factor: f32, offset: f32) -> Self;

    /// Means, flattened.
    fn avg_pool(self, layer: &AdaptiveAvgPool2d) -> Self::Vector;
}

/// Vectors `[batch, values]` on their way through a network.
pub(crate) trait VectorOps: Clone {
    /// `layer.forward(self)`.
    fn linear(self, layer: &Linear) -> Self;

    /// Negative values become 0.
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
        ops::max_pool(layer, self)
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

    fn upsample(self) -> Self {
        let [_, _, height, width] = self.dims();
        let options = InterpolateOptions::new(InterpolateMode::Bilinear)
            .with_align_corners(false)
            .with_output_size([2 * height, 2 * width]);
        interpolate(self, options)
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
        layer.forward(self)
    }

    fn relu(self) -> Self {
        relu(self)
    }
}

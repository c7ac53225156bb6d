//! What flows through a ResNet in training on the CPU: batches in blocks of sixteen channels.
//!
//! A normalisation is done by whoever takes its result, so that only its input is kept; a sum waits for
//! the activation behind it. What has no operation of its own goes through planes.

use std::ops::Range;

use burn::backend::Dispatch;
use burn::nn::conv::Conv2d;
use burn::nn::pool::{AdaptiveAvgPool2d, MaxPool2d};
use burn::nn::{BatchNorm, PaddingConfig2d};
use burn::tensor::Tensor;
use burn::tensor::activation::relu;
use evpose_kernels::Level;
use evpose_kernels::training::{Blocks, Conv};

use super::blocked_backend::{BlockedOps, How};
use super::{Activation, is_residual_pool, update_running};
use crate::conv_norm::ConvNorm;
use crate::net_ops::NetOps;

/// A batch in blocks, or what becomes of one.
#[derive(Clone)]
pub(crate) struct Blocked {
    shape: Blocks,
    state: LazyActivation,
}

#[derive(Clone)]
#[allow(clippy::large_enum_variant, reason = "one for each layer, never in a collection")]
enum LazyActivation {
    /// `[batch, blocks, height, width, 16]`.
    Values(Tensor<5>),
    Normed(Normed),
    Sum(Normed, Tensor<5>),
}

/// Values that are normalised by whoever takes them.
#[derive(Clone)]
struct Normed {
    values: Tensor<5>,
    gamma: Tensor<1>,
    beta: Tensor<1>,
    mean: Tensor<1>,
    variance: Tensor<1>,
    how: How,
}

macro_rules! call {
    ($operation:ident, $normed:expr $(, $more:expr)*) => {{
        let Normed { values, gamma, beta, mean, variance, how } = $normed;
        Dispatch::$operation(
            values.into_dispatch(),
            gamma.into_dispatch(),
            beta.into_dispatch(),
            mean.into_dispatch(),
            variance.into_dispatch(),
            how,
            $($more,)*
        )
    }};
}

impl Blocked {
    /// From `[batch, channels, height, width]`.
    pub(crate) fn from_planes(planes: Tensor<4>) -> Self {
        let [batch, channels, height, width] = planes.dims();
        let shape = Blocks { batch, channels, height, width };
        let values = Dispatch::blocked_from_planes(planes.into_dispatch());
        Self { shape, state: LazyActivation::Values(Tensor::from_dispatch(values)) }
    }

    /// To `[batch, channels, height, width]`.
    fn into_planes(self) -> Tensor<4> {
        let channels = self.shape.channels;
        let values = self.into_values().into_dispatch();
        Tensor::from_dispatch(Dispatch::blocked_to_planes(values, channels))
    }

    /// Whatever is still to be done, done.
    fn into_values(self) -> Tensor<5> {
        match self.state {
            LazyActivation::Values(values) => values,
            LazyActivation::Normed(normed) => Tensor::from_dispatch(call!(blocked_norm, normed)),
            LazyActivation::Sum(normed, other) => added(normed, other, Activation::Identity),
        }
    }

    fn through_planes(self, layer: impl FnOnce(Tensor<4>) -> Tensor<4>) -> Self {
        Self::from_planes(layer(self.into_planes()))
    }

    /// The shape of a convolution, if it is one of ours.
    fn ours(&self, layer: &Conv2d, norm: &BatchNorm) -> Option<Conv> {
        let [channels_out, channels_in, kernel, across] = layer.weight.dims();
        let [stride, stride_x] = layer.stride;
        let half = kernel / 2;
        let is_ours = channels_in == self.shape.channels
            && kernel == across
            && kernel % 2 == 1
            && stride == stride_x
            && matches!(stride, 1 | 2)
            && layer.groups == 1
            && layer.dilation == [1, 1]
            && layer.bias.is_none()
            && layer.padding == PaddingConfig2d::Explicit(half, half, half, half)
            && norm.training.is_enabled();
        is_ours.then_some(Conv {
            input: self.shape,
            channels_out,
            kernel,
            stride,
            level: Level::best(),
        })
    }
}

fn added(normed: Normed, other: Tensor<5>, activation: Activation) -> Tensor<5> {
    Tensor::from_dispatch(call!(blocked_norm_add, normed, other.into_dispatch(), activation))
}

impl NetOps for Blocked {
    type Vector = Tensor<2>;

    fn channels(&self) -> usize {
        self.shape.channels
    }

    fn conv(self, layer: &Conv2d) -> Self {
        self.through_planes(|planes| planes.conv(layer))
    }

    fn conv_norm(self, layer: &ConvNorm, activation: Activation) -> Self {
        let ConvNorm { conv, norm } = layer;
        let Some(shape) = self.ours(conv, norm) else {
            return self.through_planes(|planes| planes.conv_norm(layer, activation));
        };
        let weight = conv.weight.val().into_dispatch();
        let (values, mean, variance) = match self.state {
            LazyActivation::Normed(normed) => call!(blocked_norm_conv, normed, weight, shape),
            _ => Dispatch::blocked_conv(self.into_values().into_dispatch(), weight, shape),
        };
        let (mean, variance) = (Tensor::from_dispatch(mean), Tensor::from_dispatch(variance));
        update_running(norm, &mean, &variance);
        let normed = Normed {
            values: Tensor::from_dispatch(values),
            gamma: norm.gamma.val(),
            beta: norm.beta.val(),
            mean,
            variance,
            how: How { epsilon: norm.epsilon as f32, activation },
        };
        Self { shape: shape.output(), state: LazyActivation::Normed(normed) }
    }

    fn max_pool(self, layer: &MaxPool2d) -> Self {
        match self.state {
            LazyActivation::Normed(normed) if is_residual_pool(layer) => {
                let [height, width] =
                    [self.shape.height, self.shape.width].map(|side| side.div_ceil(2));
                let values = Tensor::from_dispatch(call!(blocked_norm_max_pool, normed));
                let shape = Blocks { height, width, ..self.shape };
                Self { shape, state: LazyActivation::Values(values) }
            }
            _ => self.through_planes(|planes| planes.max_pool(layer)),
        }
    }

    fn add(self, other: Self) -> Self {
        let shape = self.shape;
        let state = match self.state {
            LazyActivation::Normed(normed) => LazyActivation::Sum(normed, other.into_values()),
            _ => LazyActivation::Values(self.into_values() + other.into_values()),
        };
        Self { shape, state }
    }

    fn relu(self) -> Self {
        let shape = self.shape;
        let values = match self.state {
            LazyActivation::Sum(normed, other) => added(normed, other, Activation::Relu),
            _ => relu(self.into_values()),
        };
        Self { shape, state: LazyActivation::Values(values) }
    }

    fn narrow(self, channels: Range<usize>) -> Self {
        self.through_planes(|planes| NetOps::narrow(planes, channels))
    }

    fn interleave(self, other: Self) -> Self {
        let other = other.into_planes();
        self.through_planes(|planes| planes.interleave(other))
    }

    fn upsample(self) -> Self {
        self.through_planes(NetOps::upsample)
    }

    fn sigmoid(self) -> Self {
        self.through_planes(NetOps::sigmoid)
    }

    fn affine(self, factor: f32, offset: f32) -> Self {
        self.through_planes(|planes| planes.affine(factor, offset))
    }

    fn avg_pool(self, layer: &AdaptiveAvgPool2d) -> Self::Vector {
        self.into_planes().avg_pool(layer)
    }
}

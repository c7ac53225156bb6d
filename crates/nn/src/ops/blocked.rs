//! Batches in the layout nChw16c on their way through a network in training on the CPU.
//!
//! A normalisation is computed by the consumers of its result, so that only its input is stored; a
//! sum waits for the activation behind it. Operations without a kernel of their own run in planes,
//! as Burn's, and their results stay there until a kernel reads them.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use burn::backend::Dispatch;
use burn::backend::tensor::FloatTensor;
use burn::nn::PaddingConfig2d;
use burn::nn::conv::Conv2d;
use burn::nn::pool::{AdaptiveAvgPool2d, MaxPool2d};
use burn::tensor::Tensor;
use burn::tensor::activation::relu;
use evpose_kernels::training::{Blocks, MaxPool, Upsample};

use super::backend::{BlockedOp, NormSettings, OpSettings, TrainingOps};
use super::layer::ConvLayer;
use super::unary::UnaryOp;
use super::{Activation, update_running};
use crate::conv_norm::ConvNorm;
use crate::net_ops::NetOps;

/// A batch, or the operations that are still to be applied to one.
#[derive(Clone)]
pub(crate) struct Blocked {
    shape: Blocks,
    values: LazyValues,
}

#[derive(Clone)]
#[allow(clippy::large_enum_variant, reason = "one for each layer, never in a collection")]
enum LazyValues {
    /// `[batch, channels, height, width]`.
    Planes(Tensor<4>),
    /// `[batch, blocks, height, width, 16]`.
    Blocks(Tensor<5>),
    Normalized(Normalized),
    Sum(LazySum),
}

/// Values in nChw16c, which their consumers normalise while they read.
#[derive(Clone)]
struct Normalized {
    values: Tensor<5>,
    gamma: Tensor<1>,
    beta: Tensor<1>,
    mean: Tensor<1>,
    variance: Tensor<1>,
    settings: NormSettings,
}

/// A sum that waits for its activation.
#[derive(Clone)]
struct LazySum {
    normalized: Normalized,
    other: Tensor<5>,
    /// The sum itself, once one of the clones needed it.
    identity: Arc<OnceLock<Tensor<5>>>,
}

/// The input of an operation: values, then gamma, beta, mean and variance.
struct Operand {
    values: Tensor<5>,
    norm: [Tensor<1>; 4],
    settings: Option<NormSettings>,
}

impl From<Normalized> for Operand {
    fn from(normalized: Normalized) -> Self {
        let Normalized { values, gamma, beta, mean, variance, settings } = normalized;
        Self { values, norm: [gamma, beta, mean, variance], settings: Some(settings) }
    }
}

impl From<Tensor<5>> for Operand {
    fn from(values: Tensor<5>) -> Self {
        // Operations take tensors whether they read them or not.
        let unused = Tensor::zeros([1], &values.device());
        Self { values, norm: [(); 4].map(|()| unused.clone()), settings: None }
    }
}

impl Operand {
    fn applied(
        self,
        op: BlockedOp,
        channels: usize,
        taken: [Option<FloatTensor<Dispatch>>; 2],
    ) -> Tensor<5> {
        // Operations of Burn take a fixed number of tensors: one value stands for those not taken.
        let unused = || Tensor::<1>::zeros([1], &self.values.device()).into_dispatch();
        let [first, second] = taken.map(|tensor| tensor.unwrap_or_else(unused));
        let [gamma, beta, mean, variance] = self.norm.map(Tensor::into_dispatch);
        let settings = OpSettings { norm: self.settings, channels, op };
        Tensor::from_dispatch(Dispatch::blocked_op(
            self.values.into_dispatch(),
            gamma,
            beta,
            mean,
            variance,
            first,
            second,
            settings,
        ))
    }

    fn unary(self, op: UnaryOp, channels: usize) -> Tensor<5> {
        self.applied(BlockedOp::Unary(op), channels, [None, None])
    }
}

impl LazySum {
    fn with(self, activation: Activation, channels: usize) -> Tensor<5> {
        let other = [Some(self.other.into_dispatch()), None];
        Operand::from(self.normalized).applied(BlockedOp::Add(activation), channels, other)
    }
}

impl Blocked {
    /// From `[batch, channels, height, width]`.
    pub(crate) fn from_planes(planes: Tensor<4>) -> Self {
        let [batch, channels, height, width] = planes.dims();
        let shape = Blocks { batch, channels, height, width };
        Self { shape, values: LazyValues::Planes(planes) }
    }

    /// To `[batch, channels, height, width]`.
    pub(crate) fn into_planes(self) -> Tensor<4> {
        if let LazyValues::Planes(planes) = self.values {
            return planes;
        }
        let channels = self.shape.channels;
        let blocks = self.into_blocks().into_dispatch();
        Tensor::from_dispatch(Dispatch::blocked_to_planes(blocks, channels))
    }

    /// The values in nChw16c, with all operations applied.
    fn into_blocks(self) -> Tensor<5> {
        let channels = self.shape.channels;
        match self.values {
            LazyValues::Planes(planes) => {
                Tensor::from_dispatch(Dispatch::blocked_from_planes(planes.into_dispatch()))
            }
            LazyValues::Blocks(values) => values,
            LazyValues::Normalized(normalized) => {
                Operand::from(normalized).unary(UnaryOp::Materialize, channels)
            }
            LazyValues::Sum(sum) => {
                // Computed once, however many layers read the sum before its activation is known.
                let identity = sum.identity.clone();
                identity.get_or_init(|| sum.with(Activation::Identity, channels)).clone()
            }
        }
    }

    /// The values as operations take them, normalised or not.
    fn into_operand(self) -> Operand {
        match self.values {
            LazyValues::Normalized(normalized) => normalized.into(),
            _ => self.into_blocks().into(),
        }
    }

    fn through_planes(self, layer: impl FnOnce(Tensor<4>) -> Tensor<4>) -> Self {
        Self::from_planes(layer(self.into_planes()))
    }

    fn convolved(self, layer: &Conv2d, shape: ConvLayer) -> Tensor<5> {
        let channels = self.shape.channels;
        let bias = layer.bias.as_ref().map(|bias| bias.val().into_dispatch());
        let op = BlockedOp::Conv { layer: shape, has_bias: bias.is_some() };
        let weight = layer.weight.val().into_dispatch();
        self.into_operand().applied(op, channels, [Some(weight), bias])
    }
}

/// The shape of a max-pooling of stride 2 over 2x2 or 3x3 pixels; none for others.
fn max_pool(layer: &MaxPool2d, input: Blocks) -> Option<MaxPool> {
    let [kernel, across] = layer.kernel_size;
    let padding = match layer.padding {
        PaddingConfig2d::Valid => 0,
        PaddingConfig2d::Explicit(top, left, bottom, right)
            if [left, bottom, right] == [top; 3] =>
        {
            top
        }
        _ => return None,
    };
    // The kernels know the pools of the networks here; others go through planes.
    let is_supported = kernel == across
        && matches!(kernel, 2 | 3)
        && padding < kernel
        && layer.stride == [2, 2]
        && layer.dilation == [1, 1]
        && !layer.ceil_mode;
    is_supported.then_some(MaxPool { input, kernel, padding })
}

impl NetOps for Blocked {
    type Vector = Tensor<2>;

    fn channels(&self) -> usize {
        self.shape.channels
    }

    fn conv(self, layer: &Conv2d) -> Self {
        let Some(shape) = ConvLayer::new(layer, self.shape) else {
            return self.through_planes(|planes| planes.conv(layer));
        };
        let values = LazyValues::Blocks(self.convolved(layer, shape));
        Self { shape: shape.output(), values }
    }

    fn conv_norm(self, layer: &ConvNorm, activation: Activation) -> Self {
        let ConvNorm { conv, norm } = layer;
        let shape = ConvLayer::new(conv, self.shape);
        // Only training needs the batch's statistics: all else takes the usual way.
        let Some(shape) = shape.filter(|_| norm.training.is_enabled()) else {
            return self.through_planes(|planes| planes.conv_norm(layer, activation));
        };
        let values = self.convolved(conv, shape);
        let channels = shape.output().channels;
        let (mean, variance) =
            Dispatch::blocked_statistics(values.clone().into_dispatch(), channels);
        let (mean, variance) = (Tensor::from_dispatch(mean), Tensor::from_dispatch(variance));
        // Running statistics are for inference: no gradient goes through them.
        update_running(norm, &mean, &variance);
        let normalized = Normalized {
            values,
            gamma: norm.gamma.val(),
            beta: norm.beta.val(),
            mean,
            variance,
            settings: NormSettings { epsilon: norm.epsilon as f32, activation },
        };
        // The normalisation is left to the next layer, which applies it while it reads.
        Self { shape: shape.output(), values: LazyValues::Normalized(normalized) }
    }

    fn max_pool(self, layer: &MaxPool2d) -> Self {
        let input = self.shape;
        let Some(pool) = max_pool(layer, input) else {
            return self.through_planes(|planes| planes.max_pool(layer));
        };
        let values = self.into_operand().unary(UnaryOp::MaxPool(pool), input.channels);
        Self { shape: pool.output(), values: LazyValues::Blocks(values) }
    }

    fn add(self, other: Self) -> Self {
        let shape = self.shape;
        // The sum normalises one operand while it reads; the other has to be in memory.
        let values = match (self.values, other.values) {
            (LazyValues::Normalized(normalized), other)
            | (other, LazyValues::Normalized(normalized)) => {
                let other = Self { shape, values: other }.into_blocks();
                LazyValues::Sum(LazySum { normalized, other, identity: Arc::default() })
            }
            (values, other) => {
                let [one, other] = [values, other].map(|values| Self { shape, values });
                LazyValues::Blocks(one.into_blocks() + other.into_blocks())
            }
        };
        Self { shape, values }
    }

    fn relu(self) -> Self {
        let shape = self.shape;
        let values = match self.values {
            LazyValues::Sum(sum) => sum.with(Activation::Relu, shape.channels),
            _ => relu(self.into_blocks()),
        };
        Self { shape, values: LazyValues::Blocks(values) }
    }

    fn narrow(self, channels: Range<usize>) -> Self {
        self.through_planes(|planes| NetOps::narrow(planes, channels))
    }

    fn interleave(self, other: Self) -> Self {
        let other = other.into_planes();
        self.through_planes(|planes| planes.interleave(other))
    }

    fn concat(parts: Vec<Self>) -> Self {
        let planes = parts.into_iter().map(Self::into_planes).collect();
        Self::from_planes(NetOps::concat(planes))
    }

    fn local_mean(self) -> Self {
        self.through_planes(NetOps::local_mean)
    }

    fn upsample(self) -> Self {
        let upsample = Upsample { input: self.shape };
        let channels = self.shape.channels;
        let values = self.into_operand().unary(UnaryOp::Upsample(upsample), channels);
        Self { shape: upsample.output(), values: LazyValues::Blocks(values) }
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

//! Operations on batches in blocks of sixteen channels, as Burn's extension mechanism sees them: on the
//! `flex` device, without gradients.

use burn::backend::tensor::FloatTensor;
use burn::backend::{Backend, Flex, TensorMetadata, backend_extension};
use burn::tensor::Shape;
use evpose_kernels::batch_norm::{Activation, Statistics};
use evpose_kernels::training::{Blocks, Conv, Input, MaxPool, Norm};

use super::backend::{tensor, values};

/// What ResNets are trained with. Every tensor is `f32`; blocks are `[batch, blocks, height, width, 16]`.
///
/// `gamma`, `beta`, `mean` and `variance`, all of shape `[channels]`, say how a tensor is normalised by whoever
/// takes it.
#[backend_extension(Flex, Autodiff)]
pub(super) trait BlockedOps: Backend {
    /// From `[batch, channels, height, width]`.
    fn blocked_from_planes(planes: FloatTensor<Self>) -> FloatTensor<Self>;

    /// To `[batch, channels, height, width]`.
    fn blocked_to_planes(blocks: FloatTensor<Self>, channels: usize) -> FloatTensor<Self>;

    /// Output, mean and biased variance of the batch; the latter two carry no gradient.
    fn blocked_conv(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        conv: Conv,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>);

    /// As [`blocked_conv`](BlockedOps::blocked_conv), of an input that is normalised.
    #[allow(clippy::too_many_arguments, reason = "tensors have to be arguments")]
    fn blocked_norm_conv(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
        weight: FloatTensor<Self>,
        conv: Conv,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>);

    /// An input that is normalised, written down.
    fn blocked_norm(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
    ) -> FloatTensor<Self>;

    /// An input that is normalised and another, added; then `activation`.
    #[allow(clippy::too_many_arguments, reason = "tensors have to be arguments")]
    fn blocked_norm_add(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
        other: FloatTensor<Self>,
        activation: Activation,
    ) -> FloatTensor<Self>;

    /// Largest values of an input that is normalised.
    fn blocked_norm_max_pool(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
    ) -> FloatTensor<Self>;
}

/// How a tensor is normalised, beside its parameters and statistics.
#[derive(Debug, Clone, Copy)]
pub(super) struct How {
    pub(super) epsilon: f32,
    pub(super) activation: Activation,
}

impl BlockedOps for Flex {
    fn blocked_from_planes(planes: FloatTensor<Self>) -> FloatTensor<Self> {
        from_planes(&planes).0
    }

    fn blocked_to_planes(blocks: FloatTensor<Self>, channels: usize) -> FloatTensor<Self> {
        to_planes(&blocks, channels).0
    }

    fn blocked_conv(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        conv: Conv,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>) {
        convolution(&input, None, &weight, conv)
    }

    fn blocked_norm_conv(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
        weight: FloatTensor<Self>,
        conv: Conv,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>) {
        let norm = norm([&gamma, &beta, &mean, &variance], how);
        convolution(&input, Some(&norm), &weight, conv)
    }

    fn blocked_norm(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
    ) -> FloatTensor<Self> {
        let channels = gamma.shape()[0];
        written(&input, &norm([&gamma, &beta, &mean, &variance], how), channels)
    }

    fn blocked_norm_add(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
        other: FloatTensor<Self>,
        activation: Activation,
    ) -> FloatTensor<Self> {
        let channels = gamma.shape()[0];
        let norm = norm([&gamma, &beta, &mean, &variance], how);
        added(&input, &norm, &other, channels, activation)
    }

    fn blocked_norm_max_pool(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
    ) -> FloatTensor<Self> {
        let channels = gamma.shape()[0];
        pooled(&input, &norm([&gamma, &beta, &mean, &variance], how), channels).0
    }
}

/// The shape of a tensor `[batch, blocks, height, width, 16]` of so many channels.
pub(super) fn blocks(tensor: &FloatTensor<Flex>, channels: usize) -> Blocks {
    let [batch, _, height, width, _] = tensor.shape().dims();
    Blocks { batch, channels, height, width }
}

fn shape(blocks: &Blocks) -> Shape {
    Shape::from([blocks.batch, blocks.blocks(), blocks.height, blocks.width, 16])
}

/// A tensor of blocks.
pub(super) fn blocked(values: Vec<f32>, blocks: &Blocks) -> FloatTensor<Flex> {
    tensor(values, shape(blocks))
}

/// The normalisation by gamma, beta, mean and variance.
pub(super) fn norm(by: [&FloatTensor<Flex>; 4], how: How) -> Norm {
    let [gamma, beta, mean, variance] = by.map(|by| values(&by.to_contiguous()).to_vec());
    let statistics = Statistics { mean, variance };
    Norm::new(&statistics, &gamma, &beta, how.epsilon, how.activation)
}

pub(super) fn from_planes(planes: &FloatTensor<Flex>) -> (FloatTensor<Flex>, Blocks) {
    let [batch, channels, height, width] = planes.shape().dims();
    let blocks = Blocks { batch, channels, height, width };
    (blocked(blocks.from_planes(values(&planes.to_contiguous())), &blocks), blocks)
}

pub(super) fn to_planes(
    tensor_in: &FloatTensor<Flex>,
    channels: usize,
) -> (FloatTensor<Flex>, Blocks) {
    let blocks = blocks(tensor_in, channels);
    let planes = blocks.to_planes(values(&tensor_in.to_contiguous()));
    let Blocks { batch, height, width, .. } = blocks;
    (tensor(planes, Shape::from([batch, channels, height, width])), blocks)
}

pub(super) fn convolution(
    input: &FloatTensor<Flex>,
    norm: Option<&Norm>,
    weight: &FloatTensor<Flex>,
    conv: Conv,
) -> (FloatTensor<Flex>, FloatTensor<Flex>, FloatTensor<Flex>) {
    let (input, weight) = (input.to_contiguous(), weight.to_contiguous());
    let output = conv.forward(Input { values: values(&input), norm }, values(&weight), None);
    let out = conv.output();
    let Statistics { mean, variance } = Norm::statistics(&out, &output);
    let [mean, variance] = [mean, variance].map(|it| tensor(it, Shape::from([out.channels])));
    (blocked(output, &out), mean, variance)
}

pub(super) fn written(
    input: &FloatTensor<Flex>,
    norm: &Norm,
    channels: usize,
) -> FloatTensor<Flex> {
    let shape = blocks(input, channels);
    let input = input.to_contiguous();
    blocked(Input { values: values(&input), norm: Some(norm) }.written(&shape), &shape)
}

pub(super) fn added(
    input: &FloatTensor<Flex>,
    norm: &Norm,
    other: &FloatTensor<Flex>,
    channels: usize,
    activation: Activation,
) -> FloatTensor<Flex> {
    let shape = blocks(input, channels);
    let (input, other) = (input.to_contiguous(), other.to_contiguous());
    let input = Input { values: values(&input), norm: Some(norm) };
    blocked(input.add(&shape, values(&other).into(), activation), &shape)
}

pub(super) fn pooled(
    input: &FloatTensor<Flex>,
    norm: &Norm,
    channels: usize,
) -> (FloatTensor<Flex>, Vec<u8>) {
    let pool = MaxPool { input: blocks(input, channels) };
    let input = input.to_contiguous();
    let (output, taps) = pool.forward(Input { values: values(&input), norm: Some(norm) });
    (blocked(output, &pool.output()), taps)
}

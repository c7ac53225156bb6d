//! The operations of training on batches in nChw16c, as Burn's extension mechanism takes them: on
//! the `flex` device, without gradients.

use burn::backend::tensor::FloatTensor;
use burn::backend::{Backend, Flex, TensorMetadata, backend_extension};
use burn::tensor::{Shape, TensorData};
use evpose_kernels::training::{Activation, Blocks, Norm, NormalizedInput, Statistics};

use super::layer::ConvLayer;
use super::unary::UnaryOp;

/// The operations that networks are trained with. Every tensor is `f32`; batches in nChw16c are
/// `[batch, blocks, height, width, 16]`.
///
/// `gamma`, `beta`, `mean` and `variance`, all of shape `[channels]`, normalise the input while it
/// is read, where there are settings of a norm; elsewhere their content does not matter.
#[backend_extension(Flex, Autodiff)]
pub(super) trait TrainingOps: Backend {
    /// `[batch, channels, height, width]` in nChw16c.
    fn blocked_from_planes(planes: FloatTensor<Self>) -> FloatTensor<Self>;

    /// A batch in nChw16c as `[batch, channels, height, width]`.
    fn blocked_to_planes(blocks: FloatTensor<Self>, channels: usize) -> FloatTensor<Self>;

    /// Mean and biased variance of each channel, which carry no gradient.
    fn blocked_statistics(
        blocks: FloatTensor<Self>,
        channels: usize,
    ) -> (FloatTensor<Self>, FloatTensor<Self>);

    /// A convolution. `bias` is `[channels_out]`, or any tensor where the settings have none.
    #[allow(clippy::too_many_arguments, reason = "tensors have to be arguments")]
    fn blocked_conv(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        settings: ConvSettings,
    ) -> FloatTensor<Self>;

    /// An operation of one input.
    fn blocked_unary(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        settings: UnarySettings,
    ) -> FloatTensor<Self>;

    /// The sum of the input and another batch, then the activation.
    #[allow(clippy::too_many_arguments, reason = "tensors have to be arguments")]
    fn blocked_add(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        other: FloatTensor<Self>,
        settings: AddSettings,
    ) -> FloatTensor<Self>;
}

/// The normalisation of an input, besides its parameters and statistics.
#[derive(Debug, Clone, Copy)]
pub(super) struct NormSettings {
    pub(super) epsilon: f32,
    pub(super) activation: Activation,
}

/// Settings of [`TrainingOps::blocked_conv`].
#[derive(Debug, Clone, Copy)]
pub(super) struct ConvSettings {
    pub(super) norm: Option<NormSettings>,
    pub(super) layer: ConvLayer,
    pub(super) has_bias: bool,
}

/// Settings of [`TrainingOps::blocked_unary`].
#[derive(Debug, Clone, Copy)]
pub(super) struct UnarySettings {
    pub(super) norm: Option<NormSettings>,
    pub(super) op: UnaryOp,
    /// Channels of the input.
    pub(super) channels: usize,
}

/// Settings of [`TrainingOps::blocked_add`].
#[derive(Debug, Clone, Copy)]
pub(super) struct AddSettings {
    pub(super) norm: Option<NormSettings>,
    pub(super) activation: Activation,
    /// Channels of both inputs.
    pub(super) channels: usize,
}

impl TrainingOps for Flex {
    fn blocked_from_planes(planes: FloatTensor<Self>) -> FloatTensor<Self> {
        from_planes(&planes).0
    }

    fn blocked_to_planes(blocks: FloatTensor<Self>, channels: usize) -> FloatTensor<Self> {
        to_planes(&blocks, channels).0
    }

    fn blocked_statistics(
        blocks: FloatTensor<Self>,
        channels: usize,
    ) -> (FloatTensor<Self>, FloatTensor<Self>) {
        statistics(&blocks, channels)
    }

    fn blocked_conv(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        settings: ConvSettings,
    ) -> FloatTensor<Self> {
        let norm = norm([&gamma, &beta, &mean, &variance], settings.norm);
        convolution(&input.to_contiguous(), norm.as_ref(), &weight, &bias, settings)
    }

    fn blocked_unary(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        settings: UnarySettings,
    ) -> FloatTensor<Self> {
        let norm = norm([&gamma, &beta, &mean, &variance], settings.norm);
        unary(&input.to_contiguous(), norm.as_ref(), settings).0
    }

    fn blocked_add(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        other: FloatTensor<Self>,
        settings: AddSettings,
    ) -> FloatTensor<Self> {
        let norm = norm([&gamma, &beta, &mean, &variance], settings.norm);
        sum(&input.to_contiguous(), norm.as_ref(), &other, settings)
    }
}

/// The values of a contiguous tensor.
pub(super) fn values(tensor: &FloatTensor<Flex>) -> &[f32] {
    debug_assert!(tensor.is_contiguous());
    let start = tensor.layout().start_offset();
    &tensor.storage()[start..start + tensor.shape().num_elements()]
}

/// A tensor from its values, row-major.
pub(super) fn tensor(values: Vec<f32>, shape: Shape) -> FloatTensor<Flex> {
    <FloatTensor<Flex>>::from_data(TensorData::new(values, shape))
}

/// The shape of a tensor `[batch, blocks, height, width, 16]` with this number of channels.
pub(super) fn blocks(tensor: &FloatTensor<Flex>, channels: usize) -> Blocks {
    let [batch, _, height, width, _] = tensor.shape().dims();
    Blocks { batch, channels, height, width }
}

/// A tensor in nChw16c from its values.
pub(super) fn blocked(values: Vec<f32>, blocks: &Blocks) -> FloatTensor<Flex> {
    let Blocks { batch, height, width, .. } = *blocks;
    tensor(values, Shape::from([batch, blocks.blocks(), height, width, 16]))
}

/// The normalisation by gamma, beta, mean and variance, if there are settings of one.
pub(super) fn norm(
    tensors: [&FloatTensor<Flex>; 4],
    settings: Option<NormSettings>,
) -> Option<Norm> {
    let NormSettings { epsilon, activation } = settings?;
    let [gamma, beta, mean, variance] =
        tensors.map(|tensor| values(&tensor.to_contiguous()).to_vec());
    Some(Norm::new(&Statistics { mean, variance }, &gamma, &beta, epsilon, activation))
}

pub(super) fn from_planes(planes: &FloatTensor<Flex>) -> (FloatTensor<Flex>, Blocks) {
    let [batch, channels, height, width] = planes.shape().dims();
    let blocks = Blocks { batch, channels, height, width };
    (blocked(blocks.from_planes(values(&planes.to_contiguous())), &blocks), blocks)
}

pub(super) fn to_planes(input: &FloatTensor<Flex>, channels: usize) -> (FloatTensor<Flex>, Blocks) {
    let blocks = blocks(input, channels);
    let planes = blocks.to_planes(values(&input.to_contiguous()));
    let Blocks { batch, height, width, .. } = blocks;
    (tensor(planes, Shape::from([batch, channels, height, width])), blocks)
}

pub(super) fn statistics(
    input: &FloatTensor<Flex>,
    channels: usize,
) -> (FloatTensor<Flex>, FloatTensor<Flex>) {
    let shape = blocks(input, channels);
    let Statistics { mean, variance } = Norm::statistics(&shape, values(&input.to_contiguous()));
    (tensor(mean, Shape::from([channels])), tensor(variance, Shape::from([channels])))
}

/// `input` is contiguous, here and below.
pub(super) fn convolution(
    input: &FloatTensor<Flex>,
    norm: Option<&Norm>,
    weight: &FloatTensor<Flex>,
    bias: &FloatTensor<Flex>,
    settings: ConvSettings,
) -> FloatTensor<Flex> {
    let ConvSettings { layer, has_bias, .. } = settings;
    let (weight, bias) = (weight.to_contiguous(), bias.to_contiguous());
    let bias = has_bias.then(|| values(&bias));
    let output =
        layer.forward(NormalizedInput { values: values(input), norm }, values(&weight), bias);
    blocked(output, &layer.output())
}

/// The output, and for a max-pooling the index of the largest value in every window.
pub(super) fn unary(
    input: &FloatTensor<Flex>,
    norm: Option<&Norm>,
    settings: UnarySettings,
) -> (FloatTensor<Flex>, Vec<u8>) {
    let shape = blocks(input, settings.channels);
    let (output, out, taps) =
        settings.op.forward(shape, NormalizedInput { values: values(input), norm });
    (blocked(output, &out), taps)
}

pub(super) fn sum(
    input: &FloatTensor<Flex>,
    norm: Option<&Norm>,
    other: &FloatTensor<Flex>,
    settings: AddSettings,
) -> FloatTensor<Flex> {
    let shape = blocks(input, settings.channels);
    let other = other.to_contiguous();
    let input = NormalizedInput { values: values(input), norm };
    blocked(input.add(&shape, values(&other).into(), settings.activation), &shape)
}

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

    /// One of the [operations](BlockedOp); what it does not take of `first` and `second` may be any
    /// tensor.
    #[allow(clippy::too_many_arguments, reason = "tensors have to be arguments")]
    fn blocked_op(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        first: FloatTensor<Self>,
        second: FloatTensor<Self>,
        settings: OpSettings,
    ) -> FloatTensor<Self>;
}

/// The normalisation of an input, besides its parameters and statistics.
#[derive(Debug, Clone, Copy)]
pub(super) struct NormSettings {
    pub(super) epsilon: f32,
    pub(super) activation: Activation,
}

/// Settings of [`TrainingOps::blocked_op`].
#[derive(Debug, Clone, Copy)]
pub(super) struct OpSettings {
    pub(super) norm: Option<NormSettings>,
    /// Channels of the input.
    pub(super) channels: usize,
    pub(super) op: BlockedOp,
}

/// An operation on a batch, which it normalises while it reads.
#[derive(Debug, Clone, Copy)]
pub(super) enum BlockedOp {
    /// A convolution with the weight `first` and, if it has one, the bias `second`, `[channels_out]`.
    Conv { layer: ConvLayer, has_bias: bool },
    /// An operation of one input.
    Unary(UnaryOp),
    /// The sum of the input and the batch `first`, then the activation.
    Add(Activation),
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

    fn blocked_op(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        first: FloatTensor<Self>,
        second: FloatTensor<Self>,
        settings: OpSettings,
    ) -> FloatTensor<Self> {
        let norm = norm([&gamma, &beta, &mean, &variance], settings.norm);
        applied(&input.to_contiguous(), norm.as_ref(), [&first, &second], settings).0
    }
}

/// The values of a contiguous tensor.
pub(super) fn values(tensor: &FloatTensor<Flex>) -> &[f32] {
    assert!(tensor.is_contiguous());
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

/// The output, and for a max-pooling the index of the largest value in every window. `input` is
/// contiguous.
pub(super) fn applied(
    input: &FloatTensor<Flex>,
    norm: Option<&Norm>,
    [first, second]: [&FloatTensor<Flex>; 2],
    settings: OpSettings,
) -> (FloatTensor<Flex>, Vec<u8>) {
    let shape = blocks(input, settings.channels);
    let input = NormalizedInput { values: values(input), norm };
    match settings.op {
        BlockedOp::Conv { layer, has_bias } => {
            // Weights may be views of other tensors; kernels read plain slices.
            let (weight, bias) = (first.to_contiguous(), second.to_contiguous());
            let bias = has_bias.then(|| values(&bias));
            (blocked(layer.forward(input, values(&weight), bias), &layer.output()), Vec::new())
        }
        BlockedOp::Unary(op) => {
            let (output, out, taps) = op.forward(shape, input);
            (blocked(output, &out), taps)
        }
        BlockedOp::Add(activation) => {
            let other = first.to_contiguous();
            (blocked(input.add(&shape, values(&other).into(), activation), &shape), Vec::new())
        }
    }
}

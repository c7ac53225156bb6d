//! The operations as Burn's extension mechanism sees them: on the `flex` device, without
//! gradients.

use burn::backend::tensor::FloatTensor;
use burn::backend::{Backend, Flex, TensorMetadata, backend_extension};
use burn::tensor::{Shape, TensorData};
use evpose_kernels::batch_norm::{Activation, BatchNorm, Statistics};
use evpose_kernels::conv2d::Conv2d;
use evpose_kernels::depthwise::Depthwise;
use evpose_kernels::max_pool;

/// What the networks are trained with. Every tensor is `f32`.
#[backend_extension(Flex, Autodiff)]
pub(super) trait TrainingOps: Backend {
    /// # Shapes
    /// - input: `[batch, channels_in, height, width]`
    /// - weight: `[channels_out, channels_in, ky, kx]`, or `[channels_in, 1, k, k]`: depthwise
    fn training_conv2d(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        stride: usize,
        padding: usize,
    ) -> FloatTensor<Self>;

    /// # Shapes
    /// - as [`training_conv2d`](TrainingOps::training_conv2d); bias: `[channels_out]`
    fn training_conv2d_biased(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        stride: usize,
        padding: usize,
    ) -> FloatTensor<Self>;

    /// Output, mean and biased variance of the batch; the latter two carry no gradient.
    ///
    /// # Shapes
    /// - input, output: `[batch, channels, height, width]`
    /// - all others: `[channels]`
    fn training_batch_norm(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        epsilon: f32,
        activation: Activation,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>);

    /// # Shapes
    /// - input: `[batch, channels, height, width]`
    /// - output: `[batch, channels, ceil(height / 2), ceil(width / 2)]`
    fn training_max_pool(input: FloatTensor<Self>) -> FloatTensor<Self>;
}

impl TrainingOps for Flex {
    fn training_conv2d(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        stride: usize,
        padding: usize,
    ) -> FloatTensor<Self> {
        convolution(&input, &weight, None, stride, padding)
    }

    fn training_conv2d_biased(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        stride: usize,
        padding: usize,
    ) -> FloatTensor<Self> {
        convolution(&input, &weight, Some(&bias), stride, padding)
    }

    fn training_batch_norm(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        epsilon: f32,
        activation: Activation,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>) {
        let channels = gamma.shape();
        let (output, statistics) = batch_norm([&input, &gamma, &beta], epsilon, activation);
        let Statistics { mean, variance } = statistics;
        (output, tensor(mean, channels.clone()), tensor(variance, channels))
    }

    fn training_max_pool(input: FloatTensor<Self>) -> FloatTensor<Self> {
        pool(&input).0
    }
}

/// A convolution.
pub(super) fn convolution(
    input: &FloatTensor<Flex>,
    weight: &FloatTensor<Flex>,
    bias: Option<&FloatTensor<Flex>>,
    stride: usize,
    padding: usize,
) -> FloatTensor<Flex> {
    let conv = Convolution::of(input, weight, stride, padding);
    let (batch, channels) = (input.shape()[0], weight.shape()[0]);
    let (input, weight) = (input.to_contiguous(), weight.to_contiguous());
    let bias = bias.map(FloatTensor::<Flex>::to_contiguous);
    let (input, weight, bias) = (values(&input), values(&weight), bias.as_ref().map(values));
    let (output, [rows, columns]) = match conv {
        Convolution::Full(conv) => (conv.forward(input, weight, bias), conv.output()),
        Convolution::Depthwise(conv) => (conv.forward(input, weight, bias), conv.output()),
    };
    tensor(output, Shape::from([batch, channels, rows, columns]))
}

/// Whether channels are mixed.
pub(super) enum Convolution {
    /// They are.
    Full(Conv2d),
    /// Each goes by itself.
    Depthwise(Depthwise),
}

impl Convolution {
    /// The shape of a convolution of `input` with `weight`, which says by its own shape which one it is.
    pub(super) fn of(
        input: &FloatTensor<Flex>,
        weight: &FloatTensor<Flex>,
        stride: usize,
        padding: usize,
    ) -> Self {
        let [batch, channels_in, height, width] = input.shape().dims();
        let [channels_out, of_group, kernel_y, kernel_x] = weight.shape().dims();
        if of_group == channels_in {
            let kernel = [kernel_y, kernel_x];
            return Self::Full(Conv2d {
                batch,
                channels_in,
                height,
                width,
                channels_out,
                kernel,
                stride,
                padding,
            });
        }
        let (channels, kernel) = (channels_in, kernel_y);
        Self::Depthwise(Depthwise { batch, channels, height, width, kernel, stride, padding })
    }
}

/// A batch normalisation of input, gamma and beta, with the statistics that its gradients need.
pub(super) fn batch_norm(
    inputs: [&FloatTensor<Flex>; 3],
    epsilon: f32,
    activation: Activation,
) -> (FloatTensor<Flex>, Statistics) {
    let [input, gamma, beta] = inputs.map(FloatTensor::<Flex>::to_contiguous);
    let norm = norm_shape(&input, epsilon, activation);
    let (output, statistics) = norm.forward(values(&input), values(&gamma), values(&beta));
    (tensor(output, input.shape()), statistics)
}

/// The shape of a batch normalisation of `input`.
pub(super) fn norm_shape(
    input: &FloatTensor<Flex>,
    epsilon: f32,
    activation: Activation,
) -> BatchNorm {
    let [_, channels, height, width] = input.shape().dims();
    BatchNorm { channels, pixels: height * width, epsilon, activation }
}

/// A max-pooling with the taps that its gradient needs.
pub(super) fn pool(input: &FloatTensor<Flex>) -> (FloatTensor<Flex>, Vec<u8>) {
    let [batch, channels, height, width] = input.shape().dims();
    let (output, taps) = max_pool::forward(values(&input.to_contiguous()), [height, width]);
    let [rows, columns] = max_pool::output([height, width]);
    (tensor(output, Shape::from([batch, channels, rows, columns])), taps)
}

/// The numbers of a contiguous tensor.
pub(super) fn values(tensor: &FloatTensor<Flex>) -> &[f32] {
    debug_assert!(tensor.is_contiguous());
    let start = tensor.layout().start_offset();
    &tensor.storage()[start..start + tensor.shape().num_elements()]
}

/// A tensor from its numbers, row after row.
pub(super) fn tensor(values: Vec<f32>, shape: Shape) -> FloatTensor<Flex> {
    <FloatTensor<Flex>>::from_data(TensorData::new(values, shape))
}

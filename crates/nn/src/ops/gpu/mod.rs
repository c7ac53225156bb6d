//! Convolutions on GPUs, by the way that is set, with their gradients; normalisations in inference.
//!
//! * [`columns`]: as matrix products.
//! * [`kernels`]: what lays out their operands.

mod columns;
mod kernels;

use std::sync::OnceLock;

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::ops::ConvOptions;
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Backend, Cube, Dispatch, TensorMetadata, backend_extension};
use burn::nn::conv::Conv2d;
use burn::nn::{BatchNorm, PaddingConfig2d};
use burn::tensor::{DType, Device, Tensor};
use burn_cubecl::kernel::conv::{
    ConvStrategy, conv_data_backward, conv_forward, conv_weight_backward,
};
use burn_cubecl::tensor::CubeTensor;

use super::Activation;
use columns::{Geometry, Product};

/// How convolutions are computed on GPUs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// As Burn does by default.
    Burn,
    /// Burn's implicit product on matrix units.
    Implicit,
    /// Our columns, and a product.
    Columns(Product),
}

impl Way {
    /// The way that `EVPOSE_GPU_CONVOLUTION` sets, for measurements: `implicit`, `columns`, or
    /// `columns-f32`; else Burn's.
    fn chosen() -> Self {
        static CHOSEN: OnceLock<Way> = OnceLock::new();
        *CHOSEN.get_or_init(|| {
            let name = std::env::var("EVPOSE_GPU_CONVOLUTION").unwrap_or_default();
            match name.as_str() {
                "implicit" => Self::Implicit,
                "columns" => Self::Columns(Product::Burns),
                "columns-f32" => Self::Columns(Product::F32),
                _ => Self::Burn,
            }
        })
    }
}

/// Whether a convolution is computed here.
pub(super) fn suits(layer: &Conv2d, input: &Tensor<4>) -> bool {
    layer.groups == 1
        && matches!(layer.padding, PaddingConfig2d::Explicit(..) | PaddingConfig2d::Valid)
        && input.dtype() == DType::F32
        && Way::chosen() != Way::Burn
        && is_gpu(&input.device())
}

fn is_gpu(device: &Device) -> bool {
    let device = device.clone().without_autodiff();
    #[cfg(feature = "ndarray")]
    #[allow(deprecated, reason = "offered until Burn removes it")]
    if device == Device::ndarray() {
        return false;
    }
    device != Device::flex()
}

/// `layer.forward(input)` of a convolution that [`suits`].
///
/// # Shapes
/// - input: `[batch, channels_in, height, width]`
/// - output: `[batch, channels_out, height', width']`, sizes by the layer
pub(super) fn forward(layer: &Conv2d, input: Tensor<4>) -> Tensor<4> {
    forward_by(Way::chosen(), layer, input)
}

fn forward_by(way: Way, layer: &Conv2d, input: Tensor<4>) -> Tensor<4> {
    let padding = match layer.padding {
        PaddingConfig2d::Explicit(top, left, bottom, right) => [(top, bottom), (left, right)],
        _ => [(0, 0); 2],
    };
    let options = ConvOptions::new_with_padding(layer.stride, padding, layer.dilation, 1);
    let (input, weight) = (input.into_dispatch(), layer.weight.val().into_dispatch());
    let output = Tensor::<4>::from_dispatch(Dispatch::gpu_conv(input, weight, options, way));
    match &layer.bias {
        Some(bias) => output + bias.val().reshape([1, -1, 1, 1]),
        None => output,
    }
}

/// Whether a normalisation is computed here: one that is not trained.
pub(super) fn normalizes(input: &Tensor<4>) -> bool {
    let device = input.device();
    input.dtype() == DType::F32
        && Way::chosen() != Way::Burn
        && !device.is_autodiff()
        && is_gpu(&device)
}

/// `activation(layer.forward(input))` of a normalisation that is not trained, in one pass.
///
/// # Shapes
/// - input, output: `[batch, channels, height, width]`
pub(super) fn normalized(layer: &BatchNorm, input: Tensor<4>, activation: Activation) -> Tensor<4> {
    let device = input.device();
    let running = [&layer.running_mean, &layer.running_var];
    let [mean, variance] = running.map(|running| running.value().to_device(&device));
    Tensor::from_dispatch(Dispatch::gpu_norm(
        input.into_dispatch(),
        layer.gamma.val().into_dispatch(),
        layer.beta.val().into_dispatch(),
        mean.into_dispatch(),
        variance.into_dispatch(),
        layer.epsilon as f32,
        activation,
    ))
}

#[backend_extension(Cube)]
trait GpuNormalization: Backend {
    /// A normalisation by known statistics, then the activation.
    fn gpu_norm(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        epsilon: f32,
        activation: Activation,
    ) -> FloatTensor<Self>;
}

impl GpuNormalization for Cube {
    fn gpu_norm(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        epsilon: f32,
        activation: Activation,
    ) -> FloatTensor<Self> {
        columns::normalized(input, [gamma, beta, mean, variance], epsilon, activation)
    }
}

#[backend_extension(Cube, Autodiff)]
trait GpuConvolution: Backend {
    /// A convolution without groups.
    fn gpu_conv(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        options: ConvOptions<2>,
        way: Way,
    ) -> FloatTensor<Self>;
}

impl GpuConvolution for Cube {
    fn gpu_conv(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        options: ConvOptions<2>,
        way: Way,
    ) -> FloatTensor<Self> {
        convolution(input, weight, options, way)
    }
}

impl<C: CheckpointStrategy> GpuConvolution for Autodiff<Cube, C> {
    fn gpu_conv(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        options: ConvOptions<2>,
        way: Way,
    ) -> FloatTensor<Self> {
        let (x, w) = (input.primitive().clone(), weight.primitive().clone());
        let output = convolution(x.clone(), w.clone(), options.clone(), way);
        match Convolution.prepare::<C>([input.node(), weight.node()]).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((x, w, options, way), output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }
}

fn convolution(
    input: CubeTensor,
    weight: CubeTensor,
    options: ConvOptions<2>,
    way: Way,
) -> CubeTensor {
    match way {
        Way::Columns(product) => {
            Geometry::new(&input.shape(), &weight.shape(), options).forward(input, weight, product)
        }
        way => conv_forward(input, weight, None, options, way.strategy())
            .unwrap_or_else(|error| panic!("a convolution: {error:?}")),
    }
}

impl Way {
    fn strategy(self) -> ConvStrategy {
        match self {
            Self::Implicit => ConvStrategy::ImplicitGemm,
            _ => ConvStrategy::default(),
        }
    }
}

#[derive(Debug)]
struct Convolution;

impl Backward<Cube, 2> for Convolution {
    /// Input, weight, settings and way.
    type State = (CubeTensor, CubeTensor, ConvOptions<2>, Way);

    fn backward(self, ops: Ops<Self::State, 2>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = grads.consume::<Cube>(&ops.node);
        let (input, weight, options, way) = ops.state;
        let geometry = Geometry::new(&input.shape(), &weight.shape(), options.clone());
        let [by_input, by_weight] = ops.parents.map(|parent| parent.map(|parent| parent.id));
        // Images need no gradient: the first layer of a network skips the largest pass.
        if let Some(parent) = by_input {
            let gradient = match way {
                Way::Columns(product) => geometry.by_input(dy.clone(), weight.clone(), product),
                _ => conv_data_backward(
                    dy.clone(),
                    weight.clone(),
                    input.shape(),
                    options.clone(),
                    way.strategy(),
                )
                .unwrap_or_else(|error| panic!("a gradient by images: {error:?}")),
            };
            grads.register::<Cube>(parent, gradient);
        }
        // A frozen weight has no parent.
        if let Some(parent) = by_weight {
            let gradient = match way {
                Way::Columns(product) => geometry.by_weight(dy, input, product),
                _ => conv_weight_backward(input, dy, weight.shape(), options, way.strategy())
                    .unwrap_or_else(|error| panic!("a gradient by weights: {error:?}")),
            };
            grads.register::<Cube>(parent, gradient);
        }
    }
}

#[cfg(all(test, feature = "wgpu"))]
mod tests {
    #![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]
    use burn::nn::conv::Conv2dConfig;
    use burn::tensor::TensorData;

    use super::*;
    use crate::DeviceKind;

    /// Output and gradients by input and weight of `forward`, on a device.
    fn values(
        device: &Device,
        config: &Conv2dConfig,
        size: [usize; 4],
        forward: impl Fn(&Conv2d, Tensor<4>) -> Tensor<4>,
    ) -> [Vec<f32>; 3] {
        let device = &device.clone().autodiff();
        let waves = |count: usize, step: f32| (0..count).map(|i| (i as f32 * step).sin()).collect();
        let tensor = |size: [usize; 4], step| {
            let values: Vec<f32> = waves(size.iter().product(), step);
            Tensor::<4>::from_data(TensorData::new(values, size), device).require_grad()
        };
        let mut layer = config.init(device);
        let weight = tensor(layer.weight.dims(), 0.7);
        layer.weight = burn::module::Param::from_tensor(weight);
        let input = tensor(size, 0.3);
        let output = forward(&layer, input.clone());
        let gradients = output.clone().square().sum().backward();
        let weight = layer.weight.val();
        [output, input.grad(&gradients).unwrap(), weight.grad(&gradients).unwrap()]
            .map(|tensor| tensor.into_data().iter::<f32>().collect())
    }

    #[test]
    #[ignore = "needs an adapter of wgpu, a GPU or Mesa's software: `cargo xtask slow` runs it"]
    fn convolutions_of_every_shape_agree_with_the_cpu() {
        let gpu = (DeviceKind::Wgpu { adapter: None }).resolve().expect("an adapter of wgpu");
        let shapes = [
            ([1, 1], [1, 1], [0; 4], [1, 1]),
            ([1, 1], [2, 2], [0; 4], [1, 1]),
            ([3, 3], [1, 1], [1; 4], [1, 1]),
            ([3, 3], [2, 2], [1; 4], [1, 1]),
            ([7, 7], [2, 2], [3; 4], [1, 1]),
            ([1, 7], [1, 1], [0, 3, 0, 3], [1, 1]),
            ([3, 2], [2, 1], [1, 0, 0, 1], [2, 3]),
            ([5, 3], [3, 2], [0; 4], [1, 2]),
        ];
        for (kernel, stride, [top, left, bottom, right], dilation) in shapes {
            for size in [[2, 3, 13, 16], [1, 8, 9, 11]] {
                let config = Conv2dConfig::new([size[1], 5], kernel)
                    .with_stride(stride)
                    .with_dilation(dilation)
                    .with_padding(PaddingConfig2d::Explicit(top, left, bottom, right))
                    .with_bias(false);
                let columns = Way::Columns(Product::Burns);
                let by_columns = |layer: &Conv2d, x| forward_by(columns, layer, x);
                let ours = values(&gpu, &config, size, by_columns);
                let cpus = values(&Device::flex(), &config, size, |layer, x| layer.forward(x));
                for (ours, cpus) in ours.iter().zip(&cpus) {
                    assert_eq!(ours.len(), cpus.len());
                    let largest = cpus.iter().fold(1.0, |most: f32, value| most.max(value.abs()));
                    let is_near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-5 * largest;
                    assert!(ours.iter().zip(cpus).all(is_near), "{kernel:?} {stride:?} {size:?}");
                }
            }
        }
    }
}

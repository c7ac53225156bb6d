//! Convolutions on GPUs, with their gradients.

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::ops::ConvOptions;
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Backend, Cube, Dispatch, TensorMetadata, backend_extension};
use burn::nn::PaddingConfig2d;
use burn::nn::conv::Conv2d;
use burn::tensor::{DType, Tensor};
use burn_cubecl::kernel::conv::{
    ConvStrategy, conv_data_backward, conv_forward, conv_weight_backward,
};
use burn_cubecl::tensor::CubeTensor;

use super::columns::Geometry;
use super::{Way, depthwise, is_gpu};
use crate::ops::mixed::options;

/// Output channels below which Burn's direct convolution is the faster: a product has tiles for more, most of which
/// would be empty (`benches/machines/xeon-2-vulkan-layers.json`, `conv1`).
const MIN_CHANNELS: usize = 8;

/// Whether a convolution is computed here.
pub(crate) fn suits(layer: &Conv2d, input: &Tensor<4>) -> bool {
    let [channels_out, of_group, ..] = layer.weight.dims();
    let is_depthwise = of_group == 1 && layer.groups == channels_out;
    (layer.groups == 1 || is_depthwise && matches!(Way::chosen(), Way::Columns(_)))
        && matches!(layer.padding, PaddingConfig2d::Explicit(..) | PaddingConfig2d::Valid)
        && matches!(input.dtype(), DType::F32 | DType::F16 | DType::BF16)
        && Way::chosen() != Way::Burn
        && is_gpu(&input.device())
}

/// `layer.forward(input)` of a convolution that [`suits`], in the number format of `input`.
///
/// # Shapes
/// - input: `[batch, channels_in, height, width]`
/// - output: `[batch, channels_out, height', width']`, sizes by the layer
pub(crate) fn forward(layer: &Conv2d, input: Tensor<4>) -> Tensor<4> {
    forward_by(Way::chosen(), layer, input)
}

fn forward_by(way: Way, layer: &Conv2d, input: Tensor<4>) -> Tensor<4> {
    let (format, options) = (input.dtype(), options(layer));
    let weight = layer.weight.val().cast(format).into_dispatch();
    let input = input.into_dispatch();
    let output = Tensor::<4>::from_dispatch(Dispatch::gpu_conv(input, weight, options, way));
    // Burn adds the bias: it has the gradient of the sum already.
    match &layer.bias {
        Some(bias) => output + bias.val().cast(format).reshape([1, -1, 1, 1]),
        None => output,
    }
}

#[backend_extension(Cube, Autodiff)]
trait GpuConvolution: Backend {
    /// A convolution of all channels, or of each by itself.
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
            // An untracked output must not keep its inputs alive.
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
            let groups = options.groups;
            let geometry = Geometry::new(&input.shape(), &weight.shape(), options);
            if groups > 1 {
                return depthwise::forward(&geometry, input, weight);
            }
            if geometry.output_shape()[3] < MIN_CHANNELS {
                return directly(input, weight, geometry.options(), Way::Burn);
            }
            geometry.forward(input, weight, product)
        }
        way => directly(input, weight, options, way),
    }
}

fn directly(
    input: CubeTensor,
    weight: CubeTensor,
    options: ConvOptions<2>,
    way: Way,
) -> CubeTensor {
    conv_forward(input, weight, None, options, way.strategy())
        .unwrap_or_else(|error| panic!("a convolution: {error:?}"))
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
        let is_depthwise = options.groups > 1;
        // Images need no gradient: the first layer of a network skips the largest pass.
        if let Some(parent) = by_input {
            let gradient = match way {
                Way::Columns(_) if is_depthwise => {
                    depthwise::by_input(&geometry, dy.clone(), weight.clone())
                }
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
                Way::Columns(_) if is_depthwise => depthwise::by_weight(&geometry, dy, input),
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
    use burn::tensor::{Device, TensorData};

    use super::*;
    use crate::DeviceKind;
    use crate::ops::gpu::columns::Product;

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
    fn convolutions_of_every_shape_on_a_gpu_agree_with_the_cpu() {
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
            // As many groups as channels are a convolution of each by itself; fewer output channels than
            // MIN_CHANNELS go another way forward.
            let sizes = [
                ([2, 3, 13, 16], 9, 1),
                ([1, 8, 9, 11], 5, 1),
                ([1, 8, 9, 11], 12, 1),
                ([2, 5, 12, 9], 5, 5),
            ];
            for (size, channels_out, groups) in sizes {
                let config = Conv2dConfig::new([size[1], channels_out], kernel)
                    .with_groups(groups)
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

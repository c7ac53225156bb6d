//! Layers of the networks in training, on our own kernels where they run on the CPU.
//!
//! The modules stay Burn's: parameters, files and running statistics are theirs, only the
//! arithmetic of [`conv2d`], [`batch_norm`] and [`max_pool`] is replaced, and only for tensors on
//! the `flex` device with gradients. Everything else takes Burn's way.
//!
//! * [`backend`]: the operations as Burn's extension mechanism sees them.
//! * [`differentiable`]: their gradients.
//! * [`blocked`]: what flows through ResNets in training, in blocks of channels;
//!   [`blocked_backend`] and [`blocked_gradients`] are its operations.
//! * [`seven`]: a way for the first layer of ResNets on Burn's own arithmetic.

mod backend;
mod blocked;
mod blocked_backend;
mod blocked_gradients;
mod differentiable;
mod seven;

use std::sync::atomic::{AtomicBool, Ordering};

use burn::backend::Dispatch;
use burn::nn::conv::Conv2d;
use burn::nn::pool::MaxPool2d;
use burn::nn::{BatchNorm, PaddingConfig2d};
use burn::tensor::activation::relu;
use burn::tensor::{DType, Device, Tensor};

pub(crate) use evpose_kernels::batch_norm::Activation;

use backend::TrainingOps;
pub(crate) use blocked::Blocked;

static ENABLED: AtomicBool = AtomicBool::new(true);

/// Whether training on the `flex` device computes with our own kernels (it does unless told
/// otherwise) or with Burn's. For comparisons; holds for the whole process.
pub fn set_training_kernels(enabled: bool) {
    ENABLED.store(enabled, Ordering::Relaxed);
}

/// Whether the functions here compute with our kernels on `input`.
pub(crate) fn is_ours(input: &Tensor<4>) -> bool {
    let device = input.device();
    ENABLED.load(Ordering::Relaxed)
        && device.is_autodiff()
        && device == Device::flex()
        && input.dtype() == DType::F32
}

/// `layer.forward(input)`.
///
/// # Shapes
/// - input: `[batch, channels_in, height, width]`
/// - output: `[batch, channels_out, height', width']`, sizes by the layer
pub(crate) fn conv2d(layer: &Conv2d, input: Tensor<4>) -> Tensor<4> {
    let PaddingConfig2d::Explicit(top, left, bottom, right) = layer.padding else {
        return layer.forward(input);
    };
    let [stride, stride_x] = layer.stride;
    let is_even = stride == stride_x && [left, bottom, right] == [top; 3];
    let [channels_out, of_group, kernel_y, kernel_x] = layer.weight.dims();
    let is_depthwise = layer.groups == channels_out && of_group == 1 && kernel_y == kernel_x;
    let suits = layer.groups == 1 || (is_depthwise && input.dims()[1] == channels_out);
    if !(is_even && suits && layer.dilation == [1, 1] && is_ours(&input)) {
        return if seven::suits(layer) {
            seven::stride_two_seven(layer, input)
        } else {
            layer.forward(input)
        };
    }
    let input = input.into_dispatch();
    let weight = layer.weight.val().into_dispatch();
    let output = match &layer.bias {
        Some(bias) => {
            let bias = bias.val().into_dispatch();
            Dispatch::training_conv2d_biased(input, weight, bias, stride, top)
        }
        None => Dispatch::training_conv2d(input, weight, stride, top),
    };
    Tensor::from_dispatch(output)
}

/// `layer.forward(input)`, and the activation behind it.
///
/// # Shapes
/// - input, output: `[batch, channels, height, width]`
pub(crate) fn batch_norm(layer: &BatchNorm, input: Tensor<4>, activation: Activation) -> Tensor<4> {
    if !(layer.training.is_enabled() && is_ours(&input)) {
        let output = layer.forward(input);
        return match activation {
            Activation::Identity => output,
            Activation::Relu => relu(output),
            Activation::Relu6 => output.clamp(0.0, 6.0),
        };
    }
    let (output, mean, variance) = Dispatch::training_batch_norm(
        input.into_dispatch(),
        layer.gamma.val().into_dispatch(),
        layer.beta.val().into_dispatch(),
        layer.epsilon as f32,
        activation,
    );
    update_running(layer, &Tensor::from_dispatch(mean), &Tensor::from_dispatch(variance));
    Tensor::from_dispatch(output)
}

/// Moves running statistics towards those of a batch, as the forward pass of Burn's module does.
fn update_running(layer: &BatchNorm, mean: &Tensor<1>, variance: &Tensor<1>) {
    let updated = |old: Tensor<1>, new: &Tensor<1>| {
        let old = old.to_device(&new.device()).mul_scalar(1.0 - layer.momentum);
        old.add(new.clone().detach().mul_scalar(layer.momentum)).detach()
    };
    layer.running_mean.update(updated(layer.running_mean.value_sync(), mean));
    layer.running_var.update(updated(layer.running_var.value_sync(), variance));
}

/// Whether a pooling is that of ResNets.
fn is_residual_pool(layer: &MaxPool2d) -> bool {
    layer.kernel_size == [3, 3]
        && layer.stride == [2, 2]
        && layer.dilation == [1, 1]
        && !layer.ceil_mode
        && matches!(layer.padding, PaddingConfig2d::Explicit(1, 1, 1, 1))
}

/// `layer.forward(input)`.
///
/// # Shapes
/// - input: `[batch, channels, height, width]`
/// - output: `[batch, channels, height', width']`, sizes by the layer
pub(crate) fn max_pool(layer: &MaxPool2d, input: Tensor<4>) -> Tensor<4> {
    if !(is_residual_pool(layer) && is_ours(&input)) {
        return layer.forward(input);
    }
    Tensor::from_dispatch(Dispatch::training_max_pool(input.into_dispatch()))
}

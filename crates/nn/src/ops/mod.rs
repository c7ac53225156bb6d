//! Layers of the networks in training, on our own kernels where they run on the CPU.
//!
//! The modules stay Burn's: parameters, files and running statistics are theirs, only the
//! arithmetic is replaced, and only for tensors on the `flex` device with gradients. Everything
//! else takes Burn's way.
//!
//! * [`blocked`]: batches in the layout nChw16c on their way through a network in training.
//! * [`backend`]: the operations on them, as Burn's extension mechanism takes them.
//! * [`gradients`]: their gradients.
//! * [`layer`], [`unary`]: convolutions and operations of one input, by kind.
//! * [`mixed`]: convolutions in 16 bits.
//! * [`seven`]: the first layer of ResNets on Burn's own arithmetic.
//! * [`upsample`]: upsampling that trains on GPUs.
//! * `gpu`: layers and steps of the optimiser on GPUs.

mod backend;
mod blocked;
#[cfg(feature = "gpu-kernels")]
mod gpu;
mod gradients;
mod layer;
mod mixed;
mod seven;
mod unary;
mod upsample;

use std::sync::atomic::{AtomicBool, Ordering};

use burn::nn::BatchNorm;
use burn::nn::conv::Conv2d;
use burn::tensor::activation::relu;
use burn::tensor::{DType, Device, Tensor};

pub(crate) use evpose_kernels::training::Activation;

pub(crate) use blocked::Blocked;
#[cfg(feature = "gpu-kernels")]
pub(crate) use gpu::adam as gpu_adam;
pub(crate) use mixed::widened;
pub(crate) use upsample::upsample;

static ENABLED: AtomicBool = AtomicBool::new(true);

/// Sets whether training on the `flex` device computes with our own kernels, as it does by default,
/// or with Burn's. For comparisons; holds for the whole process.
pub fn set_training_kernels(enabled: bool) {
    ENABLED.store(enabled, Ordering::Relaxed);
}

/// Whether a network that is given `input` computes with our kernels.
pub(crate) fn is_ours(input: &Tensor<4>) -> bool {
    let device = input.device();
    ENABLED.load(Ordering::Relaxed)
        && device.is_autodiff()
        && device == Device::flex()
        && input.dtype() == DType::F32
}

/// `layer.forward(input)` in the number format of `input`, on the CPU by Burn.
///
/// # Shapes
/// - input: `[batch, channels_in, height, width]`
/// - output: `[batch, channels_out, height', width']`, sizes by the layer
pub(crate) fn conv2d(layer: &Conv2d, input: Tensor<4>) -> Tensor<4> {
    #[cfg(feature = "gpu-kernels")]
    if gpu::suits(layer, &input) {
        return gpu::forward(layer, input);
    }
    if mixed::is_half(&input) {
        return mixed::conv2d(layer, input);
    }
    if seven::suits(layer) { seven::stride_two_seven(layer, input) } else { layer.forward(input) }
}

/// `activation(layer.forward(input))`, on the CPU by Burn, and in 32 bits whatever the format of `input`, which is
/// also that of the output.
///
/// # Shapes
/// - input, output: `[batch, channels, height, width]`
pub(crate) fn batch_norm(layer: &BatchNorm, input: Tensor<4>, activation: Activation) -> Tensor<4> {
    if mixed::is_half(&input) {
        let format = input.dtype();
        return batch_norm(layer, widened(input), activation).cast(format);
    }
    #[cfg(feature = "gpu-kernels")]
    if gpu::normalizes(layer, &input) {
        return gpu::normalized(layer, input, activation);
    }
    let output = layer.forward(input);
    match activation {
        Activation::Identity => output,
        Activation::Relu => relu(output),
        Activation::Relu6 => output.clamp(0.0, 6.0),
    }
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

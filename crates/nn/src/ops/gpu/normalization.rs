//! Batch normalisation on GPUs as a layer, with its gradient.
#![allow(clippy::type_complexity, reason = "extensions of a backend return tuples, spelled out")]

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Backend, Cube, Dispatch, backend_extension};
use burn::nn::BatchNorm;
use burn::tensor::{DType, Tensor};
use burn_cubecl::tensor::CubeTensor;

use super::norm::{self, Norm, NormGradients};
use super::{Activation, Way, is_gpu};

/// Whether a normalisation is computed here.
pub(crate) fn normalizes(layer: &BatchNorm, input: &Tensor<4>) -> bool {
    let device = input.device();
    // Gradients here are those of a layer that takes its statistics from the batch.
    (layer.training.is_enabled() || !device.is_autodiff())
        && input.dtype() == DType::F32
        && Way::chosen() != Way::Burn
        && is_gpu(&device)
}

/// `activation(layer.forward(input))`. In training it moves the running statistics, as Burn's layer does.
///
/// # Shapes
/// - input, output: `[batch, channels, height, width]`
pub(crate) fn normalized(layer: &BatchNorm, input: Tensor<4>, activation: Activation) -> Tensor<4> {
    let device = input.device();
    let is_trained = device.is_autodiff();
    let running = [&layer.running_mean, &layer.running_var];
    let [mean, variance] = running.map(|running| {
        // As in Burn's layer, updates by other threads are merged before the mean moves on.
        let value = if is_trained { running.value_sync() } else { running.value() };
        value.to_device(&device).into_dispatch()
    });
    let (mean, variance) = if is_trained {
        let momentum = layer.momentum as f32;
        let of = input.clone().into_dispatch();
        let (statistics, running) = Dispatch::gpu_statistics(of, mean, variance, momentum);
        // Without `detach`, the graphs of all batches would hang together.
        layer.running_mean.update(Tensor::from_dispatch(running.0).detach());
        layer.running_var.update(Tensor::from_dispatch(running.1).detach());
        statistics
    } else {
        (mean, variance)
    };
    Tensor::from_dispatch(Dispatch::gpu_norm(
        input.into_dispatch(),
        layer.gamma.val().into_dispatch(),
        layer.beta.val().into_dispatch(),
        mean,
        variance,
        layer.epsilon as f32,
        activation,
    ))
}

#[backend_extension(Cube, Autodiff)]
trait GpuNormalization: Backend {
    /// Mean and variance of each channel, and the running ones moved towards them.
    fn gpu_statistics(
        input: FloatTensor<Self>,
        running_mean: FloatTensor<Self>,
        running_variance: FloatTensor<Self>,
        momentum: f32,
    ) -> ((FloatTensor<Self>, FloatTensor<Self>), (FloatTensor<Self>, FloatTensor<Self>));

    /// A normalisation by these statistics, then the activation. Gradients take them for those of the
    /// input.
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
    fn gpu_statistics(
        input: FloatTensor<Self>,
        running_mean: FloatTensor<Self>,
        running_variance: FloatTensor<Self>,
        momentum: f32,
    ) -> ((FloatTensor<Self>, FloatTensor<Self>), (FloatTensor<Self>, FloatTensor<Self>)) {
        let running = [running_mean, running_variance];
        let [mean, variance, next_mean, next_variance] = norm::statistics(input, running, momentum);
        ((mean, variance), (next_mean, next_variance))
    }

    fn gpu_norm(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        epsilon: f32,
        activation: Activation,
    ) -> FloatTensor<Self> {
        Norm { gamma, beta, mean, variance, epsilon, activation }.forward(input)
    }
}

impl<C: CheckpointStrategy> GpuNormalization for Autodiff<Cube, C> {
    fn gpu_statistics(
        input: FloatTensor<Self>,
        running_mean: FloatTensor<Self>,
        running_variance: FloatTensor<Self>,
        momentum: f32,
    ) -> ((FloatTensor<Self>, FloatTensor<Self>), (FloatTensor<Self>, FloatTensor<Self>)) {
        let running = [running_mean, running_variance].map(|running| running.primitive().clone());
        let statistics = norm::statistics(input.primitive().clone(), running, momentum);
        let [mean, variance, next_mean, next_variance] = statistics.map(FloatTensor::<Self>::new);
        ((mean, variance), (next_mean, next_variance))
    }

    fn gpu_norm(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        epsilon: f32,
        activation: Activation,
    ) -> FloatTensor<Self> {
        // Mean and variance need no node: the backward pass takes them for those of the input.
        let nodes = [input.node(), gamma.node(), beta.node()];
        let [gamma, beta, mean, variance] =
            [gamma, beta, mean, variance].map(|tensor| tensor.primitive().clone());
        let norm = Norm { gamma, beta, mean, variance, epsilon, activation };
        let output = norm.clone().forward(input.primitive().clone());
        match Normalization.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((input.primitive().clone(), norm), output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }
}

#[derive(Debug)]
struct Normalization;

impl Backward<Cube, 3> for Normalization {
    /// Input and normalisation.
    type State = (CubeTensor, Norm);

    fn backward(self, ops: Ops<Self::State, 3>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = grads.consume::<Cube>(&ops.node);
        let (input, norm) = ops.state;
        let NormGradients { input, gamma, beta } = norm.backward(input, dy);
        for (parent, gradient) in ops.parents.into_iter().zip([input, gamma, beta]) {
            if let Some(parent) = parent {
                grads.register::<Cube>(parent.id, gradient);
            }
        }
    }
}

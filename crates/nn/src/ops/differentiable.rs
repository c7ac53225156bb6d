//! The gradients of the operations in [`backend`](super::backend).

use std::sync::Arc;

use burn::backend::autodiff::NodeId;
use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Flex, TensorMetadata};
use burn::tensor::Shape;
use evpose_kernels::batch_norm::{Activation, Statistics};
use evpose_kernels::max_pool;

use super::backend::{
    self, TrainingOps, batch_norm, convolution, norm_shape, pool, tensor, values,
};

impl<C: CheckpointStrategy> TrainingOps for Autodiff<Flex, C> {
    fn training_conv2d(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        stride: usize,
        padding: usize,
    ) -> FloatTensor<Self> {
        let nodes = [input.node(), weight.node()];
        let output = convolution(input.primitive(), weight.primitive(), None, stride, padding);
        match Convolution.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(mut prep) => {
                let inputs = [prep.checkpoint(&input), prep.checkpoint(&weight)];
                prep.finish(ConvolutionState { inputs, stride, padding }, output)
            }
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }

    fn training_conv2d_biased(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        stride: usize,
        padding: usize,
    ) -> FloatTensor<Self> {
        let nodes = [input.node(), weight.node(), bias.node()];
        let [x, w, b] = [&input, &weight, &bias].map(FloatTensor::<Self>::primitive);
        let output = convolution(x, w, Some(b), stride, padding);
        match Convolution.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(mut prep) => {
                let inputs = [prep.checkpoint(&input), prep.checkpoint(&weight)];
                prep.finish(ConvolutionState { inputs, stride, padding }, output)
            }
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }

    fn training_batch_norm(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        epsilon: f32,
        activation: Activation,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>) {
        let channels = gamma.shape();
        let parents = [&input, &gamma, &beta];
        let nodes = parents.map(FloatTensor::<Self>::node);
        let primitives = parents.map(FloatTensor::<Self>::primitive);
        let (output, statistics) = batch_norm(primitives, epsilon, activation);
        let output = match Normalisation.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(mut prep) => {
                let inputs = parents.map(|parent| prep.checkpoint(parent));
                let statistics = Arc::new(statistics.clone());
                prep.finish(NormalisationState { inputs, statistics, epsilon, activation }, output)
            }
            OpsKind::UnTracked(prep) => prep.finish(output),
        };
        let Statistics { mean, variance } = statistics;
        let [mean, variance] =
            [mean, variance].map(|it| FloatTensor::<Self>::new(tensor(it, channels.clone())));
        (output, mean, variance)
    }

    fn training_max_pool(input: FloatTensor<Self>) -> FloatTensor<Self> {
        let (output, taps) = pool(input.primitive());
        match Pooling.prepare::<C>([input.node()]).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((input.shape(), Arc::new(taps)), output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }
}

#[derive(Debug)]
struct Convolution;

#[derive(Debug, Clone)]
struct ConvolutionState {
    /// Input and weight.
    inputs: [NodeId; 2],
    stride: usize,
    padding: usize,
}

/// Of input, weight and, with three parents, bias.
impl<const N: usize> Backward<Flex, N> for Convolution {
    type State = ConvolutionState;

    fn backward(self, ops: Ops<Self::State, N>, grads: &mut Gradients, kept: &mut Checkpointer) {
        let ConvolutionState { inputs, stride, padding } = ops.state;
        let gradient = grads.consume::<Flex>(&ops.node).to_contiguous();
        let [input, weight] =
            inputs.map(|id| kept.retrieve_node_output::<FloatTensor<Flex>>(id).to_contiguous());
        let conv = backend::Convolution::of(&input, &weight, stride, padding);
        let (x, w, dy) = (values(&input), values(&weight), values(&gradient));
        for (index, parent) in ops.parents.iter().enumerate() {
            let Some(parent) = parent else { continue };
            use backend::Convolution::{Depthwise, Full};
            let (of_parent, shape) = match (index, &conv) {
                (0, Full(conv)) => (conv.backward_input(w, dy), input.shape()),
                (0, Depthwise(conv)) => (conv.backward_input(w, dy), input.shape()),
                (1, Full(conv)) => (conv.backward_weight(x, dy), weight.shape()),
                (1, Depthwise(conv)) => (conv.backward_weight(x, dy), weight.shape()),
                (_, Full(conv)) => (conv.backward_bias(dy), Shape::from([conv.channels_out])),
                (_, Depthwise(conv)) => (conv.backward_bias(dy), Shape::from([conv.channels])),
            };
            grads.register::<Flex>(parent.id, tensor(of_parent, shape));
        }
    }
}

#[derive(Debug)]
struct Normalisation;

#[derive(Debug, Clone)]
struct NormalisationState {
    /// Input, gamma and beta.
    inputs: [NodeId; 3],
    statistics: Arc<Statistics>,
    epsilon: f32,
    activation: Activation,
}

impl Backward<Flex, 3> for Normalisation {
    type State = NormalisationState;

    fn backward(self, ops: Ops<Self::State, 3>, grads: &mut Gradients, kept: &mut Checkpointer) {
        let NormalisationState { inputs, statistics, epsilon, activation } = ops.state;
        let gradient = grads.consume::<Flex>(&ops.node).to_contiguous();
        let [input, gamma, beta] =
            inputs.map(|id| kept.retrieve_node_output::<FloatTensor<Flex>>(id).to_contiguous());
        let gradients = norm_shape(&input, epsilon, activation).backward(
            values(&input),
            values(&gamma),
            values(&beta),
            &statistics,
            values(&gradient),
        );
        let of_parents = [
            (gradients.input, input.shape()),
            (gradients.gamma, gamma.shape()),
            (gradients.beta, beta.shape()),
        ];
        for (parent, (values, shape)) in ops.parents.iter().zip(of_parents) {
            if let Some(parent) = parent {
                grads.register::<Flex>(parent.id, tensor(values, shape));
            }
        }
    }
}

#[derive(Debug)]
struct Pooling;

impl Backward<Flex, 1> for Pooling {
    /// Shape of the input, and which tap was the largest.
    type State = (Shape, Arc<Vec<u8>>);

    fn backward(self, ops: Ops<Self::State, 1>, grads: &mut Gradients, _: &mut Checkpointer) {
        let (shape, taps) = ops.state;
        let gradient = grads.consume::<Flex>(&ops.node).to_contiguous();
        if let [Some(parent)] = &ops.parents {
            let [_, _, height, width] = shape.dims();
            let input = max_pool::backward(values(&gradient), &taps, [height, width]);
            grads.register::<Flex>(parent.id, tensor(input, shape));
        }
    }
}

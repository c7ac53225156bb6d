//! The gradients of the operations in [`backend`](super::backend).
//!
//! Each operation stores its input as it was before the normalisation, which the backward pass
//! repeats.

use std::sync::Arc;

use burn::backend::autodiff::NodeId;
use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Flex, TensorMetadata};
use burn::tensor::Shape;
use evpose_kernels::training::{Blocks, Norm, NormalizedInput, activation_backward, backward_bias};

use super::backend::{
    AddSettings, ConvSettings, NormSettings, TrainingOps, UnarySettings, blocked, blocks,
    convolution, from_planes, norm, statistics, sum, tensor, to_planes, unary, values,
};

type Values = FloatTensor<Flex>;

/// The stored input of an operation, and its normalisation.
#[derive(Debug, Clone)]
struct StoredInput {
    values: Values,
    norm: Option<Arc<Norm>>,
    shape: Blocks,
}

impl StoredInput {
    /// `tensors` are gamma, beta, mean and variance.
    fn new(
        input: &Values,
        tensors: [&Values; 4],
        settings: Option<NormSettings>,
        channels: usize,
    ) -> Self {
        let norm = norm(tensors, settings).map(Arc::new);
        Self { values: input.to_contiguous(), norm, shape: blocks(input, channels) }
    }

    fn input(&self) -> NormalizedInput<'_> {
        NormalizedInput { values: values(&self.values), norm: self.norm.as_deref() }
    }

    /// Registers the gradients by input, gamma and beta, the first three of `parents`, from that by
    /// the normalised input.
    fn register(&self, parents: &[Option<NodeId>], mut gradient: Vec<f32>, to: &mut Gradients) {
        let mut register = |parent: usize, tensor: Values| {
            if let Some(Some(parent)) = parents.get(parent) {
                to.register::<Flex>(*parent, tensor);
            }
        };
        if let Some(norm) = &self.norm {
            let parameters = norm.backward(&self.shape, values(&self.values), &mut gradient);
            let channels = Shape::from([self.shape.channels]);
            register(1, tensor(parameters.gamma, channels.clone()));
            register(2, tensor(parameters.beta, channels));
        }
        register(0, blocked(gradient, &self.shape));
    }
}

/// The parents that need a gradient.
fn tracked<S, const N: usize>(ops: &Ops<S, N>) -> [Option<NodeId>; N] {
    ops.parents.each_ref().map(|parent| parent.as_ref().map(|parent| parent.id))
}

/// The gradient by the output of an operation, contiguous.
fn gradient<S, const N: usize>(ops: &Ops<S, N>, grads: &mut Gradients) -> Values {
    grads.consume::<Flex>(&ops.node).to_contiguous()
}

impl<C: CheckpointStrategy> TrainingOps for Autodiff<Flex, C> {
    fn blocked_from_planes(planes: FloatTensor<Self>) -> FloatTensor<Self> {
        let (output, shape) = from_planes(planes.primitive());
        match FromPlanes.prepare::<C>([planes.node()]).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish(shape, output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }

    fn blocked_to_planes(input: FloatTensor<Self>, channels: usize) -> FloatTensor<Self> {
        let (output, shape) = to_planes(input.primitive(), channels);
        match ToPlanes.prepare::<C>([input.node()]).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish(shape, output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }

    fn blocked_statistics(
        input: FloatTensor<Self>,
        channels: usize,
    ) -> (FloatTensor<Self>, FloatTensor<Self>) {
        let (mean, variance) = statistics(input.primitive(), channels);
        (FloatTensor::<Self>::new(mean), FloatTensor::<Self>::new(variance))
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
        let tensors = [&gamma, &beta, &mean, &variance].map(FloatTensor::<Self>::primitive);
        let channels = settings.layer.input().channels;
        let stored = StoredInput::new(input.primitive(), tensors, settings.norm, channels);
        let [w, b] = [&weight, &bias].map(FloatTensor::<Self>::primitive);
        let output = convolution(&stored.values, stored.norm.as_deref(), w, b, settings);
        let nodes = [input.node(), gamma.node(), beta.node(), weight.node(), bias.node()];
        // Without a tracked input nothing is kept: inference needs no memory for a backward pass.
        match Convolution.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((stored, w.to_contiguous(), settings), output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }

    fn blocked_unary(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        settings: UnarySettings,
    ) -> FloatTensor<Self> {
        let tensors = [&gamma, &beta, &mean, &variance].map(FloatTensor::<Self>::primitive);
        let (channels, by) = (settings.channels, settings.norm);
        let stored = StoredInput::new(input.primitive(), tensors, by, channels);
        let (output, taps) = unary(&stored.values, stored.norm.as_deref(), settings);
        let nodes = [input.node(), gamma.node(), beta.node()];
        match Unary.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((stored, Arc::new(taps), settings), output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
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
        let tensors = [&gamma, &beta, &mean, &variance].map(FloatTensor::<Self>::primitive);
        let (channels, by) = (settings.channels, settings.norm);
        let stored = StoredInput::new(input.primitive(), tensors, by, channels);
        let norm = stored.norm.as_deref();
        let output = sum(&stored.values, norm, other.primitive(), settings);
        let nodes = [input.node(), gamma.node(), beta.node(), other.node()];
        match Sum.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((stored, output.clone(), settings), output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }
}

#[derive(Debug)]
struct FromPlanes;

impl Backward<Flex, 1> for FromPlanes {
    type State = Blocks;

    fn backward(self, ops: Ops<Self::State, 1>, grads: &mut Gradients, _: &mut Checkpointer) {
        let gradient = gradient(&ops, grads);
        if let [Some(parent)] = &ops.parents {
            let planes = to_planes(&gradient, ops.state.channels).0;
            grads.register::<Flex>(parent.id, planes);
        }
    }
}

#[derive(Debug)]
struct ToPlanes;

impl Backward<Flex, 1> for ToPlanes {
    type State = Blocks;

    fn backward(self, ops: Ops<Self::State, 1>, grads: &mut Gradients, _: &mut Checkpointer) {
        let gradient = gradient(&ops, grads);
        if let [Some(parent)] = &ops.parents {
            grads.register::<Flex>(parent.id, from_planes(&gradient).0);
        }
    }
}

#[derive(Debug)]
struct Convolution;

impl Backward<Flex, 5> for Convolution {
    /// Input, weight and settings.
    type State = (StoredInput, Values, ConvSettings);

    fn backward(self, ops: Ops<Self::State, 5>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = gradient(&ops, grads);
        let (stored, weight, ConvSettings { layer, .. }) = &ops.state;
        let parents = tracked(&ops);
        if let Some(parent) = parents[3] {
            let by_weight = layer.backward_weight(stored.input(), values(&dy));
            grads.register::<Flex>(parent, tensor(by_weight, weight.shape()));
        }
        if let Some(parent) = parents[4] {
            let out = layer.output();
            let by_bias = backward_bias(&out, values(&dy));
            grads.register::<Flex>(parent, tensor(by_bias, Shape::from([out.channels])));
        }
        // Images need no gradient: the first layer of a network skips the largest pass.
        if parents[..3].iter().any(Option::is_some) {
            let by_input = layer.backward_input(values(weight), values(&dy));
            // As large as an activation, and of no further use.
            drop(dy);
            stored.register(&parents[..3], by_input, grads);
        }
    }
}

#[derive(Debug)]
struct Unary;

impl Backward<Flex, 3> for Unary {
    /// Input, indices of the largest values, and settings.
    type State = (StoredInput, Arc<Vec<u8>>, UnarySettings);

    fn backward(self, ops: Ops<Self::State, 3>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = gradient(&ops, grads);
        let (stored, taps, settings) = &ops.state;
        let by_input = settings.op.backward(values(&dy), taps);
        stored.register(&tracked(&ops), by_input, grads);
    }
}

#[derive(Debug)]
struct Sum;

impl Backward<Flex, 4> for Sum {
    /// Input, output and settings.
    type State = (StoredInput, Values, AddSettings);

    fn backward(self, ops: Ops<Self::State, 4>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = gradient(&ops, grads);
        let (stored, output, settings) = &ops.state;
        let by_sum = activation_backward(settings.activation, values(output), values(&dy));
        drop(dy);
        let parents = tracked(&ops);
        if let Some(parent) = parents[3] {
            grads.register::<Flex>(parent, blocked(by_sum.clone(), &stored.shape));
        }
        stored.register(&parents[..3], by_sum, grads);
    }
}

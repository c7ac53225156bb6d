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
use evpose_kernels::training::{
    Activation, Blocks, Norm, NormalizedInput, activation_backward, backward_bias,
};

use super::backend::{
    BlockedOp, NormSettings, OpSettings, TrainingOps, applied, blocked, blocks, from_planes, norm,
    statistics, tensor, to_planes, values,
};
use super::layer::ConvLayer;
use super::unary::UnaryOp;

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
        let tensors = [&gamma, &beta, &mean, &variance].map(FloatTensor::<Self>::primitive);
        let OpSettings { norm, channels, op } = settings;
        let stored = StoredInput::new(input.primitive(), tensors, norm, channels);
        let taken = [&first, &second].map(FloatTensor::<Self>::primitive);
        let (output, taps) = applied(&stored.values, stored.norm.as_deref(), taken, settings);
        let nodes = [input.node(), gamma.node(), beta.node(), first.node(), second.node()];
        // Without a tracked input nothing is kept: inference needs no memory for a backward pass.
        match Operation.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => {
                let saved = match op {
                    BlockedOp::Conv { layer, .. } => Saved::Conv(layer, taken[0].to_contiguous()),
                    BlockedOp::Unary(op) => Saved::Unary(op, Arc::new(taps)),
                    // The output alone shows which values its activation clamped.
                    BlockedOp::Add(activation) => Saved::Sum(activation, output.clone()),
                };
                prep.finish((stored, saved), output)
            }
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

/// State of the backward pass of an operation, besides its input.
#[derive(Debug, Clone)]
enum Saved {
    /// With the weight.
    Conv(ConvLayer, Values),
    /// With the indices of the largest values.
    Unary(UnaryOp, Arc<Vec<u8>>),
    /// With the output.
    Sum(Activation, Values),
}

#[derive(Debug)]
struct Operation;

impl Backward<Flex, 5> for Operation {
    type State = (StoredInput, Saved);

    fn backward(self, ops: Ops<Self::State, 5>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = gradient(&ops, grads);
        let (stored, saved) = &ops.state;
        let parents = tracked(&ops);
        let by_input = match saved {
            Saved::Conv(layer, weight) => {
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
                if parents[..3].iter().all(Option::is_none) {
                    return;
                }
                layer.backward_input(values(weight), values(&dy))
            }
            Saved::Unary(op, taps) => op.backward(values(&dy), taps),
            Saved::Sum(activation, output) => {
                activation_backward(*activation, values(output), values(&dy))
            }
        };
        // As large as an activation, and of no further use.
        drop(dy);
        if let (Saved::Sum(..), Some(parent)) = (saved, parents[3]) {
            grads.register::<Flex>(parent, blocked(by_input.clone(), &stored.shape));
        }
        stored.register(&parents[..3], by_input, grads);
    }
}

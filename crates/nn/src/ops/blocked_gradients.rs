//! The gradients of the operations in [`blocked_backend`](super::blocked_backend).
//!
//! What an operation takes is kept, normalised tensors without their normalisation.

use std::sync::Arc;

use burn::backend::autodiff::NodeId;
use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Flex, TensorMetadata};
use burn::tensor::Shape;
use evpose_kernels::batch_norm::Activation;
use evpose_kernels::training::{Blocks, Conv, Input, MaxPool, Norm, through};

use super::backend::{tensor, values};
use super::blocked_backend::{
    BlockedOps, How, added, blocked, blocks, convolution, from_planes, norm, pooled, to_planes,
    written,
};

type Values = FloatTensor<Flex>;

/// A tensor that is kept, and how it is normalised.
#[derive(Debug, Clone)]
struct Normed {
    input: Values,
    norm: Arc<Norm>,
    shape: Blocks,
}

impl Normed {
    fn new(input: &Values, by: [&Values; 4], how: How) -> Self {
        let shape = blocks(input, by[0].shape()[0]);
        Self { input: input.to_contiguous(), norm: Arc::new(norm(by, how)), shape }
    }

    fn input(&self) -> Input<'_> {
        Input { values: values(&self.input), norm: Some(&self.norm) }
    }

    /// Registers the gradients by the tensor, gamma and beta, from that by what is normalised.
    fn register(&self, parents: &[Option<NodeId>], mut gradient: Vec<f32>, to: &mut Gradients) {
        let by = self.norm.backward(&self.shape, values(&self.input), &mut gradient);
        let channels = Shape::from([self.shape.channels]);
        let all = [
            blocked(gradient, &self.shape),
            tensor(by.gamma, channels.clone()),
            tensor(by.beta, channels),
        ];
        for (parent, gradient) in parents.iter().zip(all) {
            if let Some(parent) = parent {
                to.register::<Flex>(*parent, gradient);
            }
        }
    }
}

/// Which gradients are asked for.
fn asked<S, const N: usize>(ops: &Ops<S, N>) -> [Option<NodeId>; N] {
    ops.parents.each_ref().map(|parent| parent.as_ref().map(|parent| parent.id))
}

/// The numbers of the gradient by the output of an operation.
fn gradient<S, const N: usize>(ops: &Ops<S, N>, grads: &mut Gradients) -> Values {
    grads.consume::<Flex>(&ops.node).to_contiguous()
}

impl<C: CheckpointStrategy> BlockedOps for Autodiff<Flex, C> {
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

    fn blocked_conv(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        conv: Conv,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>) {
        let [x, w] = [&input, &weight].map(FloatTensor::<Self>::primitive);
        let (output, mean, variance) = convolution(x, None, w, conv);
        let nodes = [input.node(), weight.node()];
        let output = match Convolution.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((x.to_contiguous(), w.clone(), conv), output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        };
        (output, FloatTensor::<Self>::new(mean), FloatTensor::<Self>::new(variance))
    }

    fn blocked_norm_conv(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
        weight: FloatTensor<Self>,
        conv: Conv,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>) {
        let by = [&gamma, &beta, &mean, &variance].map(FloatTensor::<Self>::primitive);
        let normed = Normed::new(input.primitive(), by, how);
        let w = weight.primitive();
        let (output, mean, variance) = convolution(&normed.input, Some(&normed.norm), w, conv);
        let nodes = [input.node(), gamma.node(), beta.node(), weight.node()];
        let output = match NormConvolution.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((normed, w.clone(), conv), output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        };
        (output, FloatTensor::<Self>::new(mean), FloatTensor::<Self>::new(variance))
    }

    fn blocked_norm(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
    ) -> FloatTensor<Self> {
        let by = [&gamma, &beta, &mean, &variance].map(FloatTensor::<Self>::primitive);
        let normed = Normed::new(input.primitive(), by, how);
        let output = written(&normed.input, &normed.norm, normed.shape.channels);
        let nodes = [input.node(), gamma.node(), beta.node()];
        match Written.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish(normed, output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }

    fn blocked_norm_add(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
        other: FloatTensor<Self>,
        activation: Activation,
    ) -> FloatTensor<Self> {
        let by = [&gamma, &beta, &mean, &variance].map(FloatTensor::<Self>::primitive);
        let normed = Normed::new(input.primitive(), by, how);
        let channels = normed.shape.channels;
        let output = added(&normed.input, &normed.norm, other.primitive(), channels, activation);
        let nodes = [input.node(), gamma.node(), beta.node(), other.node()];
        match Sum.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((normed, output.clone(), activation), output),
            OpsKind::UnTracked(prep) => prep.finish(output),
        }
    }

    fn blocked_norm_max_pool(
        input: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        mean: FloatTensor<Self>,
        variance: FloatTensor<Self>,
        how: How,
    ) -> FloatTensor<Self> {
        let by = [&gamma, &beta, &mean, &variance].map(FloatTensor::<Self>::primitive);
        let normed = Normed::new(input.primitive(), by, how);
        let (output, taps) = pooled(&normed.input, &normed.norm, normed.shape.channels);
        let nodes = [input.node(), gamma.node(), beta.node()];
        match Pooling.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((normed, Arc::new(taps)), output),
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

/// The gradient by a weight.
fn by_weight(conv: &Conv, input: Input<'_>, weight: &Values, dy: &Values) -> Values {
    tensor(conv.backward_weight(input, values(dy)), weight.shape())
}

#[derive(Debug)]
struct Convolution;

impl Backward<Flex, 2> for Convolution {
    /// Input, weight and shape.
    type State = (Values, Values, Conv);

    fn backward(self, ops: Ops<Self::State, 2>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = gradient(&ops, grads);
        let (input, weight, conv) = &ops.state;
        if let Some(parent) = &ops.parents[1] {
            let by = by_weight(conv, values(input).into(), weight, &dy);
            grads.register::<Flex>(parent.id, by);
        }
        if let Some(parent) = &ops.parents[0] {
            let by = conv.backward_input(values(&weight.to_contiguous()), values(&dy));
            grads.register::<Flex>(parent.id, blocked(by, &conv.input));
        }
    }
}

#[derive(Debug)]
struct NormConvolution;

impl Backward<Flex, 4> for NormConvolution {
    /// Input, weight and shape.
    type State = (Normed, Values, Conv);

    fn backward(self, ops: Ops<Self::State, 4>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = gradient(&ops, grads);
        let (normed, weight, conv) = &ops.state;
        if let Some(parent) = &ops.parents[3] {
            grads.register::<Flex>(parent.id, by_weight(conv, normed.input(), weight, &dy));
        }
        if ops.parents[..3].iter().any(Option::is_some) {
            let by = conv.backward_input(values(&weight.to_contiguous()), values(&dy));
            drop(dy);
            normed.register(&asked(&ops)[..3], by, grads);
        }
    }
}

#[derive(Debug)]
struct Written;

impl Backward<Flex, 3> for Written {
    type State = Normed;

    fn backward(self, ops: Ops<Self::State, 3>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = values(&gradient(&ops, grads)).to_vec();
        ops.state.register(&asked(&ops), dy, grads);
    }
}

#[derive(Debug)]
struct Sum;

impl Backward<Flex, 4> for Sum {
    /// What is normalised, the output, and what was done to the sum.
    type State = (Normed, Values, Activation);

    fn backward(self, ops: Ops<Self::State, 4>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = gradient(&ops, grads);
        let (normed, output, activation) = &ops.state;
        let by = through(*activation, values(output), values(&dy));
        drop(dy);
        if let Some(parent) = &ops.parents[3] {
            grads.register::<Flex>(parent.id, blocked(by.clone(), &normed.shape));
        }
        normed.register(&asked(&ops)[..3], by, grads);
    }
}

#[derive(Debug)]
struct Pooling;

impl Backward<Flex, 3> for Pooling {
    /// What is normalised, and which tap was the largest.
    type State = (Normed, Arc<Vec<u8>>);

    fn backward(self, ops: Ops<Self::State, 3>, grads: &mut Gradients, _: &mut Checkpointer) {
        let dy = gradient(&ops, grads);
        let (normed, taps) = &ops.state;
        let by = MaxPool { input: normed.shape }.backward(values(&dy), taps);
        normed.register(&asked(&ops), by, grads);
    }
}

//! The graph of a network: its layers in order with their weights, for engines that compile it.
//!
//! It is traced from the forward pass, as `torch.fx` does. Batch normalisation of a trained network
//! is a scale and a shift for each channel; both are folded into the convolution before it, in
//! double precision.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use burn::module::{Module, Param, ParamId};
use burn::nn::conv::Conv2d;
use burn::nn::pool::{AdaptiveAvgPool2d, MaxPool2d};
use burn::nn::{BatchNorm, Linear, PaddingConfig2d};
use burn::tensor::Tensor;

pub use evpose_kernels::training::Activation;

use crate::conv_norm::ConvNorm;
use crate::net_ops::{NetOps, VectorOps};
use crate::parameters::paths;

/// Index of a node in [`Graph::nodes`].
pub type NodeId = usize;

/// The operation of a node; the names of ONNX where there is one.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Operation {
    /// The input image.
    Input,
    /// Convolution, bias, activation.
    Conv(ConvLayer),
    /// Max pooling; padding does not count.
    MaxPool {
        /// Rows and columns of a window.
        window: [usize; 2],
        /// Vertical and horizontal stride, in pixels.
        stride: [usize; 2],
        /// Pixels of padding above and to the left.
        padding: [usize; 2],
    },
    /// Adaptive average pooling to a fixed number of fields, which cover the image evenly.
    MeanPool {
        /// Rows and columns of the output.
        fields: [usize; 2],
    },
    /// All values, channel by channel, as a vector.
    Flatten,
    /// A fully connected layer.
    Linear(LinearLayer),
    /// Elementwise sum of two inputs.
    Add,
    /// `max(x, 0)`.
    Relu,
    /// A range of the channels.
    Channels(Range<usize>),
    /// The channels of two inputs, alternating.
    Interleave,
    /// The channels of all inputs, one input after the other.
    Concat,
    /// Twice as many rows and columns by bilinear interpolation with half-pixel centres: row `y`
    /// lies at `(y + 0.5) / 2 - 0.5` of the input, clamped to its rows; columns alike.
    Upsample,
    /// The logistic function, `1 / (1 + exp(-x))`.
    Sigmoid,
    /// `factor * x + offset`.
    Affine {
        /// The multiplier of every value.
        factor: f32,
        /// Constant that is added to every product.
        offset: f32,
    },
}

/// A convolution with its bias and activation.
#[derive(Debug, Clone, PartialEq)]
pub struct ConvLayer {
    /// Output channels, input channels per group, rows and columns of the kernel.
    pub shape: [usize; 4],
    /// Groups of channels; each is convolved by itself.
    pub groups: usize,
    /// Vertical and horizontal stride, in pixels.
    pub stride: [usize; 2],
    /// Zeros above, on the left, below and on the right.
    pub padding: [usize; 4],
    /// Vertical and horizontal dilation, in pixels.
    pub dilation: [usize; 2],
    /// Weights of `shape`, row-major.
    pub weight: Vec<f32>,
    /// One value for each output channel.
    pub bias: Vec<f32>,
    /// The activation of the sums.
    pub activation: Activation,
}

/// A fully connected layer.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearLayer {
    /// Input and output values.
    pub shape: [usize; 2],
    /// Weights `[inputs, outputs]`, row-major.
    pub weight: Vec<f32>,
    /// One value for each output.
    pub bias: Vec<f32>,
}

/// A layer or another operation of a network.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Its name: the path of its layer, such as `backbone.stages.0.1.first`, else the operation.
    pub name: String,
    /// Operation that makes its output.
    pub operation: Operation,
    /// The nodes of its inputs, all before it.
    pub inputs: Vec<NodeId>,
    /// Channels of the output, values of a vector.
    pub channels: usize,
}

/// A network as its nodes in topological order.
#[derive(Debug, Clone, PartialEq)]
pub struct Graph {
    /// All nodes; the first is the input.
    pub nodes: Vec<Node>,
    /// The nodes of the outputs.
    pub outputs: Vec<NodeId>,
}

impl Graph {
    /// Traces `forward` with an image of `channels` channels. Layers are named by their paths in
    /// `module`.
    pub(crate) fn trace<M: Module>(
        module: &M,
        channels: usize,
        forward: impl FnOnce(TracedNode) -> Vec<TracedNode>,
    ) -> Self {
        let nodes = Nodes { list: Vec::new(), paths: paths(module) };
        let nodes = Rc::new(RefCell::new(nodes));
        let root = TracedNode { id: 0, channels, nodes: Rc::clone(&nodes) };
        let input = root.node("input", Operation::Input, vec![], channels);
        let outputs = forward(input).into_iter().map(|output| output.id).collect();
        // `root` still shares the list, so it cannot be unwrapped from its `Rc`.
        let nodes = std::mem::take(&mut nodes.borrow_mut().list);
        Self { nodes, outputs }
    }
}

struct Nodes {
    list: Vec<Node>,
    paths: HashMap<ParamId, String>,
}

/// A node that stands for its value while a network is traced: a `Proxy` of `torch.fx`.
#[derive(Clone)]
pub(crate) struct TracedNode {
    id: NodeId,
    channels: usize,
    nodes: Rc<RefCell<Nodes>>,
}

impl TracedNode {
    fn node(&self, name: &str, operation: Operation, inputs: Vec<NodeId>, channels: usize) -> Self {
        let mut nodes = self.nodes.borrow_mut();
        let id = nodes.list.len();
        nodes.list.push(Node { name: name.to_owned(), operation, inputs, channels });
        Self { id, channels, nodes: Rc::clone(&self.nodes) }
    }

    fn next(&self, name: &str, operation: Operation, channels: usize) -> Self {
        self.node(name, operation, vec![self.id], channels)
    }

    /// The path of the layer that holds a parameter.
    fn layer<const D: usize>(&self, param: &Param<Tensor<D>>) -> String {
        let nodes = self.nodes.borrow();
        let path = nodes.paths.get(&param.id).map_or("layer", String::as_str);
        path.rsplit_once('.').map_or(path, |(layer, _)| layer).to_owned()
    }

    fn convolution(
        &self,
        layer: &Conv2d,
        norm: Option<&BatchNorm>,
        activation: Activation,
    ) -> Self {
        let shape = layer.weight.dims();
        let mut weight = values(layer.weight.val());
        let bias = layer.bias.as_ref();
        // A convolution without a bias gets one of zeros, for the normalisation to fold into.
        let mut bias = bias.map_or_else(|| vec![0.0; shape[0]], |bias| values(bias.val()));
        if let Some(norm) = norm {
            fold(norm, &mut weight, &mut bias);
        }
        let [top, left, bottom, right] = match layer.padding {
            PaddingConfig2d::Explicit(top, left, bottom, right) => [top, left, bottom, right],
            PaddingConfig2d::Valid => [0; 4],
            // As Burn pads: an odd remainder goes below and to the right.
            PaddingConfig2d::Same => {
                let [down, across] = [shape[2] - 1, shape[3] - 1];
                [down / 2, across / 2, down - down / 2, across - across / 2]
            }
        };
        let name = self.layer(&layer.weight);
        // Convolution and normalisation are one layer: the name is that of both.
        let name = name.strip_suffix(".conv").unwrap_or(&name).to_owned();
        let conv = ConvLayer {
            shape,
            groups: layer.groups,
            stride: layer.stride,
            padding: [top, left, bottom, right],
            dilation: layer.dilation,
            weight,
            bias,
            activation,
        };
        self.next(&name, Operation::Conv(conv), shape[0])
    }
}

/// Folds the scale and the shift of a trained normalisation into the convolution before it.
fn fold(norm: &BatchNorm, weight: &mut [f32], bias: &mut [f32]) {
    let gamma = values(norm.gamma.val());
    let beta = values(norm.beta.val());
    let mean = values(norm.running_mean.value_sync());
    let variance = values(norm.running_var.value_sync());
    let kernel_size = weight.len() / bias.len();
    for (channel, kernel) in weight.chunks_mut(kernel_size).enumerate() {
        let [gamma, beta, mean, variance] =
            [&gamma, &beta, &mean, &variance].map(|values| f64::from(values[channel]));
        // In double precision, once: an error here would be in every output of the channel.
        let scale = gamma / (variance + norm.epsilon).sqrt();
        kernel.iter_mut().for_each(|value| *value = (f64::from(*value) * scale) as f32);
        bias[channel] = ((f64::from(bias[channel]) - mean) * scale + beta) as f32;
    }
}

fn values<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    let values = tensor.into_data().try_into_vec();
    values.unwrap_or_else(|error| unreachable!("weights are f32: {error:?}"))
}

impl NetOps for TracedNode {
    type Vector = Self;

    fn channels(&self) -> usize {
        self.channels
    }

    fn conv(self, layer: &Conv2d) -> Self {
        self.convolution(layer, None, Activation::Identity)
    }

    fn conv_norm(self, layer: &ConvNorm, activation: Activation) -> Self {
        self.convolution(&layer.conv, Some(&layer.norm), activation)
    }

    fn max_pool(self, layer: &MaxPool2d) -> Self {
        let padding = match layer.padding {
            PaddingConfig2d::Explicit(top, left, ..) => [top, left],
            _ => [0; 2],
        };
        let pool = Operation::MaxPool { window: layer.kernel_size, stride: layer.stride, padding };
        self.next("max-pool", pool, self.channels)
    }

    fn add(self, other: Self) -> Self {
        self.node("add", Operation::Add, vec![self.id, other.id], self.channels)
    }

    fn relu(self) -> Self {
        self.next("relu", Operation::Relu, self.channels)
    }

    fn narrow(self, channels: Range<usize>) -> Self {
        let count = channels.len();
        self.next("channels", Operation::Channels(channels), count)
    }

    fn interleave(self, other: Self) -> Self {
        let channels = 2 * self.channels;
        self.node("interleave", Operation::Interleave, vec![self.id, other.id], channels)
    }

    fn concat(parts: Vec<Self>) -> Self {
        let channels = parts.iter().map(|part| part.channels).sum();
        let inputs = parts.iter().map(|part| part.id).collect();
        parts[0].node("concat", Operation::Concat, inputs, channels)
    }

    /// A depthwise convolution with equal weights.
    fn local_mean(self) -> Self {
        let channels = self.channels;
        let conv = ConvLayer {
            shape: [channels, 1, 3, 3],
            groups: channels,
            stride: [1; 2],
            padding: [1; 4],
            dilation: [1; 2],
            weight: vec![1.0 / 9.0; 9 * channels],
            bias: vec![0.0; channels],
            // Pixels at the edges are divided by nine as well: zeros beyond the edges count.
            activation: Activation::Identity,
        };
        self.next("local-mean", Operation::Conv(conv), channels)
    }

    fn upsample(self) -> Self {
        self.next("upsample", Operation::Upsample, self.channels)
    }

    fn sigmoid(self) -> Self {
        self.next("sigmoid", Operation::Sigmoid, self.channels)
    }

    fn affine(self, factor: f32, offset: f32) -> Self {
        self.next("affine", Operation::Affine { factor, offset }, self.channels)
    }

    fn avg_pool(self, layer: &AdaptiveAvgPool2d) -> Self {
        let fields = layer.output_size;
        let pooled = self.next("means", Operation::MeanPool { fields }, self.channels);
        pooled.next("flatten", Operation::Flatten, pooled.channels * fields[0] * fields[1])
    }
}

impl VectorOps for TracedNode {
    fn linear(self, layer: &Linear) -> Self {
        let shape = layer.weight.dims();
        let bias = layer.bias.as_ref();
        let bias = bias.map_or_else(|| vec![0.0; shape[1]], |bias| values(bias.val()));
        let name = self.layer(&layer.weight);
        let linear = LinearLayer { shape, weight: values(layer.weight.val()), bias };
        self.next(&name, Operation::Linear(linear), shape[1])
    }

    fn relu(self) -> Self {
        NetOps::relu(self)
    }
}

//! A network written down: its layers in order, with their weights, for engines that compile it.
//!
//! Normalisation of a trained network is a factor and an offset for each channel, which go into the
//! convolution before it, in double precision.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use burn::module::{Module, Param, ParamId};
use burn::nn::conv::Conv2d;
use burn::nn::pool::{AdaptiveAvgPool2d, MaxPool2d};
use burn::nn::{BatchNorm, Linear, PaddingConfig2d};
use burn::tensor::Tensor;

pub use evpose_kernels::batch_norm::Activation;

use crate::conv_norm::ConvNorm;
use crate::net_ops::{NetOps, VectorOps};
use crate::parameters::paths;

/// The number of a node.
pub type NodeId = usize;

/// What a node does with its inputs.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Operation {
    /// The image that the network is shown.
    Input,
    /// A convolution, an offset, an activation.
    Conv(ConvLayer),
    /// The largest value of windows; what lies outside of the image does not count.
    MaxPool {
        /// Rows and columns of a window.
        window: [usize; 2],
        /// Pixels between windows, down and across.
        stride: [usize; 2],
        /// Pixels by which the first window begins above and to the left.
        padding: [usize; 2],
    },
    /// Means over so many rows and columns of fields, which cover the image evenly.
    MeanPool {
        /// Rows and columns of the output.
        fields: [usize; 2],
    },
    /// All values of an image, channel by channel, as a vector.
    Flatten,
    /// A fully connected layer.
    Linear(LinearLayer),
    /// The sum of two.
    Add,
    /// Negative values become 0.
    Relu,
    /// Some of the channels.
    Channels(Range<usize>),
    /// The channels of two images in turn.
    Interleave,
    /// Twice as many rows and columns. Row `y` lies at `(y + 0.5) / 2 - 0.5` of the input, between the
    /// two nearest of its rows; beyond the outermost, the values stay. So do columns.
    Upsample,
    /// `1 / (1 + exp(-x))`.
    Sigmoid,
    /// `factor * x + offset`.
    Affine {
        /// What values are multiplied by.
        factor: f32,
        /// What is added.
        offset: f32,
    },
}

/// A convolution with what follows it.
#[derive(Debug, Clone, PartialEq)]
pub struct ConvLayer {
    /// Channels of the output, channels of the input for each group, rows and columns of the kernel.
    pub shape: [usize; 4],
    /// Groups of channels that are not mixed.
    pub groups: usize,
    /// Pixels between outputs, down and across.
    pub stride: [usize; 2],
    /// Zeros above, to the left, below and to the right.
    pub padding: [usize; 4],
    /// Pixels between taps, down and across.
    pub dilation: [usize; 2],
    /// The kernels, of `shape`.
    pub weight: Vec<f32>,
    /// One for each channel of the output.
    pub bias: Vec<f32>,
    /// What becomes of the sums.
    pub activation: Activation,
}

/// A fully connected layer.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearLayer {
    /// Values of input and output.
    pub shape: [usize; 2],
    /// `[inputs][outputs]`.
    pub weight: Vec<f32>,
    /// One for each output.
    pub bias: Vec<f32>,
}

/// A step of a network.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// What it is called: the path of its layer, such as `backbone.stages.0.1.first`, or what it does.
    pub name: String,
    /// What it does.
    pub operation: Operation,
    /// With what; nodes before it.
    pub inputs: Vec<NodeId>,
    /// Channels or values of the output.
    pub channels: usize,
}

/// A network, node after node.
#[derive(Debug, Clone, PartialEq)]
pub struct Graph {
    /// The first is the input.
    pub nodes: Vec<Node>,
    /// What the network says, each of it.
    pub outputs: Vec<NodeId>,
}

impl Graph {
    /// Writes down what `forward` does with an image of so many channels. Layers are named by their
    /// paths in `module`.
    pub(crate) fn of<M: Module>(
        module: &M,
        channels: usize,
        forward: impl FnOnce(Written) -> Vec<Written>,
    ) -> Self {
        let nodes = Nodes { list: Vec::new(), paths: paths(module) };
        let nodes = Rc::new(RefCell::new(nodes));
        let blank = Written { id: 0, channels, nodes: Rc::clone(&nodes) };
        let input = blank.node("input", Operation::Input, vec![], channels);
        let outputs = forward(input).into_iter().map(|output| output.id).collect();
        let nodes = std::mem::take(&mut nodes.borrow_mut().list);
        Self { nodes, outputs }
    }
}

struct Nodes {
    list: Vec<Node>,
    paths: HashMap<ParamId, String>,
}

/// A node that is written down, as it flows through a network.
#[derive(Clone)]
pub(crate) struct Written {
    id: NodeId,
    channels: usize,
    nodes: Rc<RefCell<Nodes>>,
}

impl Written {
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

    fn convolved(&self, layer: &Conv2d, norm: Option<&BatchNorm>, activation: Activation) -> Self {
        let shape = layer.weight.dims();
        let mut weight = values(layer.weight.val());
        let bias = layer.bias.as_ref();
        let mut bias = bias.map_or_else(|| vec![0.0; shape[0]], |bias| values(bias.val()));
        if let Some(norm) = norm {
            fold(norm, &mut weight, &mut bias);
        }
        let [top, left, bottom, right] = match layer.padding {
            PaddingConfig2d::Explicit(top, left, bottom, right) => [top, left, bottom, right],
            PaddingConfig2d::Valid => [0; 4],
            // As Burn pads a kernel that is as far from either side as it can be.
            PaddingConfig2d::Same => {
                let [down, across] = [shape[2] - 1, shape[3] - 1];
                [down / 2, across / 2, down - down / 2, across - across / 2]
            }
        };
        let name = self.layer(&layer.weight);
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

/// Puts the factor and the offset of a trained normalisation into the convolution before it.
fn fold(norm: &BatchNorm, weight: &mut [f32], bias: &mut [f32]) {
    let gamma = values(norm.gamma.val());
    let beta = values(norm.beta.val());
    let mean = values(norm.running_mean.value_sync());
    let variance = values(norm.running_var.value_sync());
    let taps = weight.len() / bias.len();
    for (channel, kernel) in weight.chunks_mut(taps).enumerate() {
        let [gamma, beta, mean, variance] =
            [&gamma, &beta, &mean, &variance].map(|values| f64::from(values[channel]));
        let factor = gamma / (variance + norm.epsilon).sqrt();
        kernel.iter_mut().for_each(|value| *value = (f64::from(*value) * factor) as f32);
        bias[channel] = ((f64::from(bias[channel]) - mean) * factor + beta) as f32;
    }
}

fn values<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.into_data().iter::<f32>().collect()
}

impl NetOps for Written {
    type Vector = Self;

    fn channels(&self) -> usize {
        self.channels
    }

    fn conv(self, layer: &Conv2d) -> Self {
        self.convolved(layer, None, Activation::Identity)
    }

    fn conv_norm(self, layer: &ConvNorm, activation: Activation) -> Self {
        self.convolved(&layer.conv, Some(&layer.norm), activation)
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
        let means = self.next("means", Operation::MeanPool { fields }, self.channels);
        means.next("flatten", Operation::Flatten, means.channels * fields[0] * fields[1])
    }
}

impl VectorOps for Written {
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

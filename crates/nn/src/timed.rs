//! Times of a network's operations on a device: a forward pass, every operation of which waits for the device.

use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;
use std::time::{Duration, Instant};

use burn::nn::Linear;
use burn::nn::conv::Conv2d;
use burn::nn::pool::{AdaptiveAvgPool2d, MaxPool2d};
use burn::tensor::{Device, Tensor};

use crate::conv_norm::ConvNorm;
use crate::net_ops::{NetOps, VectorOps};
use crate::ops::Activation;

/// Repetitions between two waits, which share what handing over to the device takes.
const REPEATS: u32 = 8;

/// The time of a node of a graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodeTime {
    /// Channels, rows and columns of the output; rows and columns of 1 of a vector.
    pub output: [usize; 3],
    /// How long the device computes.
    pub time: Duration,
}

/// A value whose operations are timed.
#[derive(Clone)]
pub(crate) struct Timed<T> {
    value: T,
    device: Device,
    times: Rc<RefCell<Vec<NodeTime>>>,
}

/// The times of the operations of `forward`, one for every node of its graph but the input.
pub(crate) fn node_times<T>(
    images: Tensor<4>,
    forward: impl FnOnce(Timed<Tensor<4>>) -> T,
) -> Vec<NodeTime> {
    let (device, times) = (images.device(), Rc::new(RefCell::new(Vec::new())));
    forward(Timed { value: images, device, times: Rc::clone(&times) });
    times.take()
}

/// Waits until the device has computed what it was given.
fn wait(device: &Device) {
    device.sync().unwrap_or_else(|error| panic!("the device failed: {error:?}"));
}

impl<T> Timed<T> {
    /// The result of `operation`, which is timed as a node.
    fn step<U>(&self, operation: impl Fn() -> U, output: impl Fn(&U) -> [usize; 3]) -> Timed<U> {
        // The first call compiles kernels.
        let value = operation();
        wait(&self.device);
        let started = Instant::now();
        for _ in 0..REPEATS {
            operation();
        }
        wait(&self.device);
        let time = started.elapsed() / REPEATS;
        self.times.borrow_mut().push(NodeTime { output: output(&value), time });
        Timed { value, device: self.device.clone(), times: Rc::clone(&self.times) }
    }
}

impl Timed<Tensor<4>> {
    fn maps(&self, operation: impl Fn(Tensor<4>) -> Tensor<4>) -> Self {
        self.step(|| operation(self.value.clone()), size)
    }
}

/// Channels, rows and columns.
fn size(maps: &Tensor<4>) -> [usize; 3] {
    let [_, channels, rows, columns] = maps.dims();
    [channels, rows, columns]
}

fn vector_size(vector: &Tensor<2>) -> [usize; 3] {
    [vector.dims()[1], 1, 1]
}

impl NetOps for Timed<Tensor<4>> {
    type Vector = Timed<Tensor<2>>;

    fn channels(&self) -> usize {
        self.value.channels()
    }

    fn conv(self, layer: &Conv2d) -> Self {
        self.maps(|x| x.conv(layer))
    }

    fn conv_norm(self, layer: &ConvNorm, activation: Activation) -> Self {
        self.maps(|x| x.conv_norm(layer, activation))
    }

    fn max_pool(self, layer: &MaxPool2d) -> Self {
        self.maps(|x| x.max_pool(layer))
    }

    fn add(self, other: Self) -> Self {
        self.maps(|x| x.add(other.value.clone()))
    }

    fn relu(self) -> Self {
        self.maps(NetOps::relu)
    }

    fn narrow(self, channels: Range<usize>) -> Self {
        self.maps(|x| NetOps::narrow(x, channels.clone()))
    }

    fn interleave(self, other: Self) -> Self {
        self.maps(|x| x.interleave(other.value.clone()))
    }

    fn concat(parts: Vec<Self>) -> Self {
        let values = || parts.iter().map(|part| part.value.clone()).collect();
        parts[0].step(|| NetOps::concat(values()), size)
    }

    fn local_mean(self) -> Self {
        self.maps(NetOps::local_mean)
    }

    fn upsample(self) -> Self {
        self.maps(NetOps::upsample)
    }

    fn sigmoid(self) -> Self {
        self.maps(NetOps::sigmoid)
    }

    fn affine(self, factor: f32, offset: f32) -> Self {
        self.maps(|x| x.affine(factor, offset))
    }

    fn avg_pool(self, layer: &AdaptiveAvgPool2d) -> Self::Vector {
        // Two nodes of a graph: pooling, and a flattening that moves nothing.
        let pooled = self.maps(|x| layer.forward(x));
        pooled.step(|| pooled.value.clone().flatten(1, 3), vector_size)
    }
}

impl VectorOps for Timed<Tensor<2>> {
    fn linear(self, layer: &Linear) -> Self {
        self.step(|| self.value.clone().linear(layer), vector_size)
    }

    fn relu(self) -> Self {
        self.step(|| VectorOps::relu(self.value.clone()), vector_size)
    }
}

//! Residual networks of basic blocks: ResNet-18 and ResNet-34.
//!
//! Fields are named as torchvision names them (`conv1`, `bn1`, `layer1.0.downsample.0` apart), so
//! that published weights load by name.
//!
//! # Source
//! He, Zhang, Ren, Sun: *Deep Residual Learning for Image Recognition*, CVPR 2016, Table 1.

use burn::module::Module;
use burn::nn::conv::{Conv2d, Conv2dConfig};
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig, MaxPool2d, MaxPool2dConfig};
use burn::nn::{BatchNorm, BatchNormConfig, Linear, LinearConfig, PaddingConfig2d};
use burn::tensor::activation::relu;
use burn::tensor::module::conv2d;
use burn::tensor::ops::ConvOptions;
use burn::tensor::{Device, Tensor};

/// Shape of a residual network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResNetConfig {
    /// Basic blocks in each of the four stages.
    pub blocks: [usize; 4],
    /// Channels of the first stage; the others have 2, 4 and 8 times as many. 64 as published.
    pub width: usize,
    /// Numbers predicted.
    pub outputs: usize,
}

/// A residual network of basic blocks.
#[derive(Module, Debug)]
pub struct ResNet {
    conv1: Conv2d,
    bn1: BatchNorm,
    maxpool: MaxPool2d,
    layer1: Vec<BasicBlock>,
    layer2: Vec<BasicBlock>,
    layer3: Vec<BasicBlock>,
    layer4: Vec<BasicBlock>,
    avgpool: AdaptiveAvgPool2d,
    fc: Linear,
}

impl ResNetConfig {
    /// Creates the network.
    pub fn init(&self, device: &Device) -> ResNet {
        let width = self.width;
        let stage = |index: usize| {
            let channels = width << index;
            (0..self.blocks[index])
                .map(|block| match (index, block) {
                    (0, _) => BasicBlock::new(channels, channels, 1, device),
                    (_, 0) => BasicBlock::new(channels / 2, channels, 2, device),
                    _ => BasicBlock::new(channels, channels, 1, device),
                })
                .collect()
        };
        ResNet {
            conv1: conv(3, width, 7, 2, device),
            bn1: BatchNormConfig::new(width).init(device),
            maxpool: MaxPool2dConfig::new([3, 3])
                .with_strides([2, 2])
                .with_padding(PaddingConfig2d::Explicit(1, 1, 1, 1))
                .init(),
            layer1: stage(0),
            layer2: stage(1),
            layer3: stage(2),
            layer4: stage(3),
            avgpool: AdaptiveAvgPool2dConfig::new([1, 1]).init(),
            fc: LinearConfig::new(width * 8, self.outputs).init(device),
        }
    }
}

impl ResNet {
    /// # Shapes
    /// - input: `[batch, 3, height, width]`
    /// - output: `[batch, outputs]`
    pub fn forward(&self, input: Tensor<4>) -> Tensor<2> {
        let x = relu(self.bn1.forward(stem(&self.conv1, input)));
        let mut x = self.maxpool.forward(x);
        for block in [&self.layer1, &self.layer2, &self.layer3, &self.layer4].into_iter().flatten() {
            x = block.forward(x);
        }
        self.fc.forward(self.avgpool.forward(x).flatten(1, 3))
    }
}

/// Two 3x3 convolutions around which the input is added.
#[derive(Module, Debug)]
struct BasicBlock {
    conv1: Conv2d,
    bn1: BatchNorm,
    conv2: Conv2d,
    bn2: BatchNorm,
    downsample: Option<Downsample>,
}

impl BasicBlock {
    fn new(input: usize, output: usize, stride: usize, device: &Device) -> Self {
        Self {
            conv1: conv(input, output, 3, stride, device),
            bn1: BatchNormConfig::new(output).init(device),
            conv2: conv(output, output, 3, 1, device),
            bn2: BatchNormConfig::new(output).init(device),
            downsample: (stride != 1 || input != output)
                .then(|| Downsample::new(input, output, stride, device)),
        }
    }

    fn forward(&self, input: Tensor<4>) -> Tensor<4> {
        let x = relu(self.bn1.forward(self.conv1.forward(input.clone())));
        let x = self.bn2.forward(self.conv2.forward(x));
        let shortcut = match &self.downsample {
            Some(downsample) => downsample.forward(input),
            None => input,
        };
        relu(x + shortcut)
    }
}

/// The shortcut of a block that changes size: a strided 1x1 convolution.
#[derive(Module, Debug)]
struct Downsample {
    conv: Conv2d,
    bn: BatchNorm,
}

impl Downsample {
    fn new(input: usize, output: usize, stride: usize, device: &Device) -> Self {
        Self {
            conv: conv(input, output, 1, stride, device),
            bn: BatchNormConfig::new(output).init(device),
        }
    }

    fn forward(&self, input: Tensor<4>) -> Tensor<4> {
        self.bn.forward(self.conv.forward(input))
    }
}

/// A square convolution without bias that keeps the image size, up to its stride.
fn conv(input: usize, output: usize, kernel: usize, stride: usize, device: &Device) -> Conv2d {
    let pad = kernel / 2;
    Conv2dConfig::new([input, output], [kernel, kernel])
        .with_stride([stride, stride])
        .with_padding(PaddingConfig2d::Explicit(pad, pad, pad, pad))
        .with_bias(false)
        .init(device)
}

/// Space to depth.
pub fn stem(conv: &Conv2d, input: Tensor<4>) -> Tensor<4> {
    let [batch, channels, height, width] = input.dims();
    let [out, _, _, _] = conv.weight.dims();
    let (odd_y, odd_x) = (height % 2, width % 2);
    let x = input.pad((3, 3 + odd_x, 3, 3 + odd_y), 0.0);
    let (h, w) = ((height + 6 + odd_y) / 2, (width + 6 + odd_x) / 2);
    let x = x
        .reshape([batch, channels, h, 2, w, 2])
        .permute([0, 1, 3, 5, 2, 4])
        .reshape([batch, channels * 4, h, w]);
    let weight = conv
        .weight
        .val()
        .pad((0, 1, 0, 1), 0.0)
        .reshape([out, channels, 4, 2, 4, 2])
        .permute([0, 1, 3, 5, 2, 4])
        .reshape([out, channels * 4, 4, 4]);
    conv2d(x, weight, None, ConvOptions::new([1, 1], [0, 0], [1, 1], 1))
}

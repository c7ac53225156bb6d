//! A backbone of one's own: three convolutions, an average, a fully connected layer. It learns the
//! brightness of images, and is compiled for inference.
//!
//! ```console
//! $ cargo run --release --example custom_backbone
//! ```
//! A backbone of evpose is such a file, plus a line in the registry; see `CONTRIBUTING.md`.

#![allow(clippy::print_stdout, reason = "a program")]

use anyhow::Result;
use burn::module::Module;
use burn::nn::Linear;
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig};
use burn::optim::{AdamConfig, GradientsParams};
use burn::tensor::{Device, Tensor, TensorData};
use evpose_infer::{Engine, EngineOptions};
use evpose_nn::backbone::{
    BackboneNet, BackboneSpec, ConvNorm, ConvNormConfig, Initializer, NetOps, Slot, VectorOps,
    linear, scaled,
};
use evpose_nn::parameters::trained_count;

/// Channels of the convolutions at width 1.
const CHANNELS: [usize; 3] = [16, 32, 64];

const TINY: BackboneSpec<TinyNet> = BackboneSpec {
    name: "tiny",
    about: "three convolutions, made up to show the parts of a backbone",
    smallest_px: 1,
    narrowest: 1.0 / 16.0,
    build: TinyNet::zeros,
};

/// The names of the fields are those of the tensors in checkpoints.
#[derive(Module, Debug)]
struct TinyNet {
    convolutions: Vec<ConvNorm>,
    pool: AdaptiveAvgPool2d,
    head: Linear,
}

impl TinyNet {
    fn zeros(width: f32, outputs: usize, device: &Device) -> Self {
        let mut channels_in = 3;
        let convolution = |published: usize| {
            let channels = scaled(published, width);
            let config = ConvNormConfig::new(channels_in, channels, 3).with_stride(2);
            channels_in = channels;
            config.init(device)
        };
        let convolutions = CHANNELS.map(convolution).into();
        let pool = AdaptiveAvgPool2dConfig::new([1, 1]).init();
        Self { convolutions, pool, head: linear(channels_in, outputs, device) }
    }
}

impl BackboneNet for TinyNet {
    fn forward<N: NetOps>(&self, images: N) -> N::Vector {
        let features = self.convolutions.iter().fold(images, |x, layer| layer.forward_relu(x));
        features.avg_pool(&self.pool).linear(&self.head)
    }

    fn initializer(&self, slot: &Slot) -> Initializer {
        match slot.layer.as_str() {
            "Conv2d" => Initializer::kaiming_fan_out(&slot.shape),
            "BatchNorm" => Initializer::batch_norm(slot.name()),
            _ => Initializer::torch_default(self.head.weight.dims()[0]),
        }
    }
}

/// Rows and columns of the images.
const SIDE: usize = 32;
const IMAGES: usize = 16;

/// Images of a pattern, the `k`th with brightness `k / 16`.
fn images() -> Vec<f32> {
    let pattern = |pixel: usize| (pixel * 7 % 13) as f32 / 13.0;
    let size = 3 * SIDE * SIDE;
    (0..IMAGES * size).map(|i| (i / size) as f32 / IMAGES as f32 * pattern(i % size)).collect()
}

fn main() -> Result<()> {
    let device = Device::flex().autodiff();
    let mut network = TINY.init(1.0, 1, 7, &device)?;
    println!("{}: {} parameters", TINY.name, trained_count(&network));

    let shape = [IMAGES, 3, SIDE, SIDE];
    let inputs = Tensor::<4>::from_data(TensorData::new(images(), shape), &device);
    let brightness: Vec<f32> = (0..IMAGES).map(|k| k as f32 / IMAGES as f32).collect();
    let targets = Tensor::<2>::from_data(TensorData::new(brightness, [IMAGES, 1]), &device);
    let mut adam = AdamConfig::new().init();
    for step in 0..=60 {
        let outputs: Tensor<2> = network.forward(inputs.clone());
        let loss = (outputs - targets.clone()).square().mean();
        if step % 20 == 0 {
            println!("step {step:>2}: loss {:.5}", loss.clone().into_scalar::<f32>());
        }
        let gradients = GradientsParams::from_grads(loss.backward(), &network);
        network = adam.step(3e-3, network, gradients);
    }

    // The same forward pass, traced to a graph, becomes a plan of the inference engine.
    let trained = network.valid();
    let image = images()[8 * 3 * SIDE * SIDE..][..3 * SIDE * SIDE].to_vec();
    let mut engine = Engine::compile(&trained.graph(), [3, SIDE, SIDE], EngineOptions::default())?;
    let compiled = engine.run(&image)[0][0];
    let data = TensorData::new(image, [1, 3, SIDE, SIDE]);
    let output: Tensor<2> = trained.forward(Tensor::<4>::from_data(data, &Device::flex()));
    println!("brightness 0.500: Burn {:.3}, engine {compiled:.3}", output.into_scalar::<f32>());
    Ok(())
}

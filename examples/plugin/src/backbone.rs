//! Three convolutions, a pooling, a fully connected layer.

use burn::module::Module;
use burn::nn::Linear;
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig};
use burn::tensor::Device;
use evpose_nn::BackboneEntry;
use evpose_nn::backbone::{
    BackboneNet, BackboneSpec, ConvNorm, ConvNormConfig, Initializer, NetOps, Slot, VectorOps,
    linear, scaled,
};

/// Channels of the convolutions at width 1.
const CHANNELS: [usize; 3] = [16, 32, 64];

pub(crate) static TINY: BackboneEntry = BackboneEntry::external(&SPEC);

static SPEC: BackboneSpec<TinyNet> = BackboneSpec {
    name: "tiny",
    about: "three convolutions, made up to show a backbone of another crate",
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

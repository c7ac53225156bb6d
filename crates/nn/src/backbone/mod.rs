//! Image networks that end in a vector, by name.

mod mobilenet_v2;
mod resnet;
mod stem;

use burn::module::Module;
use burn::tensor::{Device, Tensor};

use crate::NnError;
use crate::init::Law;
use crate::parameters::Slot;

use mobilenet_v2::MobileNetV2Config;
use resnet::ResNetConfig;

pub use mobilenet_v2::MobileNetV2;
pub use resnet::ResNet;

/// A network that can stand inside a regressor.
pub struct BackboneEntry {
    /// What configurations call it.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// From the relative width, the number of outputs and the device.
    build: fn(f32, usize, &Device) -> Backbone,
    /// The relative width at which the smallest layer has one channel.
    narrowest: f32,
}

/// Every backbone. A new one is a file beside this one, a variant of [`Backbone`] and a line here.
pub const BACKBONES: &[BackboneEntry] = &[
    BackboneEntry {
        name: "resnet18",
        about: "ResNet-18 (He et al. 2016), the network of EventHands",
        build: |width, outputs, device| {
            Backbone::ResNet(ResNetConfig::new([2, 2, 2, 2], width, outputs).init(device))
        },
        narrowest: 1.0 / 64.0,
    },
    BackboneEntry {
        name: "resnet34",
        about: "ResNet-34 (He et al. 2016): as accurate, twice the work",
        build: |width, outputs, device| {
            Backbone::ResNet(ResNetConfig::new([3, 4, 6, 3], width, outputs).init(device))
        },
        narrowest: 1.0 / 64.0,
    },
    BackboneEntry {
        name: "mobilenet_v2",
        about: "MobileNetV2 (Sandler et al. 2018): a fifth of the parameters",
        build: |width, outputs, device| {
            Backbone::MobileNetV2(MobileNetV2Config::new(width, outputs).init(device))
        },
        narrowest: 0.01,
    },
];

/// An image network of any registered kind.
#[derive(Module, Debug)]
#[allow(clippy::large_enum_variant, reason = "one per network, never in a collection")]
pub enum Backbone {
    /// ResNet-18 and ResNet-34.
    ResNet(ResNet),
    /// MobileNetV2.
    MobileNetV2(MobileNetV2),
}

impl Backbone {
    /// The backbone called `name`, `width` times as wide as published, with all weights zero.
    pub(crate) fn build(
        name: &str,
        width: f32,
        outputs: usize,
        device: &Device,
    ) -> Result<Self, NnError> {
        let Some(entry) = BACKBONES.iter().find(|entry| entry.name == name) else {
            let known: Vec<_> = BACKBONES.iter().map(|entry| entry.name).collect();
            return Err(NnError::UnknownBackbone {
                name: name.to_owned(),
                known: known.join(", "),
            });
        };
        if !(entry.narrowest..=8.0).contains(&width) {
            return Err(NnError::Width { width });
        }
        Ok((entry.build)(width, outputs, device))
    }

    /// # Shapes
    /// - input: `[batch, 3, height, width]`
    /// - output: `[batch, outputs]`
    pub fn forward(&self, input: Tensor<4>) -> Tensor<2> {
        match self {
            Self::ResNet(network) => network.forward(input),
            Self::MobileNetV2(network) => network.forward(input),
        }
    }

    /// What a tensor of the backbone starts from.
    pub(crate) fn initial(&self, slot: &Slot) -> Law {
        match self {
            Self::ResNet(network) => network.initial(slot),
            Self::MobileNetV2(_) => mobilenet_v2::initial(slot),
        }
    }

    /// What torchvision calls the layer at `path`, relative to the backbone; the last part, the
    /// tensor's own name, is left as it is.
    pub(crate) fn torchvision_path(&self, path: &str) -> String {
        match self {
            Self::ResNet(_) => resnet::torchvision_path(path),
            Self::MobileNetV2(_) => mobilenet_v2::torchvision_path(path),
        }
    }
}

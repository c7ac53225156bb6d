//! Image networks that end in a vector, by name.

mod mnasnet;
mod mobilenet_v2;
mod resnet;
mod shufflenet_v2;
mod vgg;

use burn::module::Module;
use burn::tensor::{Device, Tensor};

use crate::NnError;
use crate::initializer::Initializer;
use crate::net_ops::NetOps;
use crate::ops::{self, Blocked};
use crate::parameters::Slot;

use mnasnet::MnasNetConfig;
use mobilenet_v2::MobileNetV2Config;
use resnet::ResNetConfig;
use shufflenet_v2::ShuffleNetV2Config;
use vgg::VggConfig;

pub use mnasnet::MnasNet;
pub use mobilenet_v2::MobileNetV2;
pub use resnet::ResNet;
pub use shufflenet_v2::ShuffleNetV2;
pub use vgg::Vgg;

/// A network that can stand inside a regressor.
pub struct BackboneEntry {
    /// What configurations call it.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// The smallest side of an image that it can be shown, in pixels.
    pub smallest_px: usize,
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
        smallest_px: 1,
        build: |width, outputs, device| {
            Backbone::ResNet(ResNetConfig::new([2, 2, 2, 2], width, outputs).init(device))
        },
        narrowest: 1.0 / 64.0,
    },
    BackboneEntry {
        name: "resnet34",
        about: "ResNet-34 (He et al. 2016): as accurate, twice the work",
        smallest_px: 1,
        build: |width, outputs, device| {
            Backbone::ResNet(ResNetConfig::new([3, 4, 6, 3], width, outputs).init(device))
        },
        narrowest: 1.0 / 64.0,
    },
    BackboneEntry {
        name: "mobilenet_v2",
        about: "MobileNetV2 (Sandler et al. 2018): a fifth of the parameters",
        smallest_px: 1,
        build: |width, outputs, device| {
            Backbone::MobileNetV2(MobileNetV2Config::new(width, outputs).init(device))
        },
        narrowest: 0.01,
    },
    BackboneEntry {
        name: "vgg11_bn",
        about: "VGG-11 with batch normalisation (Simonyan and Zisserman 2015): eleven times the \
                parameters",
        smallest_px: vgg::SMALLEST_PX,
        build: |width, outputs, device| {
            Backbone::Vgg(VggConfig::new([1, 1, 2, 2, 2], width, outputs).init(device))
        },
        narrowest: 1.0 / 64.0,
    },
    BackboneEntry {
        name: "shufflenet_v2",
        about: "ShuffleNetV2 (Ma et al. 2018): a ninth of the parameters",
        smallest_px: 1,
        build: |width, outputs, device| {
            Backbone::ShuffleNetV2(ShuffleNetV2Config::new(width, outputs).init(device))
        },
        narrowest: 1.0 / 58.0,
    },
    BackboneEntry {
        name: "mnasnet",
        about: "MnasNet-B1 (Tan et al. 2019): a quarter of the parameters",
        smallest_px: 1,
        build: |width, outputs, device| {
            Backbone::MnasNet(MnasNetConfig::new(width, outputs).init(device))
        },
        narrowest: 0.01,
    },
];

/// The backbone called `name`.
///
/// # Errors
/// [`NnError::UnknownBackbone`], which lists those there are.
pub fn backbone_by_name(name: &str) -> Result<&'static BackboneEntry, NnError> {
    BACKBONES.iter().find(|entry| entry.name == name).ok_or_else(|| {
        let known: Vec<_> = BACKBONES.iter().map(|entry| entry.name).collect();
        NnError::UnknownBackbone { name: name.to_owned(), known: known.join(", ") }
    })
}

/// An image network of any registered kind.
#[derive(Module, Debug)]
#[allow(clippy::large_enum_variant, reason = "one per network, never in a collection")]
pub enum Backbone {
    /// ResNet-18 and ResNet-34.
    ResNet(ResNet),
    /// MobileNetV2.
    MobileNetV2(MobileNetV2),
    /// VGG-11.
    Vgg(Vgg),
    /// ShuffleNetV2.
    ShuffleNetV2(ShuffleNetV2),
    /// MnasNet.
    MnasNet(MnasNet),
}

impl Backbone {
    /// The backbone called `name`, `width` times as wide as published, with all weights zero.
    pub(crate) fn build(
        name: &str,
        width: f32,
        outputs: usize,
        device: &Device,
    ) -> Result<Self, NnError> {
        let entry = backbone_by_name(name)?;
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
            Self::ResNet(network) if ops::is_ours(&input) => {
                network.forward(Blocked::from_planes(input))
            }
            _ => self.forward_ops(input),
        }
    }

    /// The forward pass of whatever flows.
    pub(crate) fn forward_ops<F: NetOps>(&self, input: F) -> F::Vector {
        match self {
            Self::ResNet(network) => network.forward(input),
            Self::MobileNetV2(network) => network.forward(input),
            Self::Vgg(network) => network.forward(input),
            Self::ShuffleNetV2(network) => network.forward(input),
            Self::MnasNet(network) => network.forward(input),
        }
    }

    /// What a tensor of the backbone starts from.
    pub(crate) fn initial(&self, slot: &Slot) -> Initializer {
        match self {
            Self::ResNet(network) => network.initial(slot),
            Self::MobileNetV2(_) => mobilenet_v2::initial(slot),
            Self::Vgg(_) => vgg::initial(slot),
            Self::ShuffleNetV2(network) => network.initial(slot),
            Self::MnasNet(_) => mnasnet::initial(slot),
        }
    }

    /// What torchvision calls the layer at `path`, relative to the backbone; the last part, the
    /// tensor's own name, is left as it is.
    pub(crate) fn torchvision_path(&self, path: &str) -> String {
        match self {
            Self::ResNet(_) => resnet::torchvision_path(path),
            Self::MobileNetV2(_) => mobilenet_v2::torchvision_path(path),
            Self::Vgg(network) => network.torchvision_path(path),
            Self::ShuffleNetV2(_) => shufflenet_v2::torchvision_path(path),
            Self::MnasNet(_) => mnasnet::torchvision_path(path),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::parameters::trained_count;

    #[test]
    fn with_a_thousand_classes_parameters_are_as_many_as_published() {
        let published = [
            ("resnet18", 11_689_512),
            ("resnet34", 21_797_672),
            ("mobilenet_v2", 3_504_872),
            ("vgg11_bn", 132_868_840),
            ("shufflenet_v2", 2_278_604),
            ("mnasnet", 4_383_312),
        ];
        assert_eq!(
            published.map(|(name, _)| name).to_vec(),
            BACKBONES.iter().map(|e| e.name).collect::<Vec<_>>()
        );
        for (name, count) in published {
            let network = Backbone::build(name, 1.0, 1000, &Device::flex()).unwrap();
            assert_eq!(trained_count(&network), count, "{name}");
        }
    }
}

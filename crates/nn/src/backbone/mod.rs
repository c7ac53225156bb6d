//! Backbones, image networks that end in a vector, by name.
//!
//! A backbone is a file here, its `mod` line, and a line of the registry: see [`BackboneNet`] and
//! [`BackboneSpec`]. Another crate registers its own as [`BackboneEntry::external`].

mod erased;
mod external;
mod inception_v3;
mod mnasnet;
mod mobilenet_v2;
mod registry;
pub(crate) mod resnet;
mod shufflenet_v2;
mod spec;
mod vgg;

use burn::module::Module;
use burn::tensor::Device;
use evpose_core::{Registry, registry_entry};

use crate::NnError;
use crate::channels::check_width;

pub use crate::channels::{multiple_of_eight, scaled};
pub use crate::conv_norm::{ConvNorm, ConvNormConfig};
pub use crate::initializer::{Initializer, seeded};
pub use crate::linear::linear;
pub use crate::net_ops::{NetOps, VectorOps};
pub use crate::parameters::Slot;
use external::ExternalNet;
pub(crate) use spec::IMAGE_CHANNELS;
pub use spec::{BackboneNet, BackboneSpec};

registry::backbones! {
    resnet::ResNet => RESNET18, RESNET34;
    mobilenet_v2::MobileNetV2 => MOBILENET_V2;
    vgg::Vgg => VGG11_BN, VGG13_BN, VGG16_BN, VGG19_BN;
    shufflenet_v2::ShuffleNetV2 => SHUFFLENET_V2;
    mnasnet::MnasNet => MNASNET;
    inception_v3::InceptionV3 => INCEPTION_V3;
}

/// A backbone of the registry, as lists show it.
pub struct BackboneEntry {
    /// Name in configs and on the command line.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// The smallest side of an image that it takes, in pixels.
    pub smallest_px: usize,
    /// See [`BackboneSpec::narrowest`].
    narrowest: f32,
    /// See [`BackboneSpec::build`].
    build: Build,
}

/// The constructor of a network.
enum Build {
    BuiltIn(fn(f32, usize, &Device) -> Backbone),
    External(&'static dyn external::BuildExternal),
}

registry_entry!(BackboneEntry, "backbone");

/// The backbone of the name `name`.
///
/// # Errors
/// [`NnError::UnknownBackbone`], which lists the known names.
pub fn backbone_by_name(name: &str) -> Result<&'static BackboneEntry, NnError> {
    BACKBONES.find(name).ok_or_else(|| NnError::UnknownBackbone {
        name: name.to_owned(),
        known: BACKBONES.names().join(", "),
    })
}

impl Backbone {
    /// The backbone of the name `name`, `width` times as wide as published, with all weights zero.
    pub(crate) fn build(
        name: &str,
        width: f32,
        outputs: usize,
        device: &Device,
    ) -> Result<Self, NnError> {
        let entry = backbone_by_name(name)?;
        check_width(width, entry.narrowest)?;
        Ok(match entry.build {
            Build::BuiltIn(build) => build(width, outputs, device),
            Build::External(spec) => spec.build(width, outputs, device),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::trained_count;

    #[test]
    fn with_a_thousand_classes_parameters_are_as_many_as_published() {
        let published = [
            ("resnet18", 11_689_512),
            ("resnet34", 21_797_672),
            ("mobilenet_v2", 3_504_872),
            ("vgg11_bn", 132_868_840),
            ("vgg13_bn", 133_053_736),
            ("vgg16_bn", 138_365_992),
            ("vgg19_bn", 143_678_248),
            ("shufflenet_v2", 2_278_604),
            ("mnasnet", 4_383_312),
            ("inception_v3", 23_834_568),
        ];
        assert_eq!(published.map(|(name, _)| name).to_vec(), BACKBONES.names());
        for (name, count) in published {
            let network = Backbone::build(name, 1.0, 1000, &Device::flex()).unwrap();
            assert_eq!(trained_count(&network), count, "{name}");
        }
    }
}

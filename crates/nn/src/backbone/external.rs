//! Backbones of other crates: their entries, and their networks inside the networks of this crate.

use burn::module::{
    Content, Devices, Module, ModuleDisplay, ModuleDisplayDefault, ModuleMapper, ModuleVisitor,
};
use burn::tensor::Device;

use super::erased::{AnyNet, FromAny, typed};
use super::{Backbone, BackboneEntry, BackboneNet, BackboneSpec};
use crate::initializer::Initializer;
use crate::net_ops::NetOps;
use crate::parameters::Slot;

/// A network of another crate. Its tensors have the paths that they have in the network itself.
#[derive(Debug)]
pub(crate) struct ExternalNet(Box<dyn AnyNet>);

/// The constructor of a [`BackboneSpec`] whose network is of any type.
pub(super) trait BuildExternal: Sync {
    fn build(&self, width: f32, outputs: usize, device: &Device) -> Backbone;
}

impl<N: BackboneNet + Sync + 'static> BuildExternal for BackboneSpec<N> {
    fn build(&self, width: f32, outputs: usize, device: &Device) -> Backbone {
        Backbone::External(ExternalNet(Box::new((self.build)(width, outputs, device))))
    }
}

impl BackboneEntry {
    /// The entry of a backbone of another crate, for
    /// [`BACKBONES.register`](evpose_core::Registry::register).
    pub const fn external<N: BackboneNet + Sync + 'static>(spec: &'static BackboneSpec<N>) -> Self {
        Self {
            name: spec.name,
            about: spec.about,
            smallest_px: spec.smallest_px,
            narrowest: spec.narrowest,
            build: super::Build::External(spec),
        }
    }
}

impl BackboneNet for ExternalNet {
    fn forward<N: NetOps>(&self, images: N) -> N::Vector {
        typed(self.0.forward(Box::new(images)))
    }

    fn initializer(&self, slot: &Slot) -> Initializer {
        self.0.initializer(slot)
    }

    fn torchvision_path(&self, path: &str) -> String {
        self.0.torchvision_path(path)
    }
}

impl Clone for ExternalNet {
    fn clone(&self) -> Self {
        Self(self.0.boxed_clone())
    }
}

impl Module for ExternalNet {
    fn collect_devices(&self, devices: Devices) -> Devices {
        self.0.collect_devices(devices)
    }

    fn fork(self, device: &Device) -> Self {
        Self(self.0.fork(device))
    }

    fn to_device(self, device: &Device) -> Self {
        Self(self.0.to_device(device))
    }

    fn train(self) -> Self {
        Self(self.0.train())
    }

    fn valid(&self) -> Self {
        Self(self.0.valid())
    }

    fn materialize(self) -> Self {
        Self(self.0.materialize())
    }

    fn visit<Visitor: ModuleVisitor>(&self, visitor: &mut Visitor) {
        self.0.visit(&mut FromAny(visitor));
    }

    fn map<Mapper: ModuleMapper>(self, mapper: &mut Mapper) -> Self {
        Self(self.0.map(&mut FromAny(mapper)))
    }
}

impl ModuleDisplayDefault for ExternalNet {
    fn content(&self, content: Content) -> Option<Content> {
        content.set_top_level_type("ExternalNet").optional()
    }
}

impl ModuleDisplay for ExternalNet {}

//! The MoveEnet network: an event image to the maps from which the joints of a body are decoded.
//!
//! * [`MoveEnetConfig`], [`MoveEnet`]: the network.
//! * `backbone`: MobileNetV2 with a feature pyramid, down to a 32nd and back up to a quarter.
//! * `heads`: the four maps.
//! * `blocks`: the building blocks of both.
//! * `names`: the names of its tensors in PyTorch.
//!
//! # Source
//! Goyal et al.: *MoveEnet: Online High-Frequency Human Pose Estimation with an Event Camera*,
//! CVPRW 2023, after *MoveNet* by Google. With 13 joints it has 2,201,106 parameters, of which
//! 627,520, those of a residual that is never repeated, are kept and never used.

mod backbone;
pub(crate) mod blocks;
mod heads;
mod names;

use burn::module::Module;
use burn::tensor::{Device, Tensor};
use evpose_pose::body::BodyMaps;
use serde::{Deserialize, Serialize};

use crate::NnError;
use crate::channels::{check_counts, check_width};
use crate::graph::Graph;
use crate::initializer::{Initializer, seeded};
use crate::net_ops::NetOps;
use crate::ops::{self, Blocked};
use crate::parameters::Slot;
use backbone::Pyramid;
use heads::Heads;

/// Channels of an image; those of events hold the same value three times.
pub(crate) const IMAGE_CHANNELS: usize = 3;
/// Factor and offset from the values 0 to 255 to -1 to 1.
const SCALING: [f32; 2] = [1.0 / 127.5, -1.0];
/// The smallest relative width, which has 8 channels everywhere.
const NARROWEST: f32 = 0.01;

/// Shape of a [`MoveEnet`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MoveEnetConfig {
    /// Joints of a body.
    pub joints: usize,
    /// Channels relative to the published network, rounded to multiples of 8.
    pub width: f32,
    /// Hidden channels for each channel of an inverted residual's input.
    pub expansion: usize,
}

impl Default for MoveEnetConfig {
    /// The published network.
    fn default() -> Self {
        Self { joints: 13, width: 1.0, expansion: 6 }
    }
}

/// A network from event images to heatmaps and regressions of the joints of a body.
#[derive(Module, Debug)]
pub struct MoveEnet {
    backbone: Pyramid,
    header: Heads,
    #[module(skip)]
    config: MoveEnetConfig,
}

impl MoveEnetConfig {
    /// The network with initial weights drawn from `seed`, as published: Kaiming normal for
    /// convolutions, no bias, normalisation as the identity.
    ///
    /// # Errors
    /// [`NnError::Width`], and [`NnError::TooFew`] for no joints or no hidden channels.
    pub fn init(&self, seed: u64, device: &Device) -> Result<MoveEnet, NnError> {
        Ok(seeded(self.zeros(device)?, seed, |slot| match (slot.layer.as_str(), slot.name()) {
            ("BatchNorm", name) => Initializer::batch_norm(name),
            (_, "weight") => Initializer::kaiming_fan_in(&slot.shape),
            _ => Initializer::Constant(0.0),
        }))
    }

    /// The network with all weights zero.
    pub(crate) fn zeros(&self, device: &Device) -> Result<MoveEnet, NnError> {
        check_width(self.width, NARROWEST)?;
        check_counts(&[("joints", self.joints), ("expansion", self.expansion)])?;
        let backbone = Pyramid::new(self, device);
        let header = Heads::new(self, device);
        Ok(MoveEnet { backbone, header, config: self.clone() })
    }
}

impl MoveEnet {
    /// The output maps, a quarter as high and wide as the images.
    ///
    /// # Shapes
    /// - images: `[batch, 3, height, width]`, values 0 to 255, sides multiples of 32; 192 as
    ///   published
    /// - heatmaps: `[batch, joints, height / 4, width / 4]`, centers the same of one channel, regs
    ///   and offsets of two for each joint
    pub fn forward(&self, images: Tensor<4>) -> BodyMaps<Tensor<4>> {
        if ops::is_ours(&images) {
            let maps = self.forward_ops(Blocked::from_planes(images)).into_array();
            return BodyMaps::from_array(maps.map(Blocked::into_planes));
        }
        let maps = self.forward_ops(images).into_array();
        BodyMaps::from_array(maps.map(ops::widened))
    }

    /// The graph of the network, for engines that compile it. Outputs are in the order of
    /// [`BodyMaps::into_array`].
    pub fn graph(&self) -> Graph {
        Graph::trace(self, IMAGE_CHANNELS, |images| self.forward_ops(images).into_array().into())
    }

    pub(crate) fn forward_ops<F: NetOps>(&self, images: F) -> BodyMaps<F> {
        let [factor, offset] = SCALING;
        self.header.forward(self.backbone.forward(images.affine(factor, offset)))
    }

    /// The configuration that it was built from.
    pub fn config(&self) -> &MoveEnetConfig {
        &self.config
    }

    /// The name of the tensor in `slot` in the published PyTorch checkpoints.
    pub fn pytorch_name(&self, slot: &Slot) -> String {
        names::pytorch(&slot.path)
    }
}

#[cfg(test)]
mod tests;

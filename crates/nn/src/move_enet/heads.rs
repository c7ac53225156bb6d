//! The four heads of the network, one for each output map.

use burn::module::Module;
use burn::nn::conv::Conv2d;
use burn::tensor::Device;
use evpose_pose::body::BodyMaps;

use super::blocks::{Separable, pointwise};
use super::{MoveEnetConfig, backbone};
use crate::channels::multiple_of_eight;
use crate::net_ops::NetOps;

/// Hidden channels of a head as published.
const HIDDEN: f32 = 96.0;

/// A depthwise separable convolution, then a 1x1 convolution.
#[derive(Module, Debug)]
pub(crate) struct Head {
    separable: Separable,
    last: Conv2d,
}

impl Head {
    /// A head of `channels` output channels on a pyramid of this relative width.
    pub(crate) fn new(width: f32, channels: usize, device: &Device) -> Self {
        let hidden = multiple_of_eight(HIDDEN * width);
        Self {
            separable: Separable::new(backbone::channels(width), hidden, device),
            last: pointwise(hidden, channels, true, device),
        }
    }

    pub(crate) fn forward<F: NetOps>(&self, input: F) -> F {
        self.separable.forward_relu_behind(input).conv(&self.last)
    }
}

/// The four heads on the finest level of the pyramid.
#[derive(Module, Debug)]
pub(super) struct Heads {
    heatmaps: Head,
    centers: Head,
    regs: Head,
    offsets: Head,
}

impl Heads {
    pub(super) fn new(config: &MoveEnetConfig, device: &Device) -> Self {
        let head = |channels| Head::new(config.width, channels, device);
        let joints = config.joints;
        Self {
            heatmaps: head(joints),
            centers: head(1),
            regs: head(2 * joints),
            offsets: head(2 * joints),
        }
    }

    /// # Shapes
    /// - input: `[batch, channels, height, width]`
    /// - output: as many rows and columns
    pub(super) fn forward<F: NetOps>(&self, input: F) -> BodyMaps<F> {
        BodyMaps {
            heatmaps: self.heatmaps.forward(input.clone()).sigmoid(),
            centers: self.centers.forward(input.clone()).sigmoid(),
            regs: self.regs.forward(input.clone()),
            offsets: self.offsets.forward(input),
        }
    }
}

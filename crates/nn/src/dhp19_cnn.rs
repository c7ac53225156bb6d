//! The network of DHP19: an event image to one heatmap for each joint.
//!
//! # Source
//! Calabrese et al.: *DHP19: Dynamic Vision Sensor 3D Human Pose Dataset*, CVPRW 2019, and the
//! distributed model `DHP_CNN.model`, whose configuration says the rest: no bias anywhere, a ReLU
//! behind every layer and behind the heatmaps. With 13 joints it has 218,592 parameters.

use burn::module::{self, Module};
use burn::nn::PaddingConfig2d;
use burn::nn::conv::{Conv2d, Conv2dConfig, ConvTranspose2d, ConvTranspose2dConfig};
use burn::nn::pool::{MaxPool2d, MaxPool2dConfig};
use burn::tensor::activation::relu;
use burn::tensor::{Device, Tensor};
use serde::{Deserialize, Serialize};

use crate::NnError;
use crate::channels::{check_counts, check_width, scaled};
use crate::initializer::{Initializer, seeded};
use crate::joint_order::{JointAxes, reordered};

/// Channels of the three resolutions as published, the finest first.
const CHANNELS: [usize; 3] = [16, 32, 64];
/// The smallest relative width, which has 1 channel in the finest layers.
const NARROWEST: f32 = 0.0625;

/// Shape of a [`Dhp19Cnn`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Dhp19CnnConfig {
    /// Joints of a body.
    pub joints: usize,
    /// Channels relative to the published network.
    pub width: f32,
}

impl Default for Dhp19CnnConfig {
    /// The published network.
    fn default() -> Self {
        Self { joints: 13, width: 1.0 }
    }
}

/// A network from event images to heatmaps of the same size. The names of its layers are those of
/// the distributed model.
#[derive(Module, Debug)]
pub struct Dhp19Cnn {
    conv1: Conv2d,
    conv2a: Conv2d,
    conv2b: Conv2d,
    conv2d: Conv2d,
    conv3a: Conv2d,
    conv3b: Conv2d,
    conv3c: Conv2d,
    conv3d: Conv2d,
    conv3_up: ConvTranspose2d,
    conv4a: Conv2d,
    conv4b: Conv2d,
    conv4c: Conv2d,
    conv4d: Conv2d,
    conv4_up: ConvTranspose2d,
    conv5a: Conv2d,
    conv5d: Conv2d,
    pred_cube: Conv2d,
    pool: MaxPool2d,
    #[module(skip)]
    config: Dhp19CnnConfig,
}

impl Dhp19CnnConfig {
    /// Sides of images are multiples of it, in pixels.
    pub const SIDE_STEP_PX: usize = 4;

    /// The network with initial weights drawn from `seed`, as Keras does: Xavier uniform.
    ///
    /// # Errors
    /// [`NnError::Width`], and [`NnError::TooFew`] for no joints.
    pub fn init(&self, seed: u64, device: &Device) -> Result<Dhp19Cnn, NnError> {
        Ok(seeded(self.zeros(device)?, seed, |slot| Initializer::xavier_uniform(&slot.shape)))
    }

    /// The network with all weights zero.
    pub(crate) fn zeros(&self, device: &Device) -> Result<Dhp19Cnn, NnError> {
        check_width(self.width, NARROWEST)?;
        check_counts(&[("joints", self.joints)])?;
        // Names of layers are those of the published Keras model, whose weights are found by them.
        let [fine, middle, coarse] = CHANNELS.map(|channels| scaled(channels, self.width));
        // Padding as wide as the dilation: the side stays.
        let conv = |channels: [usize; 2], dilation: usize| {
            Conv2dConfig::new(channels, [3, 3])
                .with_padding(PaddingConfig2d::Explicit(dilation, dilation, dilation, dilation))
                .with_dilation([dilation; 2])
                .with_bias(false)
                .with_initializer(module::Initializer::Zeros)
                .init(device)
        };
        // Without padding the output has a row and a column too many, which `doubled` drops.
        let up = |channels: [usize; 2]| {
            ConvTranspose2dConfig::new(channels, [3, 3])
                .with_stride([2, 2])
                .with_bias(false)
                .with_initializer(module::Initializer::Zeros)
                .init(device)
        };
        Ok(Dhp19Cnn {
            conv1: conv([1, fine], 1),
            conv2a: conv([fine, middle], 1),
            conv2b: conv([middle, middle], 1),
            conv2d: conv([middle, middle], 1),
            conv3a: conv([middle, coarse], 2),
            conv3b: conv([coarse, coarse], 2),
            conv3c: conv([coarse, coarse], 2),
            conv3d: conv([coarse, coarse], 2),
            conv3_up: up([coarse, middle]),
            conv4a: conv([middle, middle], 2),
            conv4b: conv([middle, middle], 2),
            conv4c: conv([middle, middle], 2),
            conv4d: conv([middle, middle], 2),
            conv4_up: up([middle, fine]),
            conv5a: conv([fine, fine], 1),
            conv5d: conv([fine, fine], 1),
            pred_cube: conv([fine, self.joints], 1),
            pool: MaxPool2dConfig::new([2, 2]).init(),
            config: self.clone(),
        })
    }
}

impl Dhp19Cnn {
    /// The heatmaps, of the size of the images; about 1 at a joint and 0 far from it.
    ///
    /// # Shapes
    /// - images: `[batch, 1, height, width]`, values 0 to 255, sides multiples of 4; 260x344 as
    ///   published
    /// - output: `[batch, joints, height, width]`
    pub fn forward(&self, images: Tensor<4>) -> Tensor<4> {
        let through = |x: Tensor<4>, layers: &[&Conv2d]| {
            layers.iter().fold(x, |x, layer| relu(layer.forward(x)))
        };
        let x = self.pool.forward(through(images, &[&self.conv1]));
        let x = self.pool.forward(through(x, &[&self.conv2a, &self.conv2b, &self.conv2d]));
        let x = through(x, &[&self.conv3a, &self.conv3b, &self.conv3c, &self.conv3d]);
        let x = doubled(&self.conv3_up, x);
        let x = through(x, &[&self.conv4a, &self.conv4b, &self.conv4c, &self.conv4d]);
        let x = doubled(&self.conv4_up, x);
        // The published network has a ReLU behind its last layer too: heatmaps are never negative.
        through(x, &[&self.conv5a, &self.conv5d, &self.pred_cube])
    }

    /// The network with its heatmaps in another order: joint `k` is joint `order[k]` of this one.
    #[must_use]
    pub fn with_joint_order(self, order: &[usize]) -> Self {
        reordered(self, order, |slot| JointAxes {
            first: slot.path.starts_with("pred_cube"),
            second: false,
        })
    }

    /// The configuration that it was built from.
    pub fn config(&self) -> &Dhp19CnnConfig {
        &self.config
    }
}

/// `relu(layer(x))` at twice as many rows and columns: as TensorFlow pads transposed convolutions
/// of stride 2, the row and the column beyond are left out at the end, none at the beginning.
fn doubled(layer: &ConvTranspose2d, x: Tensor<4>) -> Tensor<4> {
    let [_, _, height, width] = x.dims();
    relu(layer.forward(x).narrow(2, 0, 2 * height).narrow(3, 0, 2 * width))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_network_has_as_many_parameters_as_the_distributed_one() {
        let network = Dhp19CnnConfig::default().zeros(&Device::flex()).unwrap();
        assert_eq!(crate::parameters::trained_count(&network), 218_592);
    }

    #[test]
    fn heatmaps_are_as_large_as_images_and_without_events_black() {
        let config = Dhp19CnnConfig { joints: 3, width: 0.25 };
        let network = config.init(3, &Device::flex()).unwrap();
        let largest = |grey: f32| -> f32 {
            let images = Tensor::<4>::full([2, 1, 20, 28], grey, &Device::flex());
            let maps = network.forward(images);
            assert_eq!(maps.dims(), [2, 3, 20, 28]);
            maps.max().into_scalar()
        };
        assert_eq!(largest(0.0), 0.0);
        assert!(largest(90.0) > 1e-3);
    }

    #[test]
    fn shapes_that_make_no_sense_are_named() {
        let device = Device::flex();
        let config = Dhp19CnnConfig { joints: 0, width: 1.0 };
        assert!(matches!(config.init(1, &device), Err(NnError::TooFew { field: "joints" })));
        let config = Dhp19CnnConfig { joints: 13, width: 0.01 };
        assert!(matches!(config.init(1, &device), Err(NnError::Width { .. })));
    }
}

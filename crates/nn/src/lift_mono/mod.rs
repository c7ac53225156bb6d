//! LiftMono-HPE: an event image to the joints of a body in three dimensions.
//!
//! * [`LiftMonoConfig`], [`LiftMono`]: the network.
//! * [`MarginalMaps`]: heatmaps on three planes, and the positions that they say.
//! * `plane`: the network of one plane, of `blocks`.
//! * `names`: the names of its tensors in PyTorch.
//!
//! # Model
//! The first two stages of a ResNet-34 make features of an eighth of the image's size. Each of
//! `stages` stages has three networks, one for each plane, whose heatmaps the next stage sees
//! beside the features. All three have the size of the features.
//!
//! # Source
//! Scarpellini, Morerio, Del Bue: *Lifting Monocular Events to 3D Human Poses*, CVPRW 2021, and its
//! published code; the network is MargiPose of Nibali et al.: *3D Human Pose Estimation with 2D
//! Marginal Heatmaps*, WACV 2019.

mod blocks;
mod maps;
mod names;
mod plane;

use burn::module::Module;
use burn::nn::pool::MaxPool2d;
use burn::tensor::{Device, Tensor};
use serde::{Deserialize, Serialize};

use crate::NnError;
use crate::backbone::resnet::{BasicBlock, stage, stem_pool};
use crate::channels::{check_counts, check_width, scaled};
use crate::conv_norm::{ConvNorm, ConvNormConfig};
use crate::initializer::{Initializer, seeded};
use crate::joint_order::{JointAxes, reordered};
use crate::net_ops::NetOps;
use crate::parameters::Slot;
use blocks::ResidualBlock;
use plane::PlaneNet;

pub use maps::MarginalMaps;
pub(crate) use maps::cell_centres;

/// Channels of the first stage of the ResNet and of planes as published; the second stage and
/// planes at half their size have twice as many.
const CHANNELS: usize = 64;
/// Blocks of the first two stages of a ResNet-34.
const BLOCKS: [usize; 2] = [3, 4];
/// Planes of a stage.
const PLANES: usize = 3;
/// The smallest relative width, which has 1 channel.
const NARROWEST: f32 = 0.015_625;

/// Shape of a [`LiftMono`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LiftMonoConfig {
    /// Joints of a body.
    pub joints: usize,
    /// Channels relative to the published network.
    pub width: f32,
    /// Stages, each of three heatmaps; the last counts.
    pub stages: usize,
}

impl Default for LiftMonoConfig {
    /// The published network.
    fn default() -> Self {
        Self { joints: 13, width: 1.0, stages: 3 }
    }
}

/// A network from event images to heatmaps on three planes.
#[derive(Module, Debug)]
pub struct LiftMono {
    stem: ConvNorm,
    pool: MaxPool2d,
    features: Vec<Vec<BasicBlock>>,
    xy: Vec<PlaneNet>,
    zy: Vec<PlaneNet>,
    xz: Vec<PlaneNet>,
    combiners: Vec<ResidualBlock>,
    #[module(skip)]
    config: LiftMonoConfig,
}

impl LiftMonoConfig {
    /// Pixels of the image for each cell of the maps, along either side.
    pub const CELL_PX: usize = 8;

    /// The network with initial weights drawn from `seed`, as published: Kaiming normal, but for
    /// the blocks between stages, which have PyTorch's default.
    ///
    /// # Errors
    /// [`NnError::Width`], and [`NnError::TooFew`] for no joints or no stages.
    pub fn init(&self, seed: u64, device: &Device) -> Result<LiftMono, NnError> {
        Ok(seeded(self.zeros(device)?, seed, |slot| match slot.layer.as_str() {
            "BatchNorm" => Initializer::batch_norm(slot.name()),
            _ if slot.path.starts_with("combiners.") => {
                Initializer::torch_default(slot.shape.iter().skip(1).product())
            }
            // Of transposed convolutions as well: PyTorch takes the first axis for the outputs.
            _ => Initializer::kaiming_fan_out(&slot.shape),
        }))
    }

    /// The network with all weights zero.
    pub(crate) fn zeros(&self, device: &Device) -> Result<LiftMono, NnError> {
        check_width(self.width, NARROWEST)?;
        check_counts(&[("joints", self.joints), ("stages", self.stages)])?;
        let fine = scaled(CHANNELS, self.width);
        let coarse = 2 * fine;
        let plane = |_| PlaneNet::new(fine, coarse, self.joints, device);
        let planes = || (0..self.stages).map(plane).collect::<Vec<_>>();
        let combiner = |_| ResidualBlock::new(PLANES * self.joints, coarse, 1, device);
        let [first, second] = BLOCKS;
        Ok(LiftMono {
            stem: ConvNormConfig::new(1, fine, 7).with_stride(2).init(device),
            pool: stem_pool(),
            features: vec![stage(fine, first, false, device), stage(coarse, second, true, device)],
            xy: planes(),
            zy: planes(),
            xz: planes(),
            // The first stage has no maps of a stage before to combine.
            combiners: (1..self.stages).map(combiner).collect(),
            config: self.clone(),
        })
    }
}

impl LiftMono {
    /// The heatmaps of all stages, in their order: the last is the result.
    ///
    /// # Shapes
    /// - images: `[batch, 1, height, width]`, values 0 to 255; 260x346 as published
    /// - output: `[batch, joints, ceil(height / 8), ceil(width / 8)]`, each of `stages` times three
    pub fn forward(&self, images: Tensor<4>) -> Vec<MarginalMaps> {
        let x = self.stem.forward_relu(images.affine(1.0 / 255.0, 0.0)).max_pool(&self.pool);
        let features = self.features.iter().flatten().fold(x, |x, block| block.forward(x));
        let mut stages: Vec<MarginalMaps> = Vec::new();
        let mut input = features;
        for (index, xy) in self.xy.iter().enumerate() {
            if let Some(before) = stages.last() {
                // Each stage sees what the one before has found, added to the features it started
                // from.
                let seen = Tensor::cat(before.clone().into_array().into(), 1);
                input = input + self.combiners[index - 1].forward(seen);
            }
            let nets = [xy, &self.zy[index], &self.xz[index]];
            let maps = nets.map(|net| maps::softmax(net.forward(input.clone())));
            stages.push(MarginalMaps::from_array(maps));
        }
        stages
    }

    /// The network with its maps in another order: joint `k` is joint `order[k]` of this one.
    #[must_use]
    pub fn with_joint_order(self, order: &[usize]) -> Self {
        reordered(self, order, |slot| {
            let is_conv = slot.name() == "weight";
            if slot.path.starts_with("combiners.") {
                // The blocks between stages begin with the maps of all planes.
                return JointAxes {
                    first: false,
                    second: is_conv && !slot.path.contains("second"),
                };
            }
            let is_last = slot.path.contains(".up.1.");
            JointAxes { first: is_last, second: is_last && slot.path.contains("second.conv") }
        })
    }

    /// The configuration that it was built from.
    pub fn config(&self) -> &LiftMonoConfig {
        &self.config
    }

    /// The name of the tensor in `slot` in the published PyTorch checkpoints.
    pub fn pytorch_name(&self, slot: &Slot) -> String {
        names::pytorch(&slot.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_has_three_maps_of_an_eighth_also_of_odd_sizes() {
        let config = LiftMonoConfig { joints: 5, width: 0.0625, stages: 2 };
        let network = config.init(3, &Device::flex()).unwrap();
        // Ten by five cells, halved to five by three and back.
        let stages = network.forward(Tensor::ones([2, 1, 37, 80], &Device::flex()));
        assert_eq!(stages.len(), 2);
        for maps in stages {
            assert_eq!(maps.positions().dims(), [2, 5, 3]);
            assert!(maps.into_array().iter().all(|map| map.dims() == [2, 5, 5, 10]));
        }
    }

    #[test]
    fn shapes_that_make_no_sense_are_named() {
        let config = LiftMonoConfig { stages: 0, ..LiftMonoConfig::default() };
        let error = config.init(1, &Device::flex()).unwrap_err();
        assert!(matches!(error, NnError::TooFew { field: "stages" }));
    }
}

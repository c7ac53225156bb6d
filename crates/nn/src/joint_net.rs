//! The network of joints: two channels of events to a heatmap and a depth map of every joint of a hand.
//!
//! The image of a finger lies where the finger is. A regressor has to carry it from there into
//! one vector; here it stays in its cell.

use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::nn::conv::Conv2d;
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig, MaxPool2d};
use burn::tensor::{Device, Tensor, TensorData};
use evpose_pose::EVALUATION_JOINTS;
use serde::{Deserialize, Serialize};

use crate::NnError;
use crate::backbone::resnet::{BasicBlock, NARROWEST, PUBLISHED_CHANNELS, stage, stem_pool};
use crate::channels::{check_width, scaled};
use crate::conv_norm::{ConvNorm, ConvNormConfig};
use crate::graph::Graph;
use crate::hand_regressor::EVENT_CHANNELS;
use crate::initializer::{Initializer, seeded};
use crate::linear::linear;
use crate::move_enet::blocks::pointwise;
use crate::net_ops::{NetOps, VectorOps};
use crate::ops::{self, Blocked};
use crate::parameters::trained_count;

/// Basic blocks of each stage. Of ResNet-18's two in the last stage, half of all weights, one is left.
const BLOCKS: [usize; 4] = [2, 2, 2, 1];
/// Channels of the pyramid at width 1. All joints pass through one cell of it: with 24, as of MoveEnet, they do not fit.
const PYRAMID_CHANNELS: usize = 128;
/// Standard deviation of the last weights of both maps: heatmaps begin flat, and depths at the wrist's.
const FIRST_DEVIATION: f32 = 0.01;

/// Shape of a [`JointNet`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JointNetConfig {
    /// Channels relative to ResNet-18 as published.
    pub width: f32,
}

impl Default for JointNetConfig {
    /// The width of ResNet-18 as published.
    fn default() -> Self {
        Self { width: 1.0 }
    }
}

/// The outputs of a [`JointNet`] for a batch; joints are in the order of [`EVALUATION_JOINTS`].
#[derive(Debug, Clone)]
pub struct JointMaps {
    /// Logits of each joint in each cell: `[batch, joints, height / 4, width / 4]`. Their softmax over the
    /// cells is where the joint may be.
    pub heatmaps: Tensor<4>,
    /// Depth of each joint behind the wrist where it lies in a cell, in lengths of the palm: of the same
    /// shape.
    pub depths: Tensor<4>,
    /// Logit of a hand being in the image: `[batch, 1]`.
    pub presence: Tensor<2>,
}

/// A network from event images to heatmaps and depth maps of the joints of a hand.
///
/// # Model
/// ResNet-18 with a block less down to a 32nd of the image, a feature pyramid of equally many channels on each
/// level back up to a quarter, and two heads on its finest level. The mean of that level over the cells gives the presence.
///
/// # Source
/// Latent 2.5D heatmaps: Iqbal, Molchanov, Breuel, Gall, Kautz: *Hand Pose Estimation via Latent 2.5D
/// Heatmap Regression*, ECCV 2018. Pyramid: Lin et al.: *Feature Pyramid Networks for Object Detection*, CVPR 2017.
#[derive(Module, Debug)]
pub struct JointNet {
    stem: ConvNorm,
    stem_pool: MaxPool2d,
    stages: Vec<Vec<BasicBlock>>,
    /// 1x1 from each stage to the channels of the pyramid, the finest first.
    laterals: Vec<Conv2d>,
    /// 3x3 behind each sum of two levels, the finest first.
    smooth: Vec<ConvNorm>,
    heatmaps: Head,
    depths: Head,
    pool: AdaptiveAvgPool2d,
    presence: Linear,
    #[module(skip)]
    config: JointNetConfig,
}

/// 3x3 and 1x1 on the finest level.
#[derive(Module, Debug)]
struct Head {
    hidden: ConvNorm,
    last: Conv2d,
}

impl Head {
    fn new(channels: usize, device: &Device) -> Self {
        let hidden = ConvNormConfig::new(channels, channels, 3).init(device);
        Self { hidden, last: pointwise(channels, EVALUATION_JOINTS.len(), true, device) }
    }

    fn forward<N: NetOps>(&self, input: N) -> N {
        self.hidden.forward_relu(input).conv(&self.last)
    }
}

impl JointNetConfig {
    /// The network with initial weights drawn from `seed`: Kaiming normal for convolutions but the last,
    /// whose are small, and normalisation as the identity.
    ///
    /// # Errors
    /// [`NnError::Width`].
    pub fn init(&self, seed: u64, device: &Device) -> Result<JointNet, NnError> {
        Ok(seeded(self.zeros(device)?, seed, |slot| match (slot.layer.as_str(), slot.name()) {
            ("BatchNorm", name) => Initializer::batch_norm(name),
            ("Conv2d", "weight") if slot.path.contains(".last.") => {
                Initializer::Normal { deviation: FIRST_DEVIATION }
            }
            ("Conv2d", "weight") => Initializer::kaiming_fan_in(&slot.shape),
            ("Linear", "weight") => Initializer::torch_default(slot.shape[0]),
            _ => Initializer::Constant(0.0),
        }))
    }

    /// The number of trainable parameters.
    ///
    /// # Errors
    /// As [`init`](Self::init).
    pub fn parameter_count(&self) -> Result<usize, NnError> {
        Ok(trained_count(&self.zeros(&Device::flex())?))
    }

    /// The network with all weights zero.
    pub(crate) fn zeros(&self, device: &Device) -> Result<JointNet, NnError> {
        check_width(self.width, NARROWEST)?;
        let [first, channels] =
            [PUBLISHED_CHANNELS, PYRAMID_CHANNELS].map(|count| scaled(count, self.width));
        let of_stage = |index: usize| first << index;
        let stages = (0..).zip(BLOCKS);
        Ok(JointNet {
            stem: ConvNormConfig::new(EVENT_CHANNELS, first, 7).with_stride(2).init(device),
            stem_pool: stem_pool(),
            laterals: (0..BLOCKS.len())
                .map(|index| pointwise(of_stage(index), channels, true, device))
                .collect(),
            smooth: (1..BLOCKS.len())
                .map(|_| ConvNormConfig::new(channels, channels, 3).init(device))
                .collect(),
            stages: stages
                .map(|(index, blocks)| stage(of_stage(index), blocks, index > 0, device))
                .collect(),
            heatmaps: Head::new(channels, device),
            depths: Head::new(channels, device),
            pool: AdaptiveAvgPool2dConfig::new([1, 1]).init(),
            presence: linear(channels, 1, device),
            config: *self,
        })
    }
}

impl JointNet {
    /// Sides of images are multiples of this.
    pub const SIDE_MULTIPLE: usize = 32;
    /// Rows and columns of the image to each of the maps.
    pub const STRIDE: usize = 4;

    /// The output maps.
    ///
    /// # Shapes
    /// - events: `[batch, 2, height, width]`, values in [0, 1], sides multiples of [`Self::SIDE_MULTIPLE`]
    /// - output: see [`JointMaps`]
    pub fn forward(&self, events: Tensor<4>) -> JointMaps {
        if ops::is_ours(&events) {
            let (heatmaps, depths, presence) = self.forward_ops(Blocked::from_planes(events));
            let [heatmaps, depths] = [heatmaps, depths].map(Blocked::into_planes);
            return JointMaps { heatmaps, depths, presence };
        }
        let (heatmaps, depths, presence) = self.forward_ops(events);
        let [heatmaps, depths] = [heatmaps, depths].map(ops::widened);
        JointMaps { heatmaps, depths, presence }
    }

    /// The graph of the network, for engines that compile it: heatmaps, depths, presence.
    pub fn graph(&self) -> Graph {
        Graph::trace(self, EVENT_CHANNELS, |events| {
            let (heatmaps, depths, presence) = self.forward_ops(events);
            vec![heatmaps, depths, presence]
        })
    }

    pub(crate) fn forward_ops<N: NetOps>(&self, events: N) -> (N, N, N::Vector) {
        let features = self.features(events);
        let presence = features.clone().avg_pool(&self.pool).linear(&self.presence);
        (self.heatmaps.forward(features.clone()), self.depths.forward(features), presence)
    }

    /// The finest level of the pyramid, a quarter of the image.
    fn features<N: NetOps>(&self, events: N) -> N {
        let mut x = self.stem.forward_relu(events).max_pool(&self.stem_pool);
        let mut levels = Vec::with_capacity(BLOCKS.len());
        for (stage, lateral) in self.stages.iter().zip(&self.laterals) {
            x = stage.iter().fold(x, |x, block| block.forward(x));
            levels.push(x.clone().conv(lateral));
        }
        let coarsest = levels.pop();
        let finer = levels.into_iter().zip(&self.smooth).rev();
        finer.fold(coarsest.expect("four stages"), |coarse, (level, smooth)| {
            smooth.forward_relu(coarse.upsample().add(level))
        })
    }

    /// The means of all features over the cells, of which the presence is a linear function.
    ///
    /// # Shapes
    /// - events: as of [`Self::forward`]
    /// - output: `[batch, features]`
    pub fn presence_features(&self, events: Tensor<4>) -> Tensor<2> {
        self.features(events).avg_pool(&self.pool)
    }

    /// The network with this linear function for its presence: a weight for each feature, and the constant.
    ///
    /// # Panics
    /// If there are not as many weights as features.
    #[must_use]
    pub fn with_presence(mut self, weights: Vec<f32>, constant: f32) -> Self {
        let device = self.presence.weight.device();
        let shape = self.presence.weight.dims();
        let weights = Tensor::from_data(TensorData::new(weights, shape), &device);
        self.presence.weight = Param::initialized(self.presence.weight.id, weights);
        self.presence.bias = self
            .presence
            .bias
            .map(|bias| Param::initialized(bias.id, Tensor::from_data([constant], &device)));
        self
    }

    /// The configuration that it was built from.
    pub fn config(&self) -> &JointNetConfig {
        &self.config
    }
}

impl JointMaps {
    /// All outputs of each image in one row, in the order of [`JointNet::graph`].
    ///
    /// # Shapes
    /// - output: `[batch, 2 * joints * cells + 1]`
    pub fn into_rows(self) -> Tensor<2> {
        let row = |maps: Tensor<4>| maps.flatten::<2>(1, 3);
        Tensor::cat(vec![row(self.heatmaps), row(self.depths), self.presence], 1)
    }
}

#[cfg(test)]
mod tests {
    use burn::optim::GradientsParams;
    use burn::tensor::Distribution;

    use super::*;
    use crate::parameters::{Slot, read, slots};

    fn small() -> JointNetConfig {
        JointNetConfig { width: 0.25 }
    }

    #[test]
    fn maps_are_a_quarter_of_the_image_and_the_first_heatmaps_flat() {
        // As in training: initial running variances are 1, with which values grow from layer to layer.
        let device = Device::flex().autodiff();
        let network = small().init(3, &device).unwrap();
        let images = Tensor::<4>::random([2, 2, 96, 128], Distribution::Uniform(0.0, 1.0), &device);
        let maps = network.forward(images);
        assert_eq!(maps.heatmaps.dims(), [2, 21, 24, 32]);
        assert_eq!(maps.depths.dims(), [2, 21, 24, 32]);
        assert_eq!(maps.presence.dims(), [2, 1]);
        let largest: f32 = maps.heatmaps.clone().abs().max().into_scalar();
        assert!(largest > 0.0 && largest < 1.0, "{largest}");
        assert_eq!(maps.into_rows().dims(), [2, 2 * 21 * 24 * 32 + 1]);
    }

    #[test]
    fn every_weight_is_trained() {
        let device = Device::flex().autodiff();
        let network = small().init(3, &device).unwrap();
        let images = Tensor::<4>::random([2, 2, 64, 64], Distribution::Uniform(0.0, 1.0), &device);
        let JointMaps { heatmaps, depths, presence } = network.forward(images);
        let sum = heatmaps.square().mean() + depths.square().mean() + presence.square().mean();
        let gradients = sum.backward();
        let with_gradient = GradientsParams::from_grads(gradients, &network).len();
        let trained = slots(&network).into_iter().filter(Slot::is_trained).count();
        assert_eq!(with_gradient, trained);
    }

    #[test]
    fn graphs_end_in_both_maps_and_the_presence() {
        let graph = small().init(3, &Device::flex()).unwrap().graph();
        let channels: Vec<_> = graph.outputs.iter().map(|id| graph.nodes[*id].channels).collect();
        assert_eq!(channels, [21, 21, 1]);
        assert_eq!(graph.nodes[0].channels, 2);
    }

    #[test]
    fn a_seed_gives_the_same_weights_and_impossible_widths_are_refused() {
        let weights = |seed| read(&small().init(seed, &Device::flex()).unwrap());
        assert!(weights(7) == weights(7));
        assert!(weights(7) != weights(8));
        for width in [0.0, -1.0, f32::NAN, 1e9] {
            let error = JointNetConfig { width }.zeros(&Device::flex()).map(|_| ()).unwrap_err();
            assert!(error.to_string().starts_with("`width` must"), "{width}");
        }
    }
}

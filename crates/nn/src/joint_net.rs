//! The network of joints: two channels of events to a heatmap and a depth map of every joint of a hand.
//!
//! The image of a finger lies where the finger is. A regressor has to carry it from there into
//! one vector; here it stays in its cell.

use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig};
use burn::tensor::{Device, Tensor, TensorData};
use evpose_pose::EVALUATION_JOINTS;
use serde::{Deserialize, Serialize};

use crate::NnError;
use crate::channels::check_width;
use crate::graph::Graph;
use crate::hand_regressor::EVENT_CHANNELS;
use crate::initializer::{Initializer, seeded};
use crate::linear::linear;
use crate::move_enet::NARROWEST;
use crate::move_enet::backbone::{Pyramid, PyramidConfig, channels};
use crate::move_enet::heads::Head;
use crate::net_ops::{NetOps, VectorOps};
use crate::ops::{self, Blocked};
use crate::parameters::trained_count;

/// Hidden channels for each channel of an inverted residual's input, as of MoveEnet.
const EXPANSION: usize = 6;
/// Repetitions of the last stage's residual. MoveEnet keeps its weights and never uses them.
const LAST_REPETITIONS: usize = 1;
/// Standard deviation of the last weights of both maps: heatmaps begin flat, and depths at the wrist's.
const FIRST_DEVIATION: f32 = 0.01;

/// Shape of a [`JointNet`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JointNetConfig {
    /// Channels relative to the pyramid of MoveEnet as published, rounded to multiples of 8.
    pub width: f32,
}

impl Default for JointNetConfig {
    /// The width of MoveEnet as published.
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
/// MoveEnet's pyramid with two channels of input, and two of its heads on the finest level. The mean of that
/// level over the cells gives the presence.
///
/// # Source
/// Latent 2.5D heatmaps: Iqbal, Molchanov, Breuel, Gall, Kautz: *Hand Pose Estimation via Latent 2.5D
/// Heatmap Regression*, ECCV 2018. Pyramid: Goyal et al.: *MoveEnet*, CVPRW 2023.
#[derive(Module, Debug)]
pub struct JointNet {
    pyramid: Pyramid,
    heatmaps: Head,
    depths: Head,
    pool: AdaptiveAvgPool2d,
    presence: Linear,
    #[module(skip)]
    config: JointNetConfig,
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
        let width = self.width;
        check_width(width, NARROWEST)?;
        let pyramid = PyramidConfig {
            channels_in: EVENT_CHANNELS,
            width,
            expansion: EXPANSION,
            last_repetitions: LAST_REPETITIONS,
        };
        Ok(JointNet {
            pyramid: Pyramid::new(pyramid, device),
            heatmaps: Head::new(width, EVALUATION_JOINTS.len(), device),
            depths: Head::new(width, EVALUATION_JOINTS.len(), device),
            pool: AdaptiveAvgPool2dConfig::new([1, 1]).init(),
            presence: linear(channels(width), 1, device),
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

    fn forward_ops<N: NetOps>(&self, events: N) -> (N, N, N::Vector) {
        let features = self.pyramid.forward(events);
        let presence = features.clone().avg_pool(&self.pool).linear(&self.presence);
        (self.heatmaps.forward(features.clone()), self.depths.forward(features), presence)
    }

    /// The means of all features over the cells, of which the presence is a linear function.
    ///
    /// # Shapes
    /// - events: as of [`Self::forward`]
    /// - output: `[batch, features]`
    pub fn presence_features(&self, events: Tensor<4>) -> Tensor<2> {
        self.pyramid.forward(events).avg_pool(&self.pool)
    }

    /// The network with this linear function for its presence: a weight for each feature, and the constant.
    ///
    /// # Panics
    /// If there are not as many weights as features.
    #[must_use]
    pub fn with_presence(mut self, weights: Vec<f32>, constant: f32) -> Self {
        let device = self.presence.weight.device();
        let weights =
            Tensor::from_data(TensorData::new(weights, [channels(self.config.width), 1]), &device);
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

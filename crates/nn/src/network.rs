//! All networks by name, for benchmarks and exports that treat them alike.

use burn::tensor::{Device, Tensor};

use crate::graph::Graph;
use crate::hand_regressor::EVENT_CHANNELS;
use crate::joint_net::{JointMaps, JointNet, JointNetConfig};
use crate::move_enet::IMAGE_CHANNELS;
use crate::parameters::{trained_count, with_matched_variances};
use crate::timed::{NodeTime, node_times};
use crate::{
    BACKBONES, HandRegressor, HandRegressorConfig, MoveEnet, MoveEnetConfig, NnError,
    backbone_by_name,
};

/// The name of the MoveEnet network.
pub const MOVE_ENET: &str = "move_enet";
/// The name of the network of joints.
pub const JOINT_NET: &str = "joints";
/// Rows and columns of the hand network's input as published: a DAVIS240C.
const HAND_IMAGE: [usize; 2] = [180, 240];
/// Rows and columns of the body network's input as published.
const BODY_IMAGE: [usize; 2] = [192, 192];

/// Rows and columns of the images of the network of joints, a view or a crop of it.
const JOINT_IMAGE: [usize; 2] = [96, 128];

/// A network of either task.
#[derive(Debug, Clone)]
pub enum Network {
    /// The EventHands network, with any of the [`BACKBONES`].
    Hand(Box<HandRegressor>),
    /// The MoveEnet network.
    Body(Box<MoveEnet>),
    /// The network of the joints of a hand.
    Joints(Box<JointNet>),
}

impl Network {
    /// The names of all networks: [`MOVE_ENET`], [`JOINT_NET`], and every backbone, which stands for the hand
    /// network that has it inside.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BACKBONES.iter().map(|entry| entry.name).chain([MOVE_ENET, JOINT_NET])
    }

    /// The network of the name `name`, `width` times as wide as published, with initial weights
    /// drawn from `seed`.
    ///
    /// # Errors
    /// [`NnError::UnknownNetwork`], which lists the known names, and [`NnError::Width`].
    pub fn untrained(name: &str, width: f32, seed: u64, device: &Device) -> Result<Self, NnError> {
        if name == MOVE_ENET {
            let config = MoveEnetConfig { width, ..MoveEnetConfig::default() };
            return Ok(Self::Body(Box::new(config.init(seed, device)?)));
        }
        if name == JOINT_NET {
            return Ok(Self::Joints(Box::new(JointNetConfig { width }.init(seed, device)?)));
        }
        // The registry's own error would list backbones alone.
        let Ok(entry) = backbone_by_name(name) else {
            let known: Vec<_> = Self::names().collect();
            return Err(NnError::UnknownNetwork { name: name.to_owned(), known: known.join(", ") });
        };
        let config = HandRegressorConfig {
            backbone: entry.name.to_owned(),
            width,
            ..HandRegressorConfig::default()
        };
        Ok(Self::Hand(Box::new(config.init(seed, device)?)))
    }

    /// The graph of the network, for engines that compile it.
    pub fn graph(&self) -> Graph {
        match self {
            Self::Hand(network) => network.graph(),
            Self::Body(network) => network.graph(),
            Self::Joints(network) => network.graph(),
        }
    }

    /// Channels, rows and columns of the input as published.
    pub fn input(&self) -> [usize; 3] {
        match self {
            Self::Hand(_) => [EVENT_CHANNELS, HAND_IMAGE[0], HAND_IMAGE[1]],
            Self::Body(_) => [IMAGE_CHANNELS, BODY_IMAGE[0], BODY_IMAGE[1]],
            Self::Joints(_) => [EVENT_CHANNELS, JOINT_IMAGE[0], JOINT_IMAGE[1]],
        }
    }

    /// The largest value of an input; the smallest is 0.
    pub fn max_input(&self) -> f32 {
        match self {
            Self::Hand(_) | Self::Joints(_) => 1.0,
            Self::Body(_) => 255.0,
        }
    }

    /// The outputs for images `[batch, channels, height, width]`, computed by Burn: in the order of
    /// [`Graph::outputs`], each for the whole batch.
    pub fn outputs(&self, images: Tensor<4>) -> Vec<Vec<f32>> {
        let values = |map: Tensor<4>| map.into_data().iter::<f32>().collect();
        match self {
            Self::Hand(network) => vec![network.forward(images).into_data().iter().collect()],
            Self::Body(network) => network.forward(images).into_array().map(values).into(),
            Self::Joints(network) => {
                let JointMaps { heatmaps, depths, presence } = network.forward(images);
                vec![values(heatmaps), values(depths), presence.into_data().iter().collect()]
            }
        }
    }

    /// How long each node of the graph but the input takes on the device of the images, in the order of
    /// [`Graph::nodes`]. Inputs are as those of [`Self::outputs`].
    ///
    /// # Panics
    /// If the device fails.
    pub fn node_times(&self, images: Tensor<4>) -> Vec<NodeTime> {
        match self {
            Self::Hand(network) => node_times(images, |x| network.forward_ops(x)),
            Self::Body(network) => node_times(images, |x| network.forward_ops(x)),
            Self::Joints(network) => node_times(images, |x| network.forward_ops(x)),
        }
    }

    /// The number of trainable parameters.
    pub fn parameter_count(&self) -> usize {
        match self {
            Self::Hand(network) => trained_count(&**network),
            Self::Body(network) => trained_count(&**network),
            Self::Joints(network) => trained_count(&**network),
        }
    }

    /// The network with running variances as of its weights, see [`with_matched_variances`].
    #[must_use]
    pub fn with_matched_variances(self) -> Self {
        match self {
            Self::Hand(network) => Self::Hand(Box::new(with_matched_variances(*network))),
            Self::Body(network) => Self::Body(Box::new(with_matched_variances(*network))),
            Self::Joints(network) => Self::Joints(Box::new(with_matched_variances(*network))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_a_network_with_as_many_outputs_as_its_graph() {
        let device = Device::flex();
        for name in Network::names() {
            let network = Network::untrained(name, 0.1, 3, &device).unwrap();
            let [channels, ..] = network.input();
            let graph = network.graph();
            assert_eq!(graph.nodes[0].channels, channels, "{name}");
            let values = network.outputs(Tensor::ones([1, channels, 96, 96], &device));
            assert_eq!(values.len(), graph.outputs.len(), "{name}");
            let times = network.node_times(Tensor::ones([1, channels, 96, 96], &device));
            let timed = times.iter().map(|node| node.output[0]);
            assert!(graph.nodes[1..].iter().map(|node| node.channels).eq(timed), "{name}");
        }
        let error = Network::untrained("move", 1.0, 3, &device).unwrap_err().to_string();
        assert!(error.ends_with("inception_v3, move_enet, joints"), "{error}");
    }
}

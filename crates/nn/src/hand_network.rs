//! The networks of hands: of parameters, and of joints from which parameters are fitted.

use burn::module::Module;
use burn::tensor::{Device, Tensor};

use crate::graph::Graph;
use crate::hand_head::HandHead;
use crate::joint_net::{JointNet, JointNetConfig};
use crate::weights::{ModelCard, StoredNetwork};
use crate::{HandRegressor, HandRegressorConfig, NnError};

/// A network of hands.
#[derive(Module, Debug)]
#[allow(clippy::large_enum_variant, reason = "one per experiment, never in a collection")]
pub enum HandNetwork {
    /// Events to parameters.
    Regressor(HandRegressor),
    /// Events to joints.
    Joints(JointNet),
}

impl HandNetwork {
    /// The network of `config` with initial weights drawn from `seed`.
    ///
    /// # Errors
    /// [`NnError::UnknownBackbone`] and [`NnError::Width`].
    pub fn init(config: &HandRegressorConfig, seed: u64, device: &Device) -> Result<Self, NnError> {
        Ok(match config.head {
            HandHead::Regressor => Self::Regressor(config.init(seed, device)?),
            HandHead::Joints => Self::Joints(of_joints(config).init(seed, device)?),
        })
    }

    /// The outputs of each image in one row: 12 or 15 of a regressor, see
    /// [`RotationOutput`](crate::RotationOutput); of joints see
    /// [`JointMaps::into_rows`](crate::JointMaps::into_rows).
    ///
    /// # Shapes
    /// - events: `[batch, 2, height, width]`, values in [0, 1]
    /// - output: `[batch, outputs]`
    pub fn forward(&self, events: Tensor<4>) -> Tensor<2> {
        match self {
            Self::Regressor(network) => network.forward(events),
            Self::Joints(network) => network.forward(events).into_rows(),
        }
    }

    /// The graph of the network, for engines that compile it.
    pub fn graph(&self) -> Graph {
        match self {
            Self::Regressor(network) => network.graph(),
            Self::Joints(network) => network.graph(),
        }
    }

    /// The regressor; none of joints.
    pub fn into_regressor(self) -> Option<HandRegressor> {
        match self {
            Self::Regressor(network) => Some(network),
            Self::Joints(_) => None,
        }
    }

    /// The configuration that it was built from.
    pub fn config(&self) -> HandRegressorConfig {
        match self {
            Self::Regressor(network) => network.config().clone(),
            Self::Joints(network) => HandRegressorConfig {
                backbone: HandHead::BACKBONE.to_owned(),
                width: network.config().width,
                head: HandHead::Joints,
                ..HandRegressorConfig::default()
            },
        }
    }
}

impl StoredNetwork for HandNetwork {
    type Card = ModelCard;

    const KEY: &'static str = HandRegressor::KEY;

    fn described(&self, card: &ModelCard) -> ModelCard {
        ModelCard { network: self.config(), ..card.clone() }
    }

    fn of_card(card: &ModelCard, device: &Device) -> Result<Self, NnError> {
        Ok(match card.network.head {
            HandHead::Regressor => Self::Regressor(card.network.zeros(device)?),
            HandHead::Joints => Self::Joints(of_joints(&card.network).zeros(device)?),
        })
    }
}

fn of_joints(config: &HandRegressorConfig) -> JointNetConfig {
    JointNetConfig { width: config.width }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::slots;
    use crate::weights::{load, save};

    fn config(head: HandHead) -> HandRegressorConfig {
        let backbone = match head {
            HandHead::Regressor => "resnet18",
            HandHead::Joints => HandHead::BACKBONE,
        };
        let rotation = Default::default();
        HandRegressorConfig { backbone: backbone.to_owned(), width: 0.125, rotation, head }
    }

    #[test]
    fn files_of_either_head_are_read_back_and_those_of_regressors_have_the_bytes_they_had() {
        let (device, directory) = (Device::flex(), tempfile::tempdir().unwrap());
        let images = Tensor::<4>::ones([2, 2, 32, 64], &device);
        let values = |network: &HandNetwork| -> Vec<f32> {
            network.forward(images.clone()).into_data().iter().collect()
        };
        let [path, before] = ["either.bpk", "before.bpk"].map(|name| directory.path().join(name));
        for head in [HandHead::Regressor, HandHead::Joints] {
            let config = config(head);
            let network = HandNetwork::init(&config, 5, &device).unwrap();
            save(&path, &network, &ModelCard::default()).unwrap();
            let (back, card) = load::<HandNetwork>(&path, &device).unwrap();
            assert_eq!((&card.network, &back.config()), (&config, &config));
            assert_eq!(values(&back), values(&network));
        }
        let regressor = HandNetwork::init(&config(HandHead::Regressor), 5, &device).unwrap();
        let regressor = regressor.into_regressor().unwrap();
        save(&before, &regressor, &ModelCard::default()).unwrap();
        save(&path, &HandNetwork::Regressor(regressor), &ModelCard::default()).unwrap();
        assert!(std::fs::read(&before).unwrap() == std::fs::read(&path).unwrap());
        assert!(load::<HandNetwork>(&before, &device).is_ok());
    }

    #[test]
    fn configs_without_a_head_are_of_regressors_and_are_written_without_one() {
        let text = toml::to_string(&config(HandHead::Regressor)).unwrap();
        assert!(!text.contains("head"), "{text}");
        assert_eq!(toml::from_str::<HandRegressorConfig>(&text).unwrap().head, HandHead::Regressor);
        let text = toml::to_string(&config(HandHead::Joints)).unwrap();
        assert!(text.contains("head = \"joints\""), "{text}");
    }

    #[test]
    fn the_two_kinds_share_no_weights() {
        let paths = |head| {
            let network = HandNetwork::init(&config(head), 1, &Device::flex()).unwrap();
            slots(&network).into_iter().map(|slot| slot.path).collect::<Vec<_>>()
        };
        let joints = paths(HandHead::Joints);
        assert!(paths(HandHead::Regressor).iter().all(|path| !joints.contains(path)));
    }
}

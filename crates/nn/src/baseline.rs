//! The networks that MoveEnet is compared with, by name.

use burn::module::Module;
use burn::tensor::Device;
use serde::{Deserialize, Serialize};

use crate::{Dhp19Cnn, Dhp19CnnConfig, LiftMono, LiftMonoConfig, NnError};

/// Shape of a [`BaselineNetwork`], whose name is `kind`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum BaselineNetworkConfig {
    /// The network of DHP19: heatmaps.
    Dhp19Cnn(Dhp19CnnConfig),
    /// LiftMono-HPE: heatmaps on three planes.
    LiftMono(LiftMonoConfig),
}

/// A network from event images to heatmaps of a body's joints.
#[derive(Module, Debug)]
#[allow(clippy::large_enum_variant, reason = "one per network, never in a collection")]
pub enum BaselineNetwork {
    /// The network of DHP19: heatmaps.
    Dhp19Cnn(Dhp19Cnn),
    /// LiftMono-HPE: heatmaps on three planes.
    LiftMono(LiftMono),
}

impl Default for BaselineNetworkConfig {
    /// The network of DHP19.
    fn default() -> Self {
        Self::Dhp19Cnn(Dhp19CnnConfig::default())
    }
}

impl BaselineNetworkConfig {
    /// The name of the network, as in configs.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Dhp19Cnn(_) => "dhp19-cnn",
            Self::LiftMono(_) => "lift-mono",
        }
    }

    /// Joints of a body.
    pub fn joints(&self) -> usize {
        match self {
            Self::Dhp19Cnn(config) => config.joints,
            Self::LiftMono(config) => config.joints,
        }
    }

    /// The network with initial weights drawn from `seed`.
    ///
    /// # Errors
    /// [`NnError::Width`], and [`NnError::TooFew`] for no joints or no stages.
    pub fn init(&self, seed: u64, device: &Device) -> Result<BaselineNetwork, NnError> {
        Ok(match self {
            Self::Dhp19Cnn(config) => BaselineNetwork::Dhp19Cnn(config.init(seed, device)?),
            Self::LiftMono(config) => BaselineNetwork::LiftMono(config.init(seed, device)?),
        })
    }

    /// The network with all weights zero.
    pub(crate) fn zeros(&self, device: &Device) -> Result<BaselineNetwork, NnError> {
        Ok(match self {
            Self::Dhp19Cnn(config) => BaselineNetwork::Dhp19Cnn(config.zeros(device)?),
            Self::LiftMono(config) => BaselineNetwork::LiftMono(config.zeros(device)?),
        })
    }
}

impl BaselineNetwork {
    /// The configuration that it was built from.
    pub fn config(&self) -> BaselineNetworkConfig {
        match self {
            Self::Dhp19Cnn(network) => BaselineNetworkConfig::Dhp19Cnn(network.config().clone()),
            Self::LiftMono(network) => BaselineNetworkConfig::LiftMono(network.config().clone()),
        }
    }
}

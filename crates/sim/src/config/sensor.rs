//! The sensor of a simulation: one that comes with the program, or one written out.

use evpose_sensor::{SensorConfig, SensorError};
use serde::{Deserialize, Serialize};

/// A preset's name, or a list of effects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a preset's name or a list of [[sensor.effect]]")]
pub enum SensorChoice {
    /// `sensor = "eventhands"`.
    Preset(String),
    /// `[[sensor.effect]]` tables.
    Chain(SensorConfig),
}

impl Default for SensorChoice {
    fn default() -> Self {
        Self::Preset("eventhands".to_owned())
    }
}

impl SensorChoice {
    /// The effects.
    ///
    /// # Errors
    /// If there is no preset of that name.
    pub fn resolve(&self) -> Result<SensorConfig, SensorError> {
        match self {
            Self::Preset(name) => SensorConfig::preset(name),
            Self::Chain(config) => Ok(config.clone()),
        }
    }
}

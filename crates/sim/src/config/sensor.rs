//! The sensor of a simulation: a preset or a list of effects.

use evpose_sensor::{SensorConfig, SensorError, SensorModel, Value};
use serde::{Deserialize, Serialize};

/// Sensor configuration: a preset's name or a list of effects.
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
    /// Resolves the preset to its effects.
    ///
    /// # Errors
    /// If there is no preset of that name.
    pub fn resolve(&self) -> Result<SensorConfig, SensorError> {
        match self {
            Self::Preset(name) => SensorConfig::preset(name),
            Self::Chain(config) => Ok(config.clone()),
        }
    }

    /// The sensor with `offset` added to every contrast threshold, in natural-log intensity.
    pub(crate) fn model(&self, offset: f64) -> Result<SensorModel, SensorError> {
        let mut config = self.resolve()?;
        for effect in &mut config.effects {
            for (key, value) in &mut effect.params {
                if let ("threshold_on" | "threshold_off", Value::Number(threshold)) =
                    (key.as_str(), value)
                {
                    *threshold += offset;
                }
            }
        }
        SensorModel::from_config(&config)
    }
}

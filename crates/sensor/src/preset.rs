//! Sensor presets. Each file states the source of its values.

use crate::{SensorConfig, SensorError};

/// A sensor by name, with its configuration as it is in `configs/sensor/`.
#[derive(Debug, Clone, Copy)]
pub struct Preset {
    /// The name, as given on the command line.
    pub name: &'static str,
    /// The TOML file, comments included.
    pub toml: &'static str,
}

impl Preset {
    /// Description and source of the sensor: the comment at the head of its file.
    pub fn origin(&self) -> String {
        let head = self.toml.lines().map_while(|line| line.strip_prefix('#'));
        let words: Vec<&str> = head.flat_map(str::split_whitespace).collect();
        words.join(" ")
    }
}

macro_rules! preset {
    ($name:literal) => {
        Preset { name: $name, toml: evpose_configs::text(concat!("sensor/", $name, ".toml")) }
    };
}

/// All presets.
pub static PRESETS: &[Preset] = &[
    preset!("ideal"),
    preset!("eventhands"),
    preset!("esim"),
    preset!("v2e-clean"),
    preset!("v2e-noisy"),
    preset!("dvs-voltmeter"),
    preset!("davis240c"),
    preset!("davis346"),
    preset!("dvxplorer"),
    preset!("evk4"),
];

impl SensorConfig {
    /// The preset called `name`.
    ///
    /// # Errors
    /// If there is none.
    pub fn preset(name: &str) -> Result<Self, SensorError> {
        let preset = PRESETS.iter().find(|preset| preset.name == name).ok_or_else(|| {
            SensorError::UnknownPreset {
                name: name.to_owned(),
                allowed: PRESETS.iter().map(|preset| preset.name).collect(),
            }
        })?;
        Self::from_toml(preset.toml)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SensorModel;

    #[test]
    fn every_preset_is_a_sensor() {
        for preset in PRESETS {
            SensorModel::from_config(&SensorConfig::preset(preset.name).unwrap())
                .unwrap_or_else(|error| panic!("{}: {error}", preset.name));
        }
    }

    #[test]
    fn the_default_is_the_ideal_preset() {
        assert_eq!(SensorConfig::preset("ideal").unwrap(), SensorConfig::default());
    }

    #[test]
    fn an_unknown_preset_names_the_known_ones() {
        let error = SensorConfig::preset("davis").unwrap_err().to_string();
        assert!(error.starts_with("unknown sensor preset `davis`; there are: ideal, eventhands, "));
    }
}

//! Sensor presets. Each file states the source of its values.

use evpose_configs::text;
use evpose_core::{Registry, registry_entry};

use crate::{SensorConfig, SensorError};

/// A sensor by name, with its configuration as it is in `configs/sensor/`.
#[derive(Debug)]
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

/// All presets; those of other crates come last.
pub static PRESETS: Registry<Preset> = Registry::new(&[
    &Preset { name: "ideal", toml: text("sensor/ideal.toml") },
    &Preset { name: "eventhands", toml: text("sensor/eventhands.toml") },
    &Preset { name: "esim", toml: text("sensor/esim.toml") },
    &Preset { name: "v2e-clean", toml: text("sensor/v2e-clean.toml") },
    &Preset { name: "v2e-noisy", toml: text("sensor/v2e-noisy.toml") },
    &Preset { name: "dvs-voltmeter", toml: text("sensor/dvs-voltmeter.toml") },
    &Preset { name: "davis240c", toml: text("sensor/davis240c.toml") },
    &Preset { name: "davis346", toml: text("sensor/davis346.toml") },
    &Preset { name: "dvxplorer", toml: text("sensor/dvxplorer.toml") },
    &Preset { name: "evk4", toml: text("sensor/evk4.toml") },
]);

registry_entry!(Preset, "preset");

impl SensorConfig {
    /// The preset called `name`.
    ///
    /// # Errors
    /// If there is none.
    pub fn preset(name: &str) -> Result<Self, SensorError> {
        let preset = PRESETS.find(name).ok_or_else(|| SensorError::UnknownPreset {
            name: name.to_owned(),
            allowed: PRESETS.names(),
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
        for preset in &PRESETS {
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

//! Sensors by name or by file.

use std::path::Path;

use anyhow::{Context, Result, bail};
use evpose_sensor::{PRESETS, STAGES, SensorConfig, SensorModel, nearest};

/// A sensor with its description and origin.
pub struct NamedSensor {
    /// The preset's name, or the path.
    pub name: String,
    /// Description and origin.
    pub origin: String,
    /// Chain of effects.
    pub config: SensorConfig,
}

impl NamedSensor {
    /// Builds the sensor.
    pub fn model(&self) -> Result<SensorModel> {
        SensorModel::from_config(&self.config).with_context(|| self.name.clone())
    }
}

/// Loads the preset `name`, or else the file of that path; paths inside are relative to the file.
pub fn sensor(name: &str) -> Result<NamedSensor> {
    // Presets first: a file of the same name in the working folder does not replace one.
    if let Some(preset) = PRESETS.find(name) {
        let config = SensorConfig::preset(name)?;
        return Ok(NamedSensor { name: name.to_owned(), origin: preset.origin(), config });
    }
    let path = Path::new(name);
    if !path.exists() {
        let presets = PRESETS.names();
        // The likely mistake is a name from the list of effects.
        if STAGES.find(name).is_some() {
            bail!(
                "`{name}` is an effect, not a sensor; sensors are files of effects, and {}",
                presets.join(", ")
            );
        }
        bail!(unknown("file or preset", name, &presets));
    }
    let text = std::fs::read_to_string(path).with_context(|| format!("reading {name}"))?;
    let config = SensorConfig::from_toml(&text).with_context(|| name.to_owned())?;
    // Its maps lie relative to the file, wherever the program runs.
    let config = config.relative_to(path.parent().unwrap_or(Path::new("")));
    Ok(NamedSensor { name: name.to_owned(), origin: format!("Read from {name}."), config })
}

/// Error message for an unknown name, with the nearest known ones.
pub fn unknown(what: &str, name: &str, known: &[&str]) -> String {
    let near = nearest(name, known.iter().copied());
    let hint = if near.is_empty() {
        "`evpose sensor list` shows all there are".to_owned()
    } else {
        format!("did you mean {}?", near.join(" or "))
    };
    format!("no {what} is called `{name}`; {hint}")
}

//! Sensors by name or by file.

use std::path::Path;

use anyhow::{Context, Result, bail};
use evpose_sensor::{PRESETS, SensorConfig};

/// The preset called `source`, or else the file. Paths in a file begin where it is.
pub(crate) fn load(source: &str) -> Result<SensorConfig> {
    if PRESETS.iter().any(|preset| preset.name == source) {
        return Ok(SensorConfig::preset(source)?);
    }
    let path = Path::new(source);
    if !path.exists() {
        let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        bail!(
            "{source}: no such file, and no preset of that name (there are {})",
            names.join(", ")
        );
    }
    let text =
        std::fs::read_to_string(path).with_context(|| format!("{source}: cannot be read"))?;
    let config = SensorConfig::from_toml(&text).with_context(|| source.to_owned())?;
    Ok(config.relative_to(path.parent().unwrap_or(Path::new(""))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_that_is_nowhere_is_an_error_that_lists_the_presets() {
        let message = load("nowhere").map_or_else(|e| e.to_string(), |_| String::new());
        assert!(message.contains("v2e-clean") && message.contains("davis346"), "{message}");
    }
}

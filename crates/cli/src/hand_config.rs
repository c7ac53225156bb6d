//! Configs by file or by name.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use evpose_configs::text;
use evpose_task::TaskError;
use evpose_task::hand::HandConfig;

use crate::config_names::unknown_config;

/// Configs embedded in the binary.
const EMBEDDED: &[(&str, &str)] = &[
    ("quick", text("hand/quick.toml")),
    ("hand-wide", text("hand/wide.toml")),
    ("ablation", text("hand/ablation.toml")),
    ("eventhands", text("hand/eventhands.toml")),
];

/// Names of the embedded configs.
pub fn names() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().map(|(name, _)| *name)
}

/// Whether there is an embedded config of this name.
pub fn is_embedded(name: &str) -> bool {
    names().any(|embedded| embedded == name)
}

/// Loads the embedded config `source`, or else the file of that path.
///
/// # Errors
/// If there is neither, or it makes no sense.
pub fn load(source: &str, overrides: &[String]) -> Result<HandConfig> {
    read_with(source, HandConfig::parse, HandConfig::load, overrides)
}

/// As [`load`], for a simulation: its sequences may be shorter than a training would need.
///
/// # Errors
/// As [`load`], but for the fields of the training.
pub fn load_for_simulation(source: &str, overrides: &[String]) -> Result<HandConfig> {
    let (parse, load) = (HandConfig::parse_for_simulation, HandConfig::load_for_simulation);
    read_with(source, parse, load, overrides)
}

/// Reads a config with `parse` if it is embedded, or else with `load`.
fn read_with(
    source: &str,
    parse: fn(&str, &[String]) -> Result<HandConfig, TaskError>,
    load: fn(&Path, &[String]) -> Result<HandConfig, TaskError>,
    overrides: &[String],
) -> Result<HandConfig> {
    if let Some((name, text)) = EMBEDDED.iter().find(|(name, _)| *name == source) {
        return parse(text, overrides).with_context(|| format!("the embedded config `{name}`"));
    }
    let path = Path::new(source);
    ensure!(path.exists(), unknown_config(source));
    Ok(load(path, overrides)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flatten(prefix: &str, table: &toml::Table, out: &mut Vec<(String, toml::Value)>) {
        for (key, value) in table {
            let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            match value {
                toml::Value::Table(inner) => flatten(&path, inner, out),
                other => out.push((path, other.clone())),
            }
        }
    }

    fn fields(config: &HandConfig) -> Result<Vec<(String, toml::Value)>> {
        let mut out = Vec::new();
        flatten("", &toml::from_str(&config.to_toml()?)?, &mut out);
        Ok(out)
    }

    #[test]
    fn the_published_config_is_the_default() -> Result<()> {
        assert_eq!(load("eventhands", &[])?, HandConfig::default());
        Ok(())
    }

    /// Fields in which two embedded configs may differ, and no others.
    fn differ_only_in(one: &str, other: &str, allowed: &[&str]) -> Result<()> {
        let (ours, theirs) = (fields(&load(one, &[])?)?, fields(&load(other, &[])?)?);
        assert_eq!(ours.len(), theirs.len(), "a field is missing in one of the two");
        for ((key, value), (other_key, other_value)) in ours.iter().zip(&theirs) {
            assert_eq!(key, other_key);
            assert!(
                value == other_value || allowed.contains(&key.as_str()),
                "{key} is {value} in {one}.toml and {other_value} in {other}.toml"
            );
        }
        Ok(())
    }

    /// The quick config is the published one, smaller: nothing else may differ.
    #[test]
    fn quick_differs_only_in_image_scale_width_duration_and_steps() -> Result<()> {
        const ALLOWED: &[&str] = &[
            // image scale
            "simulation.image_scale",
            // width
            "network.width",
            // duration
            "simulation.sequences",
            "simulation.seconds",
            "training.validation_s",
            "evaluation.sequences",
            "evaluation.seconds",
            // steps
            "training.steps",
            "training.steps_per_validation",
            "training.validation_samples",
            // filters of the network that was trained
            "training.estimate_filter",
        ];
        differ_only_in("quick", "eventhands", ALLOWED)
    }

    #[test]
    fn ablation_is_quick_trained_for_a_shorter_time_and_evaluated_where_all_windows_are_full()
    -> Result<()> {
        const ALLOWED: &[&str] = &[
            "training.steps",
            "training.steps_per_validation",
            "training.validation_samples",
            "training.estimate_filter",
            "evaluation.sequences",
            "evaluation.seconds",
            "evaluation.first_ms",
        ];
        differ_only_in("ablation", "quick", ALLOWED)
    }

    #[test]
    fn a_config_that_is_nowhere_is_an_error_that_lists_the_embedded_ones() {
        let message = load("nowhere", &[]).map_or_else(|e| e.to_string(), |_| String::new());
        assert!(message.contains("quick") && message.contains("eventhands"), "{message}");
    }
}

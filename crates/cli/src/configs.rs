//! Configs of every task, by file or by name.

use std::borrow::Cow;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use evpose_configs::text;
use evpose_core::{Registry, registry_entry};
use evpose_sensor::nearest;
use evpose_task::Experiment;

/// A config in the program.
#[derive(Debug)]
pub struct EmbeddedConfig {
    /// Name, in place of a file.
    pub name: &'static str,
    /// The TOML file, comments included.
    pub toml: &'static str,
}

/// The configs in the program; those of other crates come last.
pub static CONFIGS: Registry<EmbeddedConfig> = Registry::new(&[
    &EmbeddedConfig { name: "quick", toml: text("hand/quick.toml") },
    &EmbeddedConfig { name: "hand-wide", toml: text("hand/wide.toml") },
    &EmbeddedConfig { name: "hand-joints", toml: text("hand/joints.toml") },
    &EmbeddedConfig { name: "ablation", toml: text("hand/ablation.toml") },
    &EmbeddedConfig { name: "eventhands", toml: text("hand/eventhands.toml") },
    &EmbeddedConfig { name: "pretrain", toml: text("body/pretrain.toml") },
    &EmbeddedConfig { name: "finetune", toml: text("body/finetune.toml") },
    &EmbeddedConfig { name: "body-wide", toml: text("body/wide.toml") },
    &EmbeddedConfig { name: "studio", toml: text("body/studio.toml") },
    &EmbeddedConfig { name: "pretrain-full", toml: text("body/pretrain-full.toml") },
    &EmbeddedConfig { name: "finetune-full", toml: text("body/finetune-full.toml") },
    &EmbeddedConfig { name: "dhp19-cnn", toml: text("baseline/dhp19-cnn.toml") },
    &EmbeddedConfig { name: "lift-mono", toml: text("baseline/lift-mono.toml") },
]);

registry_entry!(EmbeddedConfig, "config");

/// The text of the embedded config `source`, or else of the file of that path.
///
/// # Errors
/// If there is neither.
pub(crate) fn toml_of(source: &str) -> Result<Cow<'static, str>> {
    if let Some(config) = CONFIGS.find(source) {
        return Ok(Cow::Borrowed(config.toml));
    }
    ensure!(Path::new(source).exists(), unknown(source));
    Ok(Cow::Owned(std::fs::read_to_string(source).with_context(|| source.to_owned())?))
}

/// Loads the embedded config `source`, or else the file of that path. `overrides` are
/// `dotted.key=value`.
///
/// # Errors
/// If there is neither, if it is of another task, or it makes no sense.
pub fn load<C: Experiment>(source: &str, overrides: &[String]) -> Result<C> {
    read(source, overrides, C::validate)
}

/// As [`load`], for a simulation: its sequences may be shorter than a training would need.
///
/// # Errors
/// As [`load`], but for the fields of the training.
pub fn load_for_simulation<C: Experiment>(source: &str, overrides: &[String]) -> Result<C> {
    read(source, overrides, C::validate_simulation)
}

fn read<C: Experiment>(
    source: &str,
    overrides: &[String],
    check: fn(&C) -> Result<(), evpose_task::TaskError>,
) -> Result<C> {
    let text = toml_of(source)?;
    let config = C::unchecked(&text, overrides).and_then(|config| check(&config).map(|()| config));
    config.with_context(|| format!("the config `{source}`"))
}

/// Message for `source`, which is neither a file nor an embedded config: the most similar names, and
/// all there are.
fn unknown(source: &str) -> String {
    let names = CONFIGS.names();
    let near = nearest(source, names.iter().copied());
    let hint = match near.as_slice() {
        [] => String::new(),
        near => format!(": did you mean {}?", near.join(" or ")),
    };
    format!(
        "{source}: no such file, and no embedded config of that name{hint} (there are {})",
        names.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use evpose_task::baseline::BaselineConfig;
    use evpose_task::body::BodyConfig;
    use evpose_task::hand::HandConfig;

    use super::*;
    use crate::tasks::task_of_config;

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
    fn published_configs_are_those_of_the_code() -> Result<()> {
        assert_eq!(load::<HandConfig>("eventhands", &[])?, HandConfig::default());
        assert_eq!(load::<BaselineConfig>("dhp19-cnn", &[])?, BaselineConfig::dhp19_cnn());
        assert_eq!(load::<BaselineConfig>("lift-mono", &[])?, BaselineConfig::lift_mono());
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
    fn every_embedded_config_is_of_the_task_that_it_names() -> Result<()> {
        for EmbeddedConfig { name, .. } in CONFIGS.iter().copied() {
            let is = task_of_config(name)?.name();
            let read = [
                ("hand", load::<HandConfig>(name, &[]).map(drop)),
                ("body", load::<BodyConfig>(name, &[]).map(drop)),
                ("baseline", load::<BaselineConfig>(name, &[]).map(drop)),
            ];
            for (task, read) in read {
                let message = read.map_or_else(|e| format!("{e:#}"), |()| String::new());
                let other = format!("must be \"{task}\", and is \"{is}\"");
                assert!(message.is_empty() == (task == is), "{name}: {message}");
                assert!(task == is || message.contains(&other), "{name}: {message}");
            }
        }
        Ok(())
    }

    #[test]
    fn the_nearest_name_is_suggested_and_configs_of_all_tasks_are_listed() {
        let message = unknown("fintune");
        assert!(message.contains("did you mean finetune"), "{message}");
        assert!(message.contains("quick") && message.contains("pretrain-full"), "{message}");
        let message = unknown("runs/config.toml");
        assert!(!message.contains("did you mean") && message.contains("body-wide"), "{message}");
    }
}

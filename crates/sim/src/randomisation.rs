//! Randomisation: the fields of a configuration that differ from recording to recording.
//!
//! A TOML file lists them, each with its range and the reason for it:
//!
//! ```toml
//! [[vary]]
//! field = "sensor.level_crossing.threshold_on"
//! range = [0.1, 0.6]
//! scale = "log"
//! reason = "contrast thresholds of cameras, from the catalogue's prior"
//! ```
//!
//! A field is named by its path in the configuration. `sensor` is a preset, and `sensor.EFFECT` the
//! effect of that name, which is added where the sensor has none. Entries are drawn in the order of
//! the file, each from a random stream of its own: adding one leaves the draws of the others as
//! they are.

use std::path::{Path, PathBuf};

use evpose_core::{CounterRng, seed_for};
use evpose_sensor::{EffectConfig, SensorError};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::SimError;
use crate::config::SensorChoice;

/// The ranges that the program holds, `configs/randomisation.toml`.
const BUILT_IN: &str = evpose_configs::text("randomisation.toml");
/// Name of those ranges in configurations.
const BUILT_IN_NAME: &str = "wide";
/// Name of the field that holds the sensor.
const SENSOR: &str = "sensor";

/// A configuration whose fields can be randomised.
pub trait Randomised: Clone + Serialize + DeserializeOwned {
    /// The tables of the file that apply to it, beside those of every task.
    const TASK: RandomisedTask;

    /// Sensor model that randomisation may replace.
    fn sensor_mut(&mut self) -> &mut SensorChoice;
}

/// A task whose configurations can be randomised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RandomisedTask {
    /// Hands.
    Hand,
    /// Bodies.
    Body,
}

/// The fields that are drawn for every recording, and their ranges.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Randomisation {
    #[serde(rename = "vary", default)]
    variations: Vec<Variation>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Variation {
    field: String,
    /// The task whose configurations have it; none for all.
    task: Option<RandomisedTask>,
    /// Both ends of a number.
    range: Option<[f64; 2]>,
    /// Whether equal steps are equal differences or equal ratios.
    #[serde(default)]
    scale: VariationScale,
    /// Field that the drawn value is multiplied by.
    times: Option<String>,
    /// The values to choose from, each as often as it is listed.
    one_of: Option<Vec<Value>>,
    /// Probability with which the field is drawn; otherwise it stays as configured.
    #[serde(default = "always")]
    probability: f32,
    /// Whether the field is drawn only where the sensor has the effect: for its further parameters.
    #[serde(default)]
    only_if_listed: bool,
    reason: String,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum VariationScale {
    #[default]
    Linear,
    Log,
}

fn always() -> f32 {
    1.0
}

/// Defect of an entry, or of its place in a configuration.
#[derive(Debug, thiserror::Error)]
enum VariationError {
    #[error("[{0}, {1}] is no range on its scale")]
    Range(f64, f64),
    #[error("`range` or a list `one_of` is expected, not both")]
    Choice,
    #[error("a probability of {0}")]
    Probability(f32),
    #[error("a range needs its reason")]
    Reason,
    #[error("only a number can be a multiple")]
    Multiple,
    #[error("`{0}` is no EFFECT.PARAMETER")]
    EffectPath(String),
    #[error("{0} is no parameter of a sensor")]
    SensorValue(Value),
    #[error("`{0}` is no number of this sensor")]
    SensorNumber(String),
    #[error("there is no `{0}`")]
    NoField(String),
    #[error("`{0}` is no number")]
    NoNumber(String),
    #[error(transparent)]
    Sensor(#[from] SensorError),
    #[error(transparent)]
    Write(#[from] toml::ser::Error),
    #[error("{}", .0.message())]
    Read(#[from] toml::de::Error),
}

impl Randomisation {
    /// The ranges called `name`: `wide` for those of the program, or the path of a TOML file.
    ///
    /// # Errors
    /// If the file cannot be read, or an entry has no range that makes sense.
    pub fn named(name: &str) -> Result<Self, SimError> {
        if name == BUILT_IN_NAME {
            return Self::parse(BUILT_IN, Path::new(BUILT_IN_NAME));
        }
        let path = PathBuf::from(name);
        let text = std::fs::read_to_string(&path).map_err(|source| {
            SimError::file(&path, "read the ranges of a randomisation", source)
        })?;
        Self::parse(&text, &path)
    }

    fn parse(text: &str, path: &Path) -> Result<Self, SimError> {
        let wrong = |reason: String| SimError::Randomisation { path: path.to_owned(), reason };
        let read: Self = toml::from_str(text).map_err(|error| wrong(error.to_string()))?;
        for variation in &read.variations {
            variation.check().map_err(|reason| wrong(format!("{}: {reason}", variation.field)))?;
        }
        Ok(read)
    }

    /// The configuration of recording `index`: `base` with every listed field drawn.
    ///
    /// # Errors
    /// If `base` lacks a field, or a drawn value does not fit it.
    pub fn draw<C: Randomised>(&self, base: &C, seed: u64, index: u64) -> Result<C, SimError> {
        let mut config = base.clone();
        for variation in &self.variations {
            // One list serves all tasks: fields of another are not in this configuration.
            if variation.task.is_some_and(|task| task != C::TASK) {
                continue;
            }
            // A stream for each field: adding one to the list leaves the draws of the others.
            let mut rng =
                CounterRng::new(seed_for(seed, "randomisation", 0), &variation.field, index);
            if rng.chance(variation.probability) && variation.applies(&mut config) {
                variation.apply(&mut config, &mut rng).map_err(|reason| {
                    let field = &variation.field;
                    SimError::Randomisation {
                        path: PathBuf::from("randomisation"),
                        reason: format!("{field}: {reason}"),
                    }
                })?;
            }
        }
        Ok(config)
    }

    /// Field and reason of every entry for a task, in the order of the file.
    pub fn reasons(&self, task: RandomisedTask) -> impl Iterator<Item = (&str, &str)> {
        let applies = move |variation: &&Variation| variation.task.is_none_or(|own| own == task);
        self.variations.iter().filter(applies).map(|one| (&*one.field, &*one.reason))
    }
}

impl Variation {
    fn check(&self) -> Result<(), VariationError> {
        match (&self.range, &self.one_of) {
            (Some([low, high]), None) => {
                let is_range = low.is_finite() && high.is_finite() && low <= high;
                if !is_range || (self.scale == VariationScale::Log && *low <= 0.0) {
                    return Err(VariationError::Range(*low, *high));
                }
            }
            (None, Some(values)) if !values.is_empty() => {}
            _ => return Err(VariationError::Choice),
        }
        if !(0.0..=1.0).contains(&self.probability) {
            return Err(VariationError::Probability(self.probability));
        }
        // A range without its source could not be distinguished from an invented one.
        if self.reason.trim().is_empty() {
            return Err(VariationError::Reason);
        }
        Ok(())
    }

    /// Whether the field is there, if it must be.
    fn applies<C: Randomised>(&self, config: &mut C) -> bool {
        let effect = self.field.split('.').nth(1).unwrap_or_default();
        !self.only_if_listed
            || config.sensor_mut().resolve().is_ok_and(|chain| chain.effect(effect).is_some())
    }

    /// The drawn value, before it is multiplied by another field.
    fn value(&self, rng: &mut CounterRng) -> Value {
        if let Some(values) = &self.one_of {
            return values[rng.below(values.len())].clone();
        }
        let [low, high] = self.range.unwrap_or_default();
        let share = f64::from(rng.unit());
        Value::Float(match self.scale {
            VariationScale::Linear => low + (high - low) * share,
            VariationScale::Log => low * (high / low).powf(share),
        })
    }

    fn apply<C: Randomised>(
        &self,
        config: &mut C,
        rng: &mut CounterRng,
    ) -> Result<(), VariationError> {
        let mut value = self.value(rng);
        if let Some(other) = &self.times {
            let factor = number_at(config, other)?;
            let own = value.as_float().ok_or(VariationError::Multiple)?;
            value = Value::Float(own * factor);
        }
        match self.field.strip_prefix(SENSOR).map(|rest| rest.strip_prefix('.')) {
            Some(Some(path)) => set_effect(config.sensor_mut(), path, &value),
            _ => set_field(config, &self.field, value),
        }
    }
}

fn effect_and_parameter(path: &str) -> Result<(&str, &str), VariationError> {
    path.split_once('.').ok_or_else(|| VariationError::EffectPath(path.to_owned()))
}

/// Sets a parameter of a sensor's effect, which is added if there is none.
fn set_effect(sensor: &mut SensorChoice, path: &str, value: &Value) -> Result<(), VariationError> {
    let (name, key) = effect_and_parameter(path)?;
    let mut chain = sensor.resolve()?;
    // The new effect has its neutral values but for the parameter that is set.
    if chain.effect(name).is_none() {
        chain.effects.push(EffectConfig::new(name));
    }
    match value {
        Value::String(word) => chain.set(name, key, word.as_str()),
        Value::Float(number) => chain.set(name, key, *number),
        Value::Integer(number) => chain.set(name, key, *number as f64),
        other => return Err(VariationError::SensorValue(other.clone())),
    }?;
    *sensor = SensorChoice::Chain(chain);
    Ok(())
}

fn number_at<C: Randomised>(config: &mut C, path: &str) -> Result<f64, VariationError> {
    if let Some(path) = path.strip_prefix(SENSOR).and_then(|rest| rest.strip_prefix('.')) {
        let (name, key) = effect_and_parameter(path)?;
        let chain = config.sensor_mut().resolve()?;
        let known = chain.effect(name).and_then(|effect| effect.number(key));
        return known.ok_or_else(|| VariationError::SensorNumber(path.to_owned()));
    }
    // Through TOML, so that paths are those that users write, for any configuration.
    let table = Table::try_from(&*config)?;
    let mut value = &Value::Table(table);
    for key in path.split('.') {
        value = value.get(key).ok_or_else(|| VariationError::NoField(path.to_owned()))?;
    }
    value
        .as_float()
        .or_else(|| value.as_integer().map(|whole| whole as f64))
        .ok_or_else(|| VariationError::NoNumber(path.to_owned()))
}

fn set_field<C: Randomised>(
    config: &mut C,
    path: &str,
    value: Value,
) -> Result<(), VariationError> {
    let mut root = Value::try_from(&*config)?;
    let mut at = &mut root;
    for key in path.split('.') {
        at = match key.parse::<usize>() {
            Ok(index) => at.get_mut(index),
            Err(_) => at.get_mut(key),
        }
        .ok_or_else(|| VariationError::NoField(path.to_owned()))?;
    }
    *at = match (&*at, value) {
        // Ranges are drawn as fractions; a count stays one.
        (Value::Integer(_), Value::Float(number)) => Value::Integer(number.round() as i64),
        (_, value) => value,
    };
    *config = root.try_into()?;
    Ok(())
}

#[cfg(test)]
mod tests;

//! A sensor as written down: a list of effects with their parameters.
//!
//! ```toml
//! [[effect]]
//! name = "level_crossing"
//! threshold_on = 0.2
//! threshold_off = 0.25
//! ```
//!
//! The registry places an effect in its domain; within a domain the order of the list counts. A
//! parameter that is left out takes its neutral value.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::effect::{EffectConfig, Value};
use crate::optics::adaptive_steps;
use crate::{Parameter, STAGES, SensorError};

/// A list of effects, unchecked until
/// [`SensorModel::from_config`](crate::SensorModel::from_config).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorConfig {
    /// The effects, in the order in which the signal meets them within a domain.
    #[serde(rename = "effect", default)]
    pub effects: Vec<EffectConfig>,
}

impl SensorConfig {
    /// Reads the TOML form.
    ///
    /// # Errors
    /// If the text is not a list of effects. Names and parameters are checked when the chain is
    /// built.
    pub fn from_toml(text: &str) -> Result<Self, SensorError> {
        Ok(toml::from_str(text)?)
    }

    /// Writes the TOML form, which reads back equal.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("strings, floats and tables have a TOML form")
    }

    /// Adds an effect before those of its domain that come later in the registry: stamps are rounded
    /// when nothing delays them any more.
    pub fn insert(&mut self, effect: EffectConfig) {
        let place = |name: &str| STAGES.iter().position(|spec| spec.name == name);
        let own = place(&effect.name);
        let is_later = |other: &EffectConfig| match (own, place(&other.name)) {
            (Some(own), Some(other)) => own < other && STAGES[own].domain == STAGES[other].domain,
            _ => false,
        };
        let before = self.effects.iter().position(is_later).unwrap_or(self.effects.len());
        self.effects.insert(before, effect);
    }

    /// The same with every relative path of a file taken to begin at `folder`.
    #[must_use]
    pub fn relative_to(mut self, folder: &Path) -> Self {
        for effect in &mut self.effects {
            let spec = STAGES.iter().find(|spec| spec.name == effect.name);
            // An unknown effect is refused when the model is built, with suggestions.
            let params = spec.map_or(&[][..], |spec| spec.params);
            for file in params.iter().filter_map(Parameter::as_file) {
                if let Some(Value::Word(path)) = effect.params.get_mut(file.name) {
                    *path = folder.join(&*path).to_string_lossy().into_owned();
                }
            }
        }
        self
    }

    /// Makes the sensor divide its steps into up to `parts` parts, or more if it does so already.
    pub fn divide_steps(&mut self, parts: f64) {
        let (name, key) = (adaptive_steps::SPEC.name, adaptive_steps::MAX_PARTS.name());
        let known = self.effect(name).and_then(|effect| effect.number(key));
        self.effects.retain(|effect| effect.name != name);
        let parts = parts.max(known.unwrap_or(1.0));
        self.effects.push(EffectConfig::new(name).with(key, parts));
    }

    /// The effect called `name`, if it is listed.
    pub fn effect(&self, name: &str) -> Option<&EffectConfig> {
        self.effects.iter().find(|effect| effect.name == name)
    }

    /// Changes one parameter of a listed effect.
    ///
    /// # Errors
    /// If the effect is not listed.
    pub fn set(
        &mut self,
        effect: &str,
        key: &str,
        value: impl Into<Value>,
    ) -> Result<(), SensorError> {
        let Some(found) = self.effects.iter_mut().find(|listed| listed.name == effect) else {
            return Err(SensorError::EffectNotListed {
                effect: effect.to_owned(),
                listed: self.effects.iter().map(|listed| listed.name.clone()).collect(),
            });
        };
        found.params.insert(key.to_owned(), value.into());
        Ok(())
    }
}

impl Default for SensorConfig {
    /// The ideal sensor, equal to the preset `ideal`.
    fn default() -> Self {
        Self {
            effects: vec![
                EffectConfig::new("logarithmic").with("dark_offset", 1e-3),
                EffectConfig::new("level_crossing")
                    .with("threshold_on", 0.2)
                    .with("threshold_off", 0.2),
                EffectConfig::new("ideal_readout"),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_infinities_and_words_are_read() {
        let config = SensorConfig::from_toml(
            "[[effect]]\nname = \"quantisation\"\nlevels = 255\n\
             [[effect]]\nname = \"a\"\nb = inf\nc = \"cold\"\n",
        )
        .unwrap();
        assert_eq!(config.effects[0], EffectConfig::new("quantisation").with("levels", 255.0));
        let other = EffectConfig::new("a").with("b", f64::INFINITY).with("c", "cold");
        assert_eq!(config.effects[1], other);
        assert_eq!(SensorConfig::from_toml(&config.to_toml()).unwrap(), config);
    }

    #[test]
    fn what_is_no_effect_is_refused() {
        for text in ["effects = []", "[[effect]]\nlevels = 3", "[[effect]]\nname = 'a'\nb = [1]"] {
            assert!(matches!(SensorConfig::from_toml(text), Err(SensorError::Toml(_))), "{text}");
        }
    }

    #[test]
    fn paths_of_files_begin_at_the_folder_and_other_words_stay() {
        let pattern = EffectConfig::new("fixed_pattern").with("threshold_on", "on.npy");
        let pattern = pattern.with("threshold_off", "/off.npy");
        let effects = vec![pattern, EffectConfig::new("refractory").with("mode", "drop")];
        let config = SensorConfig { effects }.relative_to(Path::new("/cameras/mine"));
        let word = |effect: usize, key: &str| config.effects[effect].params[key].clone();
        assert_eq!(word(0, "threshold_on"), Value::from("/cameras/mine/on.npy"));
        assert_eq!(word(0, "threshold_off"), Value::from("/off.npy"));
        assert_eq!(word(1, "mode"), Value::from("drop"));
    }

    #[test]
    fn steps_are_divided_once_and_never_less_than_before() {
        let mut config = SensorConfig::default();
        for (parts, divided) in [(4.0, 4.0), (2.0, 4.0), (8.0, 8.0)] {
            config.divide_steps(parts);
            let steps = config.effects.iter().filter_map(|effect| effect.number("max_parts"));
            assert_eq!(steps.collect::<Vec<_>>(), [divided]);
        }
    }

    #[test]
    fn only_a_listed_effect_can_be_changed() {
        let mut config = SensorConfig::default();
        config.set("level_crossing", "threshold_on", 0.3).unwrap();
        let changed = config.effect("level_crossing").unwrap();
        assert_eq!(changed.params["threshold_on"], Value::Number(0.3));
        assert!(matches!(
            config.set("uniform_noise", "on_hz", 1.0),
            Err(SensorError::EffectNotListed { .. })
        ));
    }
}

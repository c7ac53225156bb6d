//! Conditions under which a trained network is evaluated: slow hands, little light.
//!
//! A condition is a piece of TOML that changes an experiment: how its held-out sequences are
//! simulated, and how poses are estimated from them. What is trained stays as it is. Its first
//! comment says what it is.
//!
//! A new condition is a file in `configs/condition` and a line in [`CONDITIONS`]; a file of the
//! user's works the same way.

use std::path::Path;

use crate::TrainError;
use evpose_core::{Registry, registry_entry};
use evpose_task::Experiment as _;
use evpose_task::hand::HandConfig;

/// Sections a condition may change.
const SECTIONS: [&str; 3] = ["simulation", "filter", "slow_motion"];
/// Values that are one thing and are replaced as a whole, whatever they hold.
const WHOLE: [&str; 2] = ["sensor", "source"];

/// A changed experiment, by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Condition {
    /// Name in tables and directories.
    pub name: String,
    /// The changes, with a comment at the head that says what they make.
    pub toml: String,
}

/// A condition that no file of the user's holds.
#[derive(Debug)]
pub struct ConditionEntry {
    /// See [`Condition::name`].
    pub name: &'static str,
    /// See [`Condition::toml`].
    pub toml: &'static str,
}

registry_entry!(ConditionEntry, "condition");

macro_rules! condition {
    ($name:literal) => {{
        const TOML: &str = evpose_configs::text(concat!("condition/", $name, ".toml"));
        &ConditionEntry { name: $name, toml: TOML }
    }};
}

/// The conditions that come with the program, then those that other crates register.
pub static CONDITIONS: Registry<ConditionEntry> = Registry::new(&[
    condition!("normal"),
    condition!("slow"),
    condition!("lit"),
    condition!("dark"),
    condition!("night"),
    condition!("dark-noisy"),
]);

impl Condition {
    /// The condition called `source`, or else the TOML file of that path, named after it.
    ///
    /// # Errors
    /// If it is neither; the message lists the names there are.
    pub fn load(source: &str) -> Result<Self, TrainError> {
        if let Some(known) = CONDITIONS.find(source) {
            return Ok(Self { name: known.name.to_owned(), toml: known.toml.to_owned() });
        }
        let path = Path::new(source);
        match std::fs::read_to_string(path) {
            Ok(toml) => {
                let stem = path.file_stem().unwrap_or_default().to_string_lossy();
                Ok(Self { name: stem.into_owned(), toml })
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                let names = CONDITIONS.names().join(", ");
                let message = format!("no such condition (there are {names}) or file");
                Err(TrainError::Config { path: path.to_path_buf(), message })
            }
            Err(source) => Err(TrainError::Io { path: path.to_path_buf(), source }),
        }
    }

    /// The description: the first paragraph of the comment at its head.
    pub fn about(&self) -> String {
        let head = self.toml.lines().map_while(|line| line.strip_prefix('#'));
        let words: Vec<&str> = head
            .take_while(|line| !line.trim().is_empty())
            .flat_map(str::split_whitespace)
            .collect();
        words.join(" ")
    }

    /// `config` under this condition.
    ///
    /// # Errors
    /// If it changes what was trained, has unknown fields or values that make no sense.
    pub fn apply(&self, config: &HandConfig) -> Result<HandConfig, TrainError> {
        let problem = |message: String| TrainError::Config { path: (&*self.name).into(), message };
        let changes: toml::Table =
            toml::from_str(&self.toml).map_err(|error| problem(error.to_string()))?;
        if let Some(section) = changes.keys().find(|key| !SECTIONS.contains(&key.as_str())) {
            return Err(problem(format!(
                "`{section}` belongs to the training: a condition may change {}",
                SECTIONS.join(", ")
            )));
        }
        let mut table: toml::Table =
            toml::Table::try_from(config).map_err(|error| problem(error.to_string()))?;
        merge(&mut table, changes);
        let changed: HandConfig =
            table.try_into().map_err(|error: toml::de::Error| problem(error.to_string()))?;
        // After the merge, since values may contradict those that the condition leaves.
        changed.validate_simulation()?;
        let [before, after] = [config, &changed].map(|config| config.simulation.image_size());
        if before != after {
            return Err(problem(format!(
                "changes the image to {after}, but the network was trained for {before}"
            )));
        }
        Ok(changed)
    }
}

/// Sets every value of `changes` in `table`, going into sections that both have.
fn merge(table: &mut toml::Table, changes: toml::Table) {
    for (key, change) in changes {
        match (table.get_mut(&key), change) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(change))
                if !WHOLE.contains(&key.as_str()) =>
            {
                merge(inner, change);
            }
            (_, change) => {
                table.insert(key, change);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use evpose_sim::config::SensorChoice;

    use super::*;

    fn under(name: &str) -> HandConfig {
        Condition::load(name).unwrap().apply(&HandConfig::default()).unwrap()
    }

    fn written(toml: &'static str) -> Condition {
        Condition { name: "mine".into(), toml: toml.into() }
    }

    #[test]
    fn every_condition_says_what_it_is_and_makes_a_valid_experiment() {
        for name in CONDITIONS.names() {
            let condition = Condition::load(name).unwrap();
            assert!(condition.about().ends_with('.'), "{name}: {}", condition.about());
            condition.apply(&HandConfig::default()).unwrap();
        }
        assert_eq!(under("normal"), HandConfig::default());
    }

    #[test]
    fn slow_hands_differ_in_their_motion_alone() {
        let mut slow = under("slow");
        assert_eq!((slow.simulation.motion.period_s, slow.simulation.motion.pause_s), (10.0, 2.0));
        slow.simulation.motion = HandConfig::default().simulation.motion;
        assert_eq!(slow, HandConfig::default());
    }

    #[test]
    fn only_light_differs_between_lit_dark_and_night() {
        let lit = under("lit");
        assert_eq!(lit.simulation.light_level, 1.0);
        for (name, level) in [("dark", 0.01), ("night", 0.001)] {
            let mut dim = under(name);
            assert_eq!(dim.simulation.light_level, level);
            dim.simulation.light_level = 1.0;
            assert_eq!(dim, lit);
        }
    }

    #[test]
    fn the_noisy_camera_is_that_of_the_dark_but_for_its_shot_noise() {
        let (noisy, dark) = (under("dark-noisy"), under("dark"));
        assert_eq!(noisy.simulation.light_level, dark.simulation.light_level);
        let mut sensor = noisy.simulation.sensor.resolve().unwrap();
        let usual = dark.simulation.sensor.resolve().unwrap();
        assert_eq!(sensor.effect("shot_noise_poisson").unwrap().number("rate_hz"), Some(5.0));
        let rate_hz = usual.effect("shot_noise_poisson").unwrap().number("rate_hz").unwrap();
        sensor.set("shot_noise_poisson", "rate_hz", rate_hz).unwrap();
        assert_eq!(sensor, usual);
    }

    #[test]
    fn one_thing_is_replaced_and_sections_are_gone_into() {
        let changes = "[simulation]\nbackgrounds.source = { folder = \"images\" }\n\
                       [[simulation.sensor.effect]]\nname = \"level_crossing\"\n\
                       threshold_on = 0.3\nthreshold_off = 0.3\n\
                       [slow_motion.stillness]\nrest_sum = 200.0\n";
        let changed = written(changes).apply(&HandConfig::default()).unwrap();
        assert!(matches!(changed.simulation.sensor, SensorChoice::Chain(_)));
        assert_eq!(changed.simulation.backgrounds.scale, 1.3);
        assert_eq!(changed.slow_motion.stillness.rest_sum, 200.0);
        assert_eq!(changed.slow_motion.batch_inputs, 16);
    }

    #[test]
    fn what_was_trained_is_not_changed_and_what_is_unknown_is_named() {
        let complaint = |toml| written(toml).apply(&HandConfig::default()).unwrap_err().to_string();
        assert!(complaint("[network]\nwidth = 2.0").contains("`network`"));
        assert!(complaint("[simulation]\nimage_scale = 0.5").contains("120x90"));
        assert!(complaint("[simulation]\nlight_levl = 0.5").contains("light_levl"));
        assert!(complaint("[simulation]\nlight_level = -1.0").contains("light_level"));
        let message = Condition::load("foggy").unwrap_err().to_string();
        assert!(message.contains("foggy") && message.contains("dark-noisy"), "{message}");
    }
}

//! A catalogue of effects: those of the registry, or those and others of the caller.

use std::fmt;

use crate::{EffectConfig, STAGES, SensorConfig, SensorError, SensorModel, StageSpec};

/// The effects that names in configurations stand for: by default all of [`STAGES`]. A
/// catalogue with others as well is made once, and copied freely.
#[derive(Clone, Copy)]
pub struct Catalogue {
    stages: &'static [&'static StageSpec],
}

impl Catalogue {
    /// The registered effects and `own`, in the order of the signal as far as that is known: own
    /// effects come last. It is kept for the rest of the program.
    pub fn with_own(own: &[&'static StageSpec]) -> Self {
        let stages: Vec<&'static StageSpec> = STAGES.iter().chain(own).copied().collect();
        Self { stages: Vec::leak(stages) }
    }

    /// All effects.
    pub fn stages(self) -> &'static [&'static StageSpec] {
        self.stages
    }

    /// The effect called `name`.
    pub fn find(self, name: &str) -> Option<&'static StageSpec> {
        self.stages.iter().find(|spec| spec.name == name).copied()
    }

    /// Adds an effect to a configuration, before those of its domain that come later in the
    /// catalogue: stamps are rounded when nothing delays them any more.
    pub fn insert(self, config: &mut SensorConfig, effect: EffectConfig) {
        let place = |name: &str| self.stages.iter().position(|spec| spec.name == name);
        let own = place(&effect.name);
        let is_later = |other: &EffectConfig| match (own, place(&other.name)) {
            (Some(own), Some(other)) => {
                own < other && self.stages[own].domain == self.stages[other].domain
            }
            _ => false,
        };
        let before = config.effects.iter().position(is_later).unwrap_or(config.effects.len());
        config.effects.insert(before, effect);
    }

    /// Builds the chain of a configuration whose names are those of this catalogue.
    ///
    /// # Errors
    /// As [`SensorModel::from_config`].
    pub fn model(self, config: &SensorConfig) -> Result<SensorModel, SensorError> {
        SensorModel::from_config_in(self.stages, config)
    }
}

impl fmt::Debug for Catalogue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Catalogue of {} effects", self.stages.len())
    }
}

impl Default for Catalogue {
    fn default() -> Self {
        Self { stages: STAGES.entries() }
    }
}

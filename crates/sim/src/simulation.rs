//! A run: the state shared by all its sequences.

use std::sync::Arc;

use evpose_body::BodyModel;
use evpose_core::seed_for;
use evpose_pose::HandSide;

use crate::actor::Actor;
use crate::config::SimulationConfig;
use crate::randomisation::Randomisation;
use crate::texture::{ImagePool, Skins};
use crate::{SimError, Simulator};

/// A validated configuration with body, background images and sensor loaded. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Simulation {
    pub(crate) shared: Arc<Shared>,
}

#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) config: SimulationConfig,
    pub(crate) seed: u64,
    pub(crate) actor: Actor,
    pub(crate) backgrounds: ImagePool,
    pub(crate) skins: Skins,
    pub(crate) randomisation: Option<Randomisation>,
}

impl Simulation {
    /// Prepares a run with the configured body. Sequences, people, surroundings and noise follow
    /// from `seed`.
    ///
    /// # Errors
    /// As [`SimulationConfig::validate`]; unreadable models, skins and background images.
    pub fn new(config: &SimulationConfig, seed: u64) -> Result<Self, SimError> {
        config.validate()?;
        Self::with_actor(config, seed, Actor::load(&config.body, &config.camera)?)
    }

    /// Prepares a run with the caller's body, of which the right hand is estimated.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_body(
        config: &SimulationConfig,
        seed: u64,
        body: BodyModel,
    ) -> Result<Self, SimError> {
        config.validate()?;
        let placement = config.camera.placement();
        Self::with_actor(config, seed, Actor::new(body, HandSide::Right, &placement))
    }

    fn with_actor(config: &SimulationConfig, seed: u64, actor: Actor) -> Result<Self, SimError> {
        let shared = Shared {
            config: config.clone(),
            seed,
            actor,
            backgrounds: ImagePool::new(
                &config.backgrounds.source,
                seed_for(seed, "background pool", 0),
            )?,
            skins: Skins::new(&config.skin.source)?,
            randomisation: config.randomisation.as_deref().map(Randomisation::named).transpose()?,
        };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// Starts sequence `index`, before its first frame.
    ///
    /// # Errors
    /// If the sensor's thresholds, varied, are out of its range.
    pub fn sequence(&self, index: u64) -> Result<Simulator, SimError> {
        Simulator::of_sequence(Arc::clone(&self.shared), index)
    }

    /// Configuration of the simulation.
    pub fn config(&self) -> &SimulationConfig {
        &self.shared.config
    }

    /// The simulated hand model, which also places predicted hands.
    pub fn actor(&self) -> &Actor {
        &self.shared.actor
    }
}

impl Shared {
    /// The configuration of sequence `index`: that of the run, randomised if it says so.
    pub(crate) fn config_of(&self, index: u64) -> Result<SimulationConfig, SimError> {
        let Some(ranges) = &self.randomisation else { return Ok(self.config.clone()) };
        let config = ranges.draw(&self.config, self.seed, index)?;
        config.validate()?;
        Ok(config)
    }
}

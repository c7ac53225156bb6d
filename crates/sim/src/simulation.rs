//! What all sequences of a run share.

use std::sync::Arc;

use evpose_body::BodyModel;
use evpose_core::seed_for;
use evpose_sensor::{SensorConfig, SensorModel, Value};

use crate::config::SimulationConfig;
use crate::raster::is_closed;
use crate::texture::PicturePool;
use crate::{SimError, Simulator};

/// A checked configuration with body, pictures and sensor at hand. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Simulation {
    pub(crate) shared: Arc<Shared>,
}

#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) config: SimulationConfig,
    pub(crate) seed: u64,
    pub(crate) body: BodyModel,
    /// Whether the body's faces bound a solid.
    pub(crate) closed: bool,
    pub(crate) pictures: PicturePool,
    pub(crate) sensor: SensorConfig,
}

impl Simulation {
    /// Prepares a run with the procedural arm. Sequences, people, surroundings and noise follow
    /// from `seed`.
    ///
    /// # Errors
    /// What [`SimulationConfig::validate`] finds, and unreadable background pictures.
    pub fn new(config: &SimulationConfig, seed: u64) -> Result<Self, SimError> {
        Self::with_body(config, seed, BodyModel::procedural_arm())
    }

    /// Prepares a run with a body of the caller's.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_body(
        config: &SimulationConfig,
        seed: u64,
        body: BodyModel,
    ) -> Result<Self, SimError> {
        config.validate()?;
        let shared = Shared {
            config: config.clone(),
            seed,
            closed: is_closed(&body.faces),
            body,
            pictures: PicturePool::new(
                &config.backgrounds.source,
                seed_for(seed, "background pool", 0),
            )?,
            sensor: config.sensor.resolve()?,
        };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// Sequence number `index`, before its first frame.
    ///
    /// # Errors
    /// If the sensor's thresholds, varied, are out of its range.
    pub fn sequence(&self, index: u64) -> Result<Simulator, SimError> {
        Simulator::of_sequence(Arc::clone(&self.shared), index)
    }

    /// The configuration.
    pub fn config(&self) -> &SimulationConfig {
        &self.shared.config
    }

    /// The body that is simulated, to place predicted hands with.
    pub fn body(&self) -> &BodyModel {
        &self.shared.body
    }
}

impl Shared {
    /// The sensor with `offset` added to every contrast threshold.
    pub(crate) fn sensor_model(&self, offset: f64) -> Result<SensorModel, SimError> {
        let mut config = self.sensor.clone();
        for effect in &mut config.effects {
            for (key, value) in &mut effect.params {
                if let ("threshold_on" | "threshold_off", Value::Number(threshold)) =
                    (key.as_str(), value)
                {
                    *threshold += offset;
                }
            }
        }
        Ok(SensorModel::from_config(&config)?)
    }
}

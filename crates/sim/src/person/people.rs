//! A run of people: the state shared by all its sequences.

use std::sync::Arc;

use evpose_body::BodyModel;
use evpose_body::files::ModelFile;
use evpose_core::{Micros, Plane, seed_for};

use super::config::PeopleConfig;
use super::luminance_image::LuminancePool;
use super::shared::Shared;
use super::still::{Still, photographs, still};
use super::{PersonSimulator, PersonStep};
use crate::SimError;
use crate::config::BodySource;
use crate::raster::is_closed;
use crate::texture::{ImagePool, metres_per_texture};

/// A validated configuration with body, background images and sensor loaded. Cheap to clone.
#[derive(Debug, Clone)]
pub struct People {
    pub(super) shared: Arc<Shared>,
}

impl People {
    /// Prepares a run. People, activities, surroundings and noise are functions of `seed`.
    ///
    /// # Errors
    /// As [`PeopleConfig::validate`]; unreadable models and background images.
    pub fn new(config: &PeopleConfig, seed: u64) -> Result<Self, SimError> {
        config.validate()?;
        let body = match &config.body {
            BodySource::Procedural => BodyModel::procedural_human(),
            BodySource::File(path) => {
                let model = ModelFile::read(path)?.model;
                if model.parents.len() != evpose_body::skeleton::JOINTS {
                    return Err(SimError::NotABody { path: path.clone() });
                }
                model
            }
        };
        let pool = seed_for(seed, "people background pool", 0);
        let shared = Shared {
            seed,
            is_closed: is_closed(&body.faces),
            metres_per_texture: metres_per_texture(&body.template_m, &body.uvs, &body.faces),
            images: LuminancePool::new(
                ImagePool::new(&config.surroundings.source, pool)?,
                config.surroundings.gamma,
            ),
            sensor: config.sensor.resolve()?,
            body,
            config: config.clone(),
        };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// Starts sequence `index`, before its first step.
    ///
    /// # Errors
    /// If the sensor's thresholds, varied, are out of their range.
    pub fn sequence(&self, index: u64) -> Result<PersonSimulator, SimError> {
        PersonSimulator::new(Arc::clone(&self.shared), index)
    }

    /// Renders photograph `index`: a drawn person at a drawn time of an activity.
    pub fn still(&self, index: u64) -> Still {
        still(&self.shared, index)
    }

    /// Renders grey frames of a sequence at `times`, in their order.
    pub fn photographs(&self, sequence: u64, times: &[Micros]) -> Vec<Plane<u8>> {
        photographs(&self.shared, sequence, times)
    }

    /// The configuration.
    pub fn config(&self) -> &PeopleConfig {
        &self.shared.config
    }

    /// Passes the steps of a sequence to `visit`, one after another, until it fails.
    ///
    /// # Errors
    /// As [`PersonSimulator::advance`], and those of `visit`.
    pub fn play<E: From<SimError>>(
        &self,
        index: u64,
        mut visit: impl FnMut(&PersonStep<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut simulator = self.sequence(index)?;
        for _ in 0..self.shared.config.steps() {
            visit(&simulator.advance()?)?;
        }
        Ok(())
    }
}

//! What all sequences of people share.

use std::sync::Arc;

use evpose_body::files::ModelFile;
use evpose_body::{BodyModel, ShapedBody};
use evpose_core::{Micros, Plane, seed_for};
use evpose_sensor::{SensorConfig, SensorModel};
use glam::Vec2;

use super::config::PeopleConfig;
use super::still::{Still, photographs, still};
use super::wall::Pictures;
use super::{PersonSimulator, PersonStep};
use crate::SimError;
use crate::config::{BodySource, with_thresholds_moved};
use crate::raster::is_closed;
use crate::texture::{PicturePool, metres_per_texture};

/// A checked configuration with body, pictures and sensor at hand. Cheap to clone.
#[derive(Debug, Clone)]
pub struct People {
    pub(super) shared: Arc<Shared>,
}

#[derive(Debug)]
pub(super) struct Shared {
    pub(super) config: PeopleConfig,
    pub(super) seed: u64,
    pub(super) body: BodyModel,
    pub(super) is_closed: bool,
    pub(super) metres_per_texture: Vec2,
    pub(super) pictures: Pictures,
    sensor: SensorConfig,
}

impl People {
    /// Prepares a run. People, what they do, surroundings and noise follow from `seed`.
    ///
    /// # Errors
    /// What [`PeopleConfig::validate`] finds, and unreadable models and background pictures.
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
            pictures: Pictures::new(
                PicturePool::new(&config.surroundings.source, pool)?,
                config.surroundings.gamma,
            ),
            sensor: config.sensor.resolve()?,
            body,
            config: config.clone(),
        };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// Sequence number `index`, before its first step.
    ///
    /// # Errors
    /// If the sensor's thresholds, varied, are out of their range.
    pub fn sequence(&self, index: u64) -> Result<PersonSimulator, SimError> {
        PersonSimulator::new(Arc::clone(&self.shared), index)
    }

    /// A photograph of somebody in the midst of what they do: number `index` of as many as one likes.
    pub fn still(&self, index: u64) -> Still {
        still(&self.shared, index)
    }

    /// What a camera of photographs sees of a sequence at these times, in their order.
    pub fn photographs(&self, sequence: u64, times: &[Micros]) -> Vec<Plane<u8>> {
        photographs(&self.shared, sequence, times)
    }

    /// The configuration.
    pub fn config(&self) -> &PeopleConfig {
        &self.shared.config
    }

    /// The steps of a sequence, one after another, until `seen` has had enough of them.
    ///
    /// # Errors
    /// As [`PersonSimulator::advance`], and what `seen` fails with.
    pub fn play<E: From<SimError>>(
        &self,
        index: u64,
        mut seen: impl FnMut(&PersonStep<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut simulator = self.sequence(index)?;
        for _ in 0..self.shared.config.steps() {
            seen(&simulator.advance()?)?;
        }
        Ok(())
    }
}

impl Shared {
    /// The sensor with `offset` added to every contrast threshold.
    pub(super) fn sensor_model(&self, offset: f64) -> Result<SensorModel, SimError> {
        Ok(with_thresholds_moved(&self.sensor, offset)?)
    }

    /// Height of somebody in the T-pose, in metres.
    pub(super) fn height_m(&self, shaped: &ShapedBody) -> f32 {
        let heights = shaped.vertices_m.iter().map(|vertex_m| vertex_m.y);
        let (low, high) = heights.fold((f32::MAX, f32::MIN), |(l, h), y| (l.min(y), h.max(y)));
        high - low
    }
}

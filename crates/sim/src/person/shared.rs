//! State shared by all sequences of a run of people.

use evpose_body::{BodyModel, ShapedBody};
use evpose_sensor::SensorModel;
use glam::Vec2;

use super::config::PeopleConfig;
use super::luminance_image::LuminancePool;
use crate::SimError;
use crate::config::with_threshold_offset;
use crate::randomisation::Randomisation;
use crate::raster::is_closed;
use crate::texture::metres_per_texture;

/// Configuration, bodies and background images of a run.
#[derive(Debug)]
pub(super) struct Shared {
    pub(super) config: PeopleConfig,
    pub(super) seed: u64,
    /// The bodies to choose from, at least one.
    pub(super) bodies: Vec<DressedBody>,
    pub(super) images: LuminancePool,
    pub(super) randomisation: Option<Randomisation>,
}

/// A body in one outfit.
#[derive(Debug)]
pub(super) struct DressedBody {
    pub(super) model: BodyModel,
    pub(super) is_closed: bool,
    pub(super) metres_per_texture: Vec2,
}

impl DressedBody {
    pub(super) fn new(model: BodyModel) -> Self {
        let (points_m, uvs, faces) = (&model.template_m, &model.uvs, &model.faces);
        Self {
            is_closed: is_closed(faces),
            metres_per_texture: metres_per_texture(points_m, uvs, faces),
            model,
        }
    }
}

impl Shared {
    /// The configuration of sequence `index` of the streams of `seed`: that of the run, randomised
    /// if it says so.
    pub(super) fn config_of(&self, seed: u64, index: u64) -> Result<PeopleConfig, SimError> {
        let Some(ranges) = &self.randomisation else { return Ok(self.config.clone()) };
        let config = ranges.draw(&self.config, seed, index)?;
        config.validate()?;
        Ok(config)
    }

    /// Height of a shaped body in the T-pose, in metres.
    pub(super) fn height_m(&self, shaped: &ShapedBody) -> f32 {
        let heights = shaped.vertices_m.iter().map(|vertex_m| vertex_m.y);
        let (low, high) = heights.fold((f32::MAX, f32::MIN), |(l, h), y| (l.min(y), h.max(y)));
        high - low
    }
}

/// The sensor of a configuration with `offset` added to every contrast threshold.
pub(super) fn sensor_model(config: &PeopleConfig, offset: f64) -> Result<SensorModel, SimError> {
    Ok(with_threshold_offset(&config.sensor.resolve()?, offset)?)
}

//! State shared by all sequences of a run of people.

use evpose_body::{BodyModel, ShapedBody};
use evpose_sensor::{SensorConfig, SensorModel};
use glam::Vec2;

use super::config::PeopleConfig;
use super::luminance_image::LuminancePool;
use crate::SimError;
use crate::config::with_threshold_offset;

/// Configuration, body model, background images and sensor of a run.
#[derive(Debug)]
pub(super) struct Shared {
    pub(super) config: PeopleConfig,
    pub(super) seed: u64,
    pub(super) body: BodyModel,
    pub(super) is_closed: bool,
    pub(super) metres_per_texture: Vec2,
    pub(super) images: LuminancePool,
    pub(super) sensor: SensorConfig,
}

impl Shared {
    /// The sensor with `offset` added to every contrast threshold.
    pub(super) fn sensor_model(&self, offset: f64) -> Result<SensorModel, SimError> {
        Ok(with_threshold_offset(&self.sensor, offset)?)
    }

    /// Height of a shaped body in the T-pose, in metres.
    pub(super) fn height_m(&self, shaped: &ShapedBody) -> f32 {
        let heights = shaped.vertices_m.iter().map(|vertex_m| vertex_m.y);
        let (low, high) = heights.fold((f32::MAX, f32::MIN), |(l, h), y| (l.min(y), h.max(y)));
        high - low
    }
}

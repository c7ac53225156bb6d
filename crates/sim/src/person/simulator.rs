//! One sequence, step by step: pose, rendering, labels, events.

use std::sync::Arc;
use std::time::Instant;

use evpose_core::{CounterRng, EventStream, Micros, PlacedCamera, Plane, SensorSize, seed_for};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_sensor::SensorRun;
use glam::Vec3;

use super::config::PeopleConfig;
use super::joints::BodyJoints3;
use super::scene_instance::SceneInstance;
use super::shared::Shared;
use crate::{RecordingTime, SimError};

pub(super) const SEQUENCE_STREAM: &str = "people sequence";

/// Simulator of one sequence of a person, advanced one step at a time.
#[derive(Debug)]
pub struct PersonSimulator {
    shared: Arc<Shared>,
    config: PeopleConfig,
    scene: SceneInstance,
    sensor: SensorRun,
    threshold_offset: f64,
    luminance: Plane<f32>,
    next: u64,
    time: RecordingTime,
}

/// One step of a sequence of a person.
#[derive(Debug, Clone, Copy)]
pub struct PersonStep<'a> {
    /// Index of the step, from 0.
    pub frame: u64,
    /// Time at its end, when the sensor was exposed. Step 0 is at time zero.
    pub t: Micros,
    /// Frame that the sensor was exposed to: linear luminance, relative to reference white.
    pub luminance: &'a Plane<f32>,
    /// Events of the step.
    pub events: &'a EventStream,
    /// Joints in the world, in metres, in the order of networks; NaN in an empty scene.
    pub joints_m: BodyJoints3,
    /// Joints on the image in pixels; none outside of it.
    pub joints_px: BodyPoints,
    /// Whether a label belongs to this step.
    pub is_labelled: bool,
}

impl PersonSimulator {
    pub(super) fn new(shared: Arc<Shared>, index: u64) -> Result<Self, SimError> {
        let seed = seed_for(shared.seed, SEQUENCE_STREAM, 0);
        let scene_and_camera = shared.config.scene_of(index);
        let config = shared.config_of(seed, scene_and_camera.0)?;
        let seconds = config.seconds as f32;
        let scene = SceneInstance::draw(&shared, &config, seed, scene_and_camera, seconds)?;
        // By sequence, not by scene: cameras of one scene differ as two of one make do.
        let normal = CounterRng::new(seed, "person threshold", index).normal();
        let threshold_offset = config.threshold_sd * f64::from(normal);
        let sensor = config
            .sensor
            .model(threshold_offset)?
            .start(config.sensor_size, seed_for(seed, "person sensor", index));
        let luminance = Plane::for_sensor(config.sensor_size, 0.0);
        let time = RecordingTime::default();
        Ok(Self { shared, config, scene, sensor, threshold_offset, luminance, next: 0, time })
    }

    /// Time of the steps so far.
    pub fn time(&self) -> RecordingTime {
        self.time
    }

    /// Simulates one step.
    ///
    /// # Errors
    /// If the sensor rejects a frame, which would be a bug.
    pub fn advance(&mut self) -> Result<PersonStep<'_>, SimError> {
        let begun = Instant::now();
        let (frame, config) = (self.next, &self.config);
        let t = Micros(frame as i64 * config.step().0);
        let light = self.scene.light(&self.shared, t.as_seconds() as f32);
        // Copied, since the scene paints over its own plane in the next step.
        self.luminance.clone_from(light);
        let lit = Instant::now();
        let events = self.sensor.expose(&self.luminance, t)?;
        self.time.rendering += lit - begun;
        self.time.sensor += lit.elapsed();
        self.next += 1;
        let joints_m = self.scene.joints_m();
        Ok(PersonStep {
            frame,
            t,
            luminance: &self.luminance,
            events,
            joints_px: self.scene.joints_px().unwrap_or_default(),
            joints_m: joints_m.unwrap_or([Vec3::NAN; BODY_JOINTS]),
            is_labelled: frame.is_multiple_of(config.steps_per_label()),
        })
    }

    /// Size of the image.
    pub fn sensor(&self) -> SensorSize {
        self.config.sensor_size
    }

    /// Name of the activity, or of the captured motion, such as `cmu 03_01`.
    pub fn activity(&self) -> &str {
        &self.scene.activity
    }

    /// The camera in the world of the labels; none if it moves.
    pub fn placed_camera(&self) -> Option<PlacedCamera> {
        self.scene.placed_camera()
    }

    /// Shape coefficients of the person.
    pub fn betas(&self) -> &[f32] {
        self.scene.betas()
    }

    /// Offset of the sensor's contrast thresholds, in natural-log intensity.
    pub fn threshold_offset(&self) -> f64 {
        self.threshold_offset
    }
}

//! One sequence, step by step: pose, picture, labels, events.

use std::sync::Arc;

use evpose_core::{CounterRng, EventStream, Micros, Plane, SensorSize, seed_for};
use evpose_pose::body::BodyPoints;
use evpose_sensor::SensorRun;

use super::joints::{BodyJoints3, joints_px};
use super::people::Shared;
use super::take::Take;
use crate::SimError;

/// What random numbers of sequences are drawn for.
pub(super) const SEQUENCES: &str = "people sequence";

/// Somebody before an event camera, advanced one step at a time.
#[derive(Debug)]
pub struct PersonSimulator {
    shared: Arc<Shared>,
    take: Take,
    sensor: SensorRun,
    threshold_offset: f64,
    luminance: Plane<f32>,
    next: u64,
}

/// One step of a sequence.
#[derive(Debug, Clone, Copy)]
pub struct PersonStep<'a> {
    /// Number of the step, from 0.
    pub frame: u64,
    /// Time at its end, when the sensor was exposed. Step 0 is at time zero.
    pub t: Micros,
    /// What the sensor was shown: linear luminance, relative to reference white.
    pub luminance: &'a Plane<f32>,
    /// What it answered.
    pub events: &'a EventStream,
    /// Joints in the world, in metres, in the order of networks.
    pub joints_m: BodyJoints3,
    /// Joints on the image; none outside of it.
    pub joints_px: BodyPoints,
    /// Whether a label belongs to this step.
    pub is_labelled: bool,
}

impl PersonSimulator {
    pub(super) fn new(shared: Arc<Shared>, index: u64) -> Result<Self, SimError> {
        let seed = seed_for(shared.seed, SEQUENCES, 0);
        let take = Take::draw(&shared, seed, index, shared.config.seconds as f32);
        let normal = CounterRng::new(seed, "person threshold", index).normal();
        let threshold_offset = shared.config.threshold_sd * f64::from(normal);
        let sensor = shared
            .sensor_model(threshold_offset)?
            .start(shared.config.sensor_size, seed_for(seed, "person sensor", index));
        let luminance = Plane::for_sensor(shared.config.sensor_size, 0.0);
        Ok(Self { shared, take, sensor, threshold_offset, luminance, next: 0 })
    }

    /// Simulates one step.
    ///
    /// # Errors
    /// If the sensor refuses a picture, which would be a fault of this program.
    pub fn advance(&mut self) -> Result<PersonStep<'_>, SimError> {
        let (frame, config) = (self.next, &self.shared.config);
        let t = Micros(frame as i64 * config.step().0);
        let light = self.take.light(&self.shared, t.as_seconds() as f32);
        self.luminance.clone_from(light);
        let events = self.sensor.expose(&self.luminance, t)?;
        self.next += 1;
        let joints_m = self.take.joints_m();
        Ok(PersonStep {
            frame,
            t,
            luminance: &self.luminance,
            events,
            joints_px: joints_px(&joints_m, self.take.camera()),
            joints_m,
            is_labelled: frame.is_multiple_of(config.steps_per_label()),
        })
    }

    /// Size of the image.
    pub fn sensor(&self) -> SensorSize {
        self.shared.config.sensor_size
    }

    /// What is done.
    pub fn activity(&self) -> &'static str {
        self.take.activity.name
    }

    /// Shape coefficients of the person.
    pub fn betas(&self) -> &[f32] {
        &self.take.betas
    }

    /// What was added to the sensor's contrast thresholds, in natural-log intensity.
    pub fn threshold_offset(&self) -> f64 {
        self.threshold_offset
    }
}

//! Interfaces of estimators: of a whole body, and of one joint.

use std::fmt;

use evpose_core::Micros;
use glam::DVec2;

use super::{FusionConfig, FusionError};
use crate::body::{BODY_JOINTS, BodyPoints};

/// Measurements of each joint: positions in px, or velocities in px/s.
pub(super) type Measured = [Option<DVec2>; BODY_JOINTS];

/// Estimates of the joints of a body.
pub(super) trait BodyEstimator: fmt::Debug + Send {
    /// Takes positions of time `described` that become known at `now`, not before.
    fn detection(
        &mut self,
        described: Micros,
        positions_px: &Measured,
        now: Micros,
    ) -> Result<(), FusionError>;

    /// Takes velocities of time `t`.
    fn velocity(&mut self, t: Micros, px_per_s: &Measured) -> Result<(), FusionError>;

    /// Joints at time `t`, in px.
    fn query(&self, t: Micros) -> BodyPoints;
}

/// An estimator of one joint, from measurements in order of time.
pub(super) trait JointFilter: fmt::Debug + Copy + Send + 'static {
    /// Whether hpe-core moves the clocks of all joints by a velocity, not of the first alone.
    const ALL_CLOCKS_MOVE: bool;

    /// The filter at the first detection.
    fn start(position_px: DVec2, config: &FusionConfig) -> Self;

    /// Lets time pass.
    fn advance(&mut self, dt_s: f64, config: &FusionConfig);

    /// Corrects the state by a detection.
    fn detect(&mut self, position_px: DVec2, config: &FusionConfig);

    /// Corrects the state by a velocity, `dt_s` after the measurement before.
    fn measure_velocity(&mut self, px_per_s: DVec2, dt_s: f64, config: &FusionConfig);

    /// Position of the joint `ahead_s` after the last measurement, px.
    fn position_px(&self, ahead_s: f64) -> DVec2;
}

/// A joint that is followed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Track<F> {
    pub(super) filter: F,
    /// The time of the state.
    pub(super) at: Micros,
    /// The time of the last detection, which may be before.
    pub(super) detected: Micros,
}

impl<F: JointFilter> Track<F> {
    /// At the first detection.
    pub(super) fn start(t: Micros, position_px: DVec2, config: &FusionConfig) -> Self {
        Self { filter: F::start(position_px, config), at: t, detected: t }
    }

    /// Whether the last detection is recent enough.
    pub(super) fn is_followed(&self, t: Micros, config: &FusionConfig) -> bool {
        seconds(self.detected, t) <= config.lost_after_s
    }

    /// To a later time; says how much later, seconds.
    pub(super) fn advance(&mut self, to: Micros, config: &FusionConfig) -> f64 {
        let dt_s = seconds(self.at, to);
        self.filter.advance(dt_s, config);
        self.at = to;
        dt_s
    }

    /// Moves the joint to where it is detected at the time of the state.
    pub(super) fn detect(&mut self, position_px: DVec2, config: &FusionConfig) {
        self.filter.detect(position_px, config);
        self.detected = self.at;
    }
}

/// Duration from one time to another, in seconds.
pub(super) fn seconds(from: Micros, to: Micros) -> f64 {
    to.0.saturating_sub(from.0) as f64 * 1e-6
}

/// A position in single precision, as joints are returned.
pub(super) fn pixels(position_px: DVec2) -> Option<glam::Vec2> {
    Some(position_px.as_vec2())
}

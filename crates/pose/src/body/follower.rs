//! A body followed between two detections of a network.

use evpose_core::{EventStream, Micros, SensorSize};
use glam::Vec2;

use super::BodyPoints;
use super::fusion::{BodyFusion, FusionConfig, ScoredPoints};
use super::velocity::{TripletVelocity, TripletVelocityConfig};
use crate::PoseError;

/// Propagates the joints that a network detects by the velocities measured from events.
#[derive(Debug)]
pub struct BodyFollower {
    velocities: TripletVelocity,
    fusion: BodyFusion,
    min_samples: u32,
}

impl BodyFollower {
    /// A follower before its first detection. A velocity from fewer than `min_samples` pixels is
    /// taken as zero.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn new(
        sensor: SensorSize,
        velocity: TripletVelocityConfig,
        fusion: &FusionConfig,
        min_samples: u32,
    ) -> Result<Self, PoseError> {
        Ok(Self {
            velocities: TripletVelocity::new(sensor, velocity)?,
            fusion: BodyFusion::new(fusion)?,
            min_samples,
        })
    }

    /// Takes further events, in time order.
    pub fn push(&mut self, events: &EventStream) {
        self.velocities.push(events);
    }

    /// Takes the detection for the input of time `described`, known at `now`. A detection older
    /// than the history is ignored.
    pub fn detection(&mut self, described: Micros, pose: &ScoredPoints, now: Micros) {
        // Too late for the history: the estimate stays as it is.
        let _ = self.fusion.detection(described, pose, now);
    }

    /// The joints at `t`, the time stamp of the last event; must not decrease between calls.
    pub fn at(&mut self, t: Micros) -> BodyPoints {
        let measured = self.velocities.query(&self.fusion.query(t));
        let min_samples = self.min_samples;
        let velocities = measured
            .map(|joint| if joint.samples < min_samples { Vec2::ZERO } else { joint.px_per_s });
        let _ = self.fusion.velocity(t, &velocities);
        self.fusion.query(t)
    }

    /// Forgets the detections, not the events.
    pub fn forget_detections(&mut self) {
        self.fusion.reset();
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.velocities.reset();
        self.fusion.reset();
    }
}

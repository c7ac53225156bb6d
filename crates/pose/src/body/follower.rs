//! A body between two answers of a network.

use evpose_core::{EventStream, Micros, SensorSize};
use glam::Vec2;

use super::BodyPoints;
use super::fusion::{BodyFusion, FusionConfig, ScoredPoints};
use super::velocity::{TripletVelocity, TripletVelocityConfig};
use crate::PoseError;

/// Carries the joints that a network found on by the velocities that events tell.
#[derive(Debug)]
pub struct BodyFollower {
    velocities: TripletVelocity,
    fusion: BodyFusion,
    fewest_samples: u32,
}

impl BodyFollower {
    /// Before the first answer. Fewer pixels than `fewest_samples` tell nothing of a joint's velocity: it
    /// rests.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn new(
        sensor: SensorSize,
        velocity: TripletVelocityConfig,
        fusion: &FusionConfig,
        fewest_samples: u32,
    ) -> Result<Self, PoseError> {
        Ok(Self {
            velocities: TripletVelocity::new(sensor, velocity)?,
            fusion: BodyFusion::new(fusion)?,
            fewest_samples,
        })
    }

    /// Takes events.
    pub fn push(&mut self, events: &EventStream) {
        self.velocities.push(events);
    }

    /// Takes what the network found of time `described`, known at `now`. What comes too late for what is
    /// remembered says nothing of now, and is left out.
    pub fn detection(&mut self, described: Micros, pose: &ScoredPoints, now: Micros) {
        let _ = self.fusion.detection(described, pose, now);
    }

    /// The joints at `t`, the time of the last event, which is not before the last time asked for.
    pub fn at(&mut self, t: Micros) -> BodyPoints {
        let told = self.velocities.query(&self.fusion.query(t));
        let fewest = self.fewest_samples;
        let moving =
            told.map(|joint| if joint.samples < fewest { Vec2::ZERO } else { joint.px_per_s });
        let _ = self.fusion.velocity(t, &moving);
        self.fusion.query(t)
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.velocities.reset();
        self.fusion.reset();
    }
}

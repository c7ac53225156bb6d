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
        // Edges are near the extrapolated joints, no longer where the network detected them.
        let measured = self.velocities.query(&self.fusion.query(t));
        let min_samples = self.min_samples;
        let velocities = measured
            // So few pixels may be noise, and a joint that moves fires more.
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

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity};

    use super::*;
    use crate::body::BODY_JOINTS;
    use crate::body::fusion::Estimator;

    const SENSOR: SensorSize = SensorSize { width: 64, height: 48 };
    const JOINT_PX: Vec2 = Vec2::new(20.0, 24.0);

    /// An edge along the columns that has moved by one column every millisecond, to column 20.
    fn edge() -> EventStream {
        let event =
            |x: u16, y| Event { t: Micros(1_000 * i64::from(x)), x, y, polarity: Polarity::On };
        let events = (0..=20).flat_map(|x| (0..SENSOR.height).map(move |y| event(x, y)));
        EventStream::from_events(SENSOR, events).unwrap()
    }

    fn follower(min_samples: u32) -> BodyFollower {
        let velocity = TripletVelocityConfig { radius_px: 5, ..TripletVelocityConfig::default() };
        let fusion = FusionConfig { estimator: Estimator::Integration, ..FusionConfig::default() };
        let mut follower = BodyFollower::new(SENSOR, velocity, &fusion, min_samples).unwrap();
        follower.push(&edge());
        let points = [Some(JOINT_PX); BODY_JOINTS];
        let pose = ScoredPoints { points, scores: [0.9; BODY_JOINTS] };
        follower.detection(Micros(10_000), &pose, Micros(12_000));
        follower
    }

    #[test]
    fn joints_move_with_the_edge_from_enough_pixels_and_rest_with_fewer() {
        // Two pixels from the sides of the region are 17 to 23 and 21 to 27: 4 of 7 columns fired.
        for (min_samples, moved_px) in [(28, 10.5), (29, 0.0)] {
            let joints = follower(min_samples).at(Micros(20_500));
            for joint in joints {
                let wanted = JOINT_PX + Vec2::X * moved_px;
                assert!(joint.unwrap().distance(wanted) < 1e-3, "{min_samples}: {joint:?}");
            }
        }
    }

    #[test]
    fn forgotten_detections_leave_the_events_and_a_reset_nothing() {
        let nobody = [None; BODY_JOINTS];
        let pose =
            ScoredPoints { points: [Some(JOINT_PX); BODY_JOINTS], scores: [0.9; BODY_JOINTS] };
        for (forget, moved_px) in
            [(BodyFollower::forget_detections as fn(&mut _), 10.5), (BodyFollower::reset, 0.0)]
        {
            let mut follower = follower(1);
            forget(&mut follower);
            assert_eq!(follower.fusion.query(Micros(20_000)), nobody);
            follower.detection(Micros(10_000), &pose, Micros(12_000));
            let joint = follower.at(Micros(20_500))[0].unwrap();
            assert!(joint.distance(JOINT_PX + Vec2::X * moved_px) < 1e-3, "{joint}");
        }
    }
}

//! The fusion of a whole body: detections and velocities in, joints at any time out.

use evpose_core::Micros;
use glam::Vec2;

use super::constant_position::ConstantPosition;
use super::constant_velocity::ConstantVelocity;
use super::displacement::Displacement;
use super::filter::BodyEstimator;
use super::integration::Integration;
use super::published::{ForgetfulDisplacement, SharedClock};
use super::time_order::TimeOrder;
use super::{Estimator, FusionConfig, FusionError, ScoredPoints};
use crate::PoseError;
use crate::body::{BODY_JOINTS, BodyPoints};

/// Follows the joints of one body, all in the order of networks.
///
/// Times are those of events. A measurement may arrive after others of later time stamps, as long
/// as its own lies within the history; see [`FusionConfig::history_s`].
#[derive(Debug)]
pub struct BodyFusion {
    config: FusionConfig,
    estimator: Box<dyn BodyEstimator>,
}

impl BodyFusion {
    /// Before the first detection.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn new(config: &FusionConfig) -> Result<Self, PoseError> {
        config.validate()?;
        Ok(Self { config: *config, estimator: start(*config) })
    }

    /// Takes a pose of the input of time `described`, known at time `now`. Returns the number of
    /// its joints that are accepted; the others count as not detected.
    ///
    /// # Errors
    /// If `described` is after `now` or before the history. The pose is then ignored.
    pub fn detection(
        &mut self,
        described: Micros,
        pose: &ScoredPoints,
        now: Micros,
    ) -> Result<usize, FusionError> {
        // A detection of the future means that two clocks are mixed up.
        if described > now {
            return Err(FusionError::NotYet { t: described, now });
        }
        let believed = self.config.confidence.believed(pose);
        let count = believed.iter().flatten().count();
        // A pose of nobody changes nothing.
        if count > 0 {
            let positions_px = believed.map(|point| point.map(|at| at.as_dvec2()));
            self.estimator.detection(described, &positions_px, now)?;
        }
        Ok(count)
    }

    /// Takes the velocities of all joints at time `t`, in px/s: those that
    /// [`TripletVelocity`](crate::body::velocity::TripletVelocity) measures until then. Zero means
    /// that a joint rests: nothing fires where nothing moves. NaN means not measured. Ignored for a
    /// joint before its first detection.
    ///
    /// # Errors
    /// If `t` is before the history. They are then ignored.
    pub fn velocity(
        &mut self,
        t: Micros,
        px_per_s: &[Vec2; BODY_JOINTS],
    ) -> Result<(), FusionError> {
        let measured = px_per_s.map(|velocity| velocity.is_finite().then(|| velocity.as_dvec2()));
        self.estimator.velocity(t, &measured)
    }

    /// The joints at time `t`, in pixels; none of those that were not detected until then, or not
    /// for [`FusionConfig::lost_after_s`].
    pub fn query(&self, t: Micros) -> BodyPoints {
        self.estimator.query(t)
    }

    /// Forgets every measurement.
    pub fn reset(&mut self) {
        self.estimator = start(self.config);
    }
}

fn start(config: FusionConfig) -> Box<dyn BodyEstimator> {
    use Estimator as E;
    match (config.estimator, config.parity) {
        (E::Integration, false) => Box::new(TimeOrder::<Integration>::new(config)),
        (E::ConstantPosition, false) => Box::new(TimeOrder::<ConstantPosition>::new(config)),
        (E::ConstantVelocity, false) => Box::new(TimeOrder::<ConstantVelocity>::new(config)),
        (E::Displacement, false) => Box::new(Displacement::new(config)),
        (E::Integration, true) => Box::new(SharedClock::<Integration>::new(config)),
        (E::ConstantPosition, true) => Box::new(SharedClock::<ConstantPosition>::new(config)),
        (E::ConstantVelocity, true) => Box::new(SharedClock::<ConstantVelocity>::new(config)),
        (E::Displacement, true) => Box::new(ForgetfulDisplacement::new(config)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_estimator_knows_a_joint_from_its_detection_to_the_end_of_its_patience() {
        let points = [Some(Vec2::new(3.0, 5.0)); BODY_JOINTS];
        let pose = ScoredPoints { points, scores: [0.9; BODY_JOINTS] };
        for estimator in Estimator::ALL {
            let config = FusionConfig { estimator, lost_after_s: 0.25, ..FusionConfig::default() };
            let mut fusion = BodyFusion::new(&config).unwrap();
            let early = fusion.detection(Micros(9), &pose, Micros(8));
            assert!(matches!(early, Err(FusionError::NotYet { .. })), "{estimator}");
            assert_eq!(fusion.detection(Micros(8), &pose, Micros(8)).unwrap(), BODY_JOINTS);
            for (t_us, is_known) in [(7, false), (8, true), (250_008, true), (250_009, false)] {
                let joints = fusion.query(Micros(t_us));
                let wanted = if is_known { points } else { [None; BODY_JOINTS] };
                assert_eq!(joints, wanted, "{estimator} at {t_us}");
            }
            fusion.reset();
            assert_eq!(fusion.query(Micros(8)), [None; BODY_JOINTS], "{estimator}");
        }
    }
}

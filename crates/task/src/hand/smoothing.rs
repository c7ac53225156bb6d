//! The temporal filter of poses: of the parameters, and of joints where a network finds them.

use evpose_core::Micros;
use evpose_pose::filter::{
    AdaptiveHandFilter, BodyFilterConfig, ConstantVelocityKalman, HandFilter,
};
use evpose_pose::{EVALUATION_JOINTS, HandPose};
use glam::Vec3;

use super::config::HandConfig;
use crate::TaskError;

/// Count of joints.
const JOINTS: usize = EVALUATION_JOINTS.len();

/// A filter of all that is known of a hand.
#[derive(Debug)]
pub(super) struct Smoothing {
    params: ParamsFilter,
    /// Each by itself, with the noise of its score.
    joints: Vec<ConstantVelocityKalman>,
    joint_noise: BodyFilterConfig,
}

#[derive(Debug)]
enum ParamsFilter {
    Kalman(Box<HandFilter>),
    Adaptive(Box<AdaptiveHandFilter>),
}

impl Smoothing {
    /// The published filter, or that of two settings. Joints may have the noise of their scores, as those of bodies.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub(super) fn new(config: &HandConfig, is_adaptive: bool) -> Result<Self, TaskError> {
        let params = match is_adaptive {
            false => ParamsFilter::Kalman(Box::new(HandFilter::new(&config.filter)?)),
            true => {
                let filter = AdaptiveHandFilter::new(&config.slow_motion.filter)?;
                ParamsFilter::Adaptive(Box::new(filter))
            }
        };
        let joint_noise = config.joint_filter;
        let joint = ConstantVelocityKalman::new(joint_noise.kalman(1.0), 3)?;
        Ok(Self { params, joints: vec![joint; JOINTS], joint_noise })
    }

    /// The estimate for time `t` from the pose of time `t` and all before.
    pub(super) fn update(&mut self, t: Micros, measured: &HandPose) -> HandPose {
        let params = match &mut self.params {
            ParamsFilter::Kalman(filter) => filter.update(t, &measured.params),
            ParamsFilter::Adaptive(filter) => filter.update(t, &measured.params),
        };
        let joints = measured.joints.map(|mut joints| {
            let scored = joints.camera_m.iter_mut().zip(joints.scores).zip(&mut self.joints);
            for ((at_m, score), filter) in scored {
                let (z, mut out) = (at_m.to_array(), [0.0; 3]);
                filter.retune(self.joint_noise.kalman(score));
                filter.update(t, &z, &mut out);
                *at_m = Vec3::from_array(out);
            }
            joints
        });
        HandPose { params, joints }
    }

    /// Whether the last pose was taken with the fast settings.
    pub(super) fn is_fast(&self) -> bool {
        matches!(&self.params, ParamsFilter::Adaptive(filter) if filter.is_fast())
    }

    /// Forgets everything.
    pub(super) fn reset(&mut self) {
        match &mut self.params {
            ParamsFilter::Kalman(filter) => filter.reset(),
            ParamsFilter::Adaptive(filter) => filter.reset(),
        }
        self.joints.iter_mut().for_each(ConstantVelocityKalman::reset);
    }
}

#[cfg(test)]
mod tests {
    use evpose_pose::HandJoints;

    use super::*;

    fn seen(at_m: Vec3) -> HandPose {
        let (scores, rotations) = ([0.5; 21], [Vec3::ZERO; 15]);
        let joints = HandJoints { camera_m: [at_m; 21], scores, presence: 0.9, rotations };
        HandPose { joints: Some(joints), ..HandPose::default() }
    }

    #[test]
    fn joints_that_move_uniformly_are_followed() {
        let mut smoothing = Smoothing::new(&HandConfig::default(), false).unwrap();
        let at_m = |ms: i64| Vec3::new(1e-3 * ms as f32, -0.2, -0.5);
        let mut last = HandPose::default();
        for ms in 0..2_000 {
            last = smoothing.update(Micros(1_000 * ms), &seen(at_m(ms)));
        }
        let joints = last.joints.unwrap();
        assert!(joints.camera_m[7].distance(at_m(1_999)) < 1e-3, "{}", joints.camera_m[7]);
        assert_eq!((joints.scores, joints.presence), ([0.5; 21], 0.9));
    }

    #[test]
    fn hands_without_joints_stay_without() {
        let mut smoothing = Smoothing::new(&HandConfig::default(), true).unwrap();
        assert!(smoothing.update(Micros(0), &HandPose::default()).joints.is_none());
    }
}

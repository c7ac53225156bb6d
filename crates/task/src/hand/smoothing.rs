//! The temporal filter of poses: of the parameters, and of joints where a network finds them.

use evpose_core::Micros;
use evpose_pose::filter::{
    AdaptiveHandFilter, ConstantVelocityKalman, HandFilter, HandNoise, KalmanConfig,
};
use evpose_pose::{HandJoints, HandPose};
use glam::Vec3;

use super::config::HandConfig;
use crate::TaskError;

/// A filter of all that is known of a hand.
#[derive(Debug)]
pub(super) struct Smoothing {
    params: ParamsFilter,
    joints: ConstantVelocityKalman,
    /// What was seen last: scores are not filtered.
    seen: Option<HandJoints>,
}

#[derive(Debug)]
enum ParamsFilter {
    Kalman(Box<HandFilter>),
    Adaptive(Box<AdaptiveHandFilter>),
}

/// Coordinates of all joints.
const COORDINATES: usize = 63;

impl Smoothing {
    /// The published filter, or that of two settings; joints move as the wrist does.
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
        let kalman = of_positions(config.filter.kalman);
        let joints = ConstantVelocityKalman::new(kalman, COORDINATES)?;
        Ok(Self { params, joints, seen: None })
    }

    /// The estimate for time `t` from the pose of time `t` and all before.
    pub(super) fn update(&mut self, t: Micros, measured: &HandPose) -> HandPose {
        let params = match &mut self.params {
            ParamsFilter::Kalman(filter) => filter.update(t, &measured.params),
            ParamsFilter::Adaptive(filter) => filter.update(t, &measured.params),
        };
        self.seen = measured.joints;
        let joints = measured.joints.map(|joints| {
            let mut out = [0.0; COORDINATES];
            self.joints.update(t, &flat(&joints.camera_m), &mut out);
            HandJoints { camera_m: points(&out), ..joints }
        });
        HandPose { params, joints }
    }

    /// The pose at `t` by constant velocity. None before the first measurement.
    pub(super) fn at(&self, t: Micros) -> Option<HandPose> {
        let params = match &self.params {
            ParamsFilter::Kalman(filter) => filter.at(t),
            ParamsFilter::Adaptive(filter) => filter.at(t),
        }?;
        let joints = self.seen.map(|seen| {
            let mut out = [0.0; COORDINATES];
            self.joints.at(t, &mut out);
            HandJoints { camera_m: points(&out), ..seen }
        });
        Some(HandPose { params, joints })
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
        self.joints.reset();
        self.seen = None;
    }
}

/// The settings of positions in metres: those of the wrist where parts of a hand have their own.
fn of_positions(kalman: KalmanConfig) -> KalmanConfig {
    let Some(HandNoise { translation, .. }) = kalman.hand else { return kalman };
    KalmanConfig {
        acceleration_variance: translation.acceleration,
        measurement_variance: translation.measurement,
        hand: None,
        ..kalman
    }
}

fn flat(points_m: &[Vec3; 21]) -> [f32; COORDINATES] {
    std::array::from_fn(|k| points_m[k / 3][k % 3])
}

fn points(values: &[f32; COORDINATES]) -> [Vec3; 21] {
    std::array::from_fn(|k| Vec3::from_slice(&values[3 * k..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(at_m: Vec3) -> HandPose {
        let joints = HandJoints { camera_m: [at_m; 21], scores: [0.5; 21], presence: 0.9 };
        HandPose { joints: Some(joints), ..HandPose::default() }
    }

    #[test]
    fn joints_that_move_uniformly_are_followed_and_propagated() {
        let mut smoothing = Smoothing::new(&HandConfig::default(), false).unwrap();
        assert!(smoothing.at(Micros(0)).is_none());
        let at_m = |ms: i64| Vec3::new(1e-3 * ms as f32, -0.2, -0.5);
        let mut last = HandPose::default();
        for ms in 0..2_000 {
            last = smoothing.update(Micros(1_000 * ms), &seen(at_m(ms)));
        }
        let joints = last.joints.unwrap();
        assert!(joints.camera_m[7].distance(at_m(1_999)) < 1e-3, "{}", joints.camera_m[7]);
        assert_eq!((joints.scores, joints.presence), ([0.5; 21], 0.9));
        let ahead = smoothing.at(Micros(2_019_000)).unwrap().joints.unwrap();
        assert!(ahead.camera_m[20].distance(at_m(2_019)) < 2e-3, "{}", ahead.camera_m[20]);
        smoothing.reset();
        assert!(smoothing.at(Micros(3_000_000)).is_none());
    }

    #[test]
    fn hands_without_joints_stay_without() {
        let mut smoothing = Smoothing::new(&HandConfig::default(), true).unwrap();
        let pose = smoothing.update(Micros(0), &HandPose::default());
        assert!(pose.joints.is_none() && smoothing.at(Micros(5)).unwrap().joints.is_none());
    }
}

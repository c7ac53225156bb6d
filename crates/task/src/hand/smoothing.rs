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
    /// The last estimate.
    last: Option<HandPose>,
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
        Ok(Self { params, joints, last: None })
    }

    /// The estimate for time `t` from the pose of time `t` and all before.
    pub(super) fn update(&mut self, t: Micros, measured: &HandPose) -> HandPose {
        let params = match &mut self.params {
            ParamsFilter::Kalman(filter) => filter.update(t, &measured.params),
            ParamsFilter::Adaptive(filter) => filter.update(t, &measured.params),
        };
        let joints = measured.joints.map(|joints| {
            let mut out = [0.0; COORDINATES];
            self.joints.update(t, &flat(&joints.camera_m), &mut out);
            HandJoints { camera_m: points(&out), ..joints }
        });
        *self.last.insert(HandPose { params, joints })
    }

    /// The pose between two measurements: the last estimate, held. Events between two poses of a network are in no
    /// window yet, and the velocity that the filter knows is that of its noise: extrapolated by it, poses were three
    /// times as wrong as held ones. None before the first measurement.
    pub(super) fn held(&self) -> Option<HandPose> {
        self.last
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
        self.last = None;
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
    fn joints_that_move_uniformly_are_followed_and_then_held() {
        let mut smoothing = Smoothing::new(&HandConfig::default(), false).unwrap();
        assert!(smoothing.held().is_none());
        let at_m = |ms: i64| Vec3::new(1e-3 * ms as f32, -0.2, -0.5);
        let mut last = HandPose::default();
        for ms in 0..2_000 {
            last = smoothing.update(Micros(1_000 * ms), &seen(at_m(ms)));
        }
        let joints = last.joints.unwrap();
        assert!(joints.camera_m[7].distance(at_m(1_999)) < 1e-3, "{}", joints.camera_m[7]);
        assert_eq!((joints.scores, joints.presence), ([0.5; 21], 0.9));
        assert_eq!(smoothing.held(), Some(last));
        smoothing.reset();
        assert!(smoothing.held().is_none());
    }

    #[test]
    fn hands_without_joints_stay_without() {
        let mut smoothing = Smoothing::new(&HandConfig::default(), true).unwrap();
        let pose = smoothing.update(Micros(0), &HandPose::default());
        assert!(pose.joints.is_none() && smoothing.held().unwrap().joints.is_none());
    }
}

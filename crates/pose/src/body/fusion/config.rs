//! Settings of the fusion of detections and velocities.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::ConfidenceTest;
use crate::PoseError;

/// Estimator of a joint.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// Velocities are summed up; a detection takes the place of what was. hpe-core's
    /// `stateEstimator`.
    Integration,
    /// A Kalman filter of a joint that rests but for noise; a velocity counts as a detection where
    /// it leads from the last estimate, and so moves it by a part of the way. hpe-core's
    /// `kfEstimator`.
    ConstantPosition,
    /// A Kalman filter of position and velocity, either of which may be measured. hpe-core's
    /// `constVelKalman`. The best of them in our simulation, and so the default.
    #[default]
    ConstantVelocity,
    /// A Kalman filter of the position, moved by the mean velocity of every millisecond. hpe-core's
    /// `multiJointLatComp`.
    Displacement,
}

impl Estimator {
    /// All estimators.
    pub const ALL: [Self; 4] =
        [Self::Integration, Self::ConstantPosition, Self::ConstantVelocity, Self::Displacement];

    /// Name in settings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Integration => "integration",
            Self::ConstantPosition => "constant_position",
            Self::ConstantVelocity => "constant_velocity",
            Self::Displacement => "displacement",
        }
    }
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Settings of a [`super::BodyFusion`].
///
/// In steady state only ratios of variances and noises count. Each names the
/// estimators that use it; `U` and `u'` are the names of the original's parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FusionConfig {
    /// Estimator of each joint.
    pub estimator: Estimator,
    /// Bit-level parity with hpe-core, as far as the two can be compared:
    ///
    /// * a velocity of a body moves the clock for its first joint alone, so that all others see no time
    ///   pass (not so with `integration`);
    /// * covariances begin at zero, and the process noise of `constant_velocity` has no cross term;
    /// * detections count when they arrive, and answers are not carried on to the time asked for;
    /// * `displacement` forgets its history with each detection, so that one whose input is older than
    ///   the arrival of the last is compared with the wrong position, and its steps are whole milliseconds;
    /// * joints are never lost, and a coordinate of 0 means that there is none.
    pub parity: bool,
    /// Whether a detection is applied at the event time stamp of its input. If not, at its arrival.
    pub latency_compensation: bool,
    /// How long measurements are remembered, seconds: the largest latency of a detection.
    /// `displacement` always remembers five seconds, but inputs of detections must be in time
    /// order.
    pub history_s: f64,
    /// How long a joint is followed without a detection, seconds; may be `inf`. Later, it is not
    /// known, until the next detection starts it anew.
    pub lost_after_s: f64,
    /// How long after the last measurement a joint moves on with its last velocity, seconds
    /// (`constant_velocity`).
    pub extrapolation_limit_s: f64,
    /// Scores from which detections are accepted.
    pub confidence: ConfidenceTest,
    /// Variance of a detected position, px² (all but `integration`; measU, measUD).
    pub detection_variance_px2: f64,
    /// How fast an estimated position becomes uncertain by itself, px²/s (all but `integration`;
    /// procU).
    pub position_noise_px2_per_s: f64,
    /// Variance of a measured velocity, (px/s)² (`constant_velocity`; measUd).
    pub velocity_variance_px2_per_s2: f64,
    /// How fast an estimated velocity becomes uncertain, (px/s)²/s (`constant_velocity`; procUd).
    pub velocity_noise_px2_per_s3: f64,
    /// Variance of the velocity of a joint that was found just now, (px/s)² (`constant_velocity`).
    pub first_velocity_variance_px2_per_s2: f64,
    /// Variance of where a velocity leads, px² (`constant_position`; measUV).
    pub displacement_variance_px2: f64,
}

impl Default for FusionConfig {
    /// For a person before a sensor of 640x480: detections good to 5 px, velocities to 100 px/s,
    /// which change by as much in 10 ms; within 50 ms, a position becomes uncertain by 7 px, for
    /// velocities that are 20 % too small do so to joints of 700 px/s.
    fn default() -> Self {
        Self {
            estimator: Estimator::ConstantVelocity,
            parity: false,
            latency_compensation: true,
            history_s: 1.0,
            lost_after_s: 1.0,
            extrapolation_limit_s: 0.1,
            confidence: ConfidenceTest::default(),
            detection_variance_px2: 25.0,
            position_noise_px2_per_s: 1000.0,
            velocity_variance_px2_per_s2: 1e4,
            velocity_noise_px2_per_s3: 1e6,
            first_velocity_variance_px2_per_s2: 4e4,
            displacement_variance_px2: 0.04,
        }
    }
}

impl FusionConfig {
    /// Checks the ranges of all settings.
    pub(super) fn validate(&self) -> Result<(), PoseError> {
        self.confidence.validate()?;
        for (field, value) in [
            ("detection_variance_px2", self.detection_variance_px2),
            ("velocity_variance_px2_per_s2", self.velocity_variance_px2_per_s2),
            ("first_velocity_variance_px2_per_s2", self.first_velocity_variance_px2_per_s2),
            ("displacement_variance_px2", self.displacement_variance_px2),
            ("position_noise_px2_per_s", self.position_noise_px2_per_s),
            ("velocity_noise_px2_per_s3", self.velocity_noise_px2_per_s3),
        ] {
            let is_variance = value > 0.0 && value.is_finite();
            PoseError::unless(is_variance, field, value, "positive and finite")?;
        }
        for (field, value) in
            [("history_s", self.history_s), ("extrapolation_limit_s", self.extrapolation_limit_s)]
        {
            let is_time = (0.0..=60.0).contains(&value);
            PoseError::unless(is_time, field, value, "from 0 to 60 seconds")?;
        }
        // Infinity is allowed: joints are then never lost.
        let value = self.lost_after_s;
        PoseError::unless(value > 0.0, "lost_after_s", value, "positive")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_go_through_a_file_and_unknown_ones_are_refused() {
        for estimator in Estimator::ALL {
            let name = estimator.name();
            let text =
                format!("estimator = \"{name}\"\nlost_after_s = inf\nconfidence.joint = 0.1");
            let read: FusionConfig = toml::from_str(&text).unwrap();
            assert_eq!(read.estimator, estimator);
            assert_eq!((read.lost_after_s, read.confidence.pose), (f64::INFINITY, 0.4));
            let again: FusionConfig = toml::from_str(&toml::to_string(&read).unwrap()).unwrap();
            assert_eq!(again, read);
        }
        assert!(toml::from_str::<FusionConfig>("estimater = \"integration\"").is_err());
        assert!(toml::from_str::<FusionConfig>("confidence.joints = 0.1").is_err());
    }

    #[test]
    fn bad_settings_are_refused_by_name() {
        let good = FusionConfig::default();
        assert_eq!(good.validate(), Ok(()));
        let confidence = ConfidenceTest { joint: -0.1, ..ConfidenceTest::default() };
        for (config, name) in [
            (FusionConfig { detection_variance_px2: 0.0, ..good }, "detection_variance_px2"),
            (FusionConfig { history_s: f64::INFINITY, ..good }, "history_s"),
            (FusionConfig { lost_after_s: 0.0, ..good }, "lost_after_s"),
            (FusionConfig { velocity_noise_px2_per_s3: f64::NAN, ..good }, "velocity_noise"),
            (FusionConfig { confidence, ..good }, "confidence.joint"),
        ] {
            let error = config.validate().unwrap_err();
            assert!(error.to_string().contains(name), "{error}");
        }
    }
}

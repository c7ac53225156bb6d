//! The Kalman filter of the joints of a body in the image.
//!
//! # Model
//! Every joint moves by itself, as two values of a [`ConstantVelocityKalman`]. The variance of a
//! measurement is `score^-e`, relative to that of a joint that scores 1: in steady state only its
//! ratio to the variance of the acceleration counts, so that neither depends on the size of a body.
//! With `e = 4`, the cutoff of the filter is in proportion to the score.
//!
//! Residuals of networks follow the score alone: events about a joint are in it already. Over
//! simulated recordings their squares go with `score^-4.0` and `events^0.04`.

use evpose_core::Micros;
use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::{ConstantVelocityKalman, KalmanConfig, NoiseVariances};
use crate::PoseError;
use crate::body::fusion::ScoredPoints;
use crate::body::{BODY_JOINTS, BodyPoints};

/// Scores below it count as this one: the variance stays finite.
const MIN_SCORE: f32 = 0.02;

/// Noise of a [`BodyFilter`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyFilterConfig {
    /// The -3 dB frequency for joints that score 1, in Hz.
    pub cutoff_hz: f64,
    /// The variance of a measurement goes with the score to minus this power.
    pub score_exponent: f64,
    /// How long a joint is predicted without a measurement, in seconds; later it begins anew.
    pub max_gap_s: f64,
}

impl Default for BodyFilterConfig {
    /// The estimate of `evpose eval` for the network `body` on its home set, rounded.
    fn default() -> Self {
        Self { cutoff_hz: 31.0, score_exponent: 4.0, max_gap_s: 0.5 }
    }
}

impl BodyFilterConfig {
    /// Whether it is the default.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// The Kalman filter of a joint of this score.
    pub fn kalman(&self, score: f32) -> KalmanConfig {
        let measurement = f64::from(score.max(MIN_SCORE)).powf(-self.score_exponent);
        let acceleration = NoiseVariances::with_cutoff(self.cutoff_hz, 1.0).acceleration;
        KalmanConfig {
            acceleration_variance: acceleration,
            measurement_variance: measurement,
            ..KalmanConfig::default()
        }
    }
}

/// Smooths the joints of a body, one pose at a time and without looking ahead.
#[derive(Debug, Clone)]
pub struct BodyFilter {
    config: BodyFilterConfig,
    tracks: Vec<JointTrack>,
}

#[derive(Debug, Clone)]
struct JointTrack {
    kalman: ConstantVelocityKalman,
    /// Time of the last measurement.
    measured: Option<Micros>,
}

impl BodyFilter {
    /// A filter before the first pose.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn new(config: BodyFilterConfig) -> Result<Self, PoseError> {
        for (field, value, most) in [
            ("cutoff_hz", config.cutoff_hz, 1e4),
            ("score_exponent", config.score_exponent, 16.0),
            ("max_gap_s", config.max_gap_s, 60.0),
        ] {
            // A cutoff of zero passes here and fails below, as a variance that is not positive.
            let is_sensible = (0.0..=most).contains(&value);
            PoseError::unless(is_sensible, field, value, "from 0, and not beyond any sense")?;
        }
        // The score does not matter here: every measurement brings its own noise.
        let kalman = ConstantVelocityKalman::new(config.kalman(1.0), 2)?;
        Ok(Self { config, tracks: vec![JointTrack { kalman, measured: None }; BODY_JOINTS] })
    }

    /// Takes the pose of time `t` and returns its joints, filtered; those that it lacks are
    /// predicted for later poses and stay none in this one.
    pub fn update(&mut self, t: Micros, pose: &ScoredPoints) -> BodyPoints {
        std::array::from_fn(|joint| {
            let config = self.config.kalman(pose.scores[joint]);
            self.tracks[joint].update(t, pose.points[joint], config, self.config.max_gap_s)
        })
    }

    /// Forgets all poses.
    pub fn reset(&mut self) {
        self.tracks.iter_mut().for_each(|track| track.measured = None);
    }
}

impl JointTrack {
    fn update(
        &mut self,
        t: Micros,
        point: Option<Vec2>,
        config: KalmanConfig,
        max_gap_s: f64,
    ) -> Option<Vec2> {
        let gap_s = self.measured.map(|measured| (t - measured).as_seconds());
        // A negative gap means another recording, in which the joint begins anew.
        let goes_on = gap_s.is_some_and(|gap_s| (0.0..=max_gap_s).contains(&gap_s));
        if point.is_some() {
            // Noise depends on the score of this measurement.
            self.kalman.retune(config);
            if !goes_on {
                self.kalman.reset();
            }
            self.measured = Some(t);
        }
        // NaN is no measurement: the filter predicts alone.
        let (measured, mut filtered) = (point.unwrap_or(Vec2::NAN).to_array(), [0.0; 2]);
        self.kalman.update(t, &measured, &mut filtered);
        point.map(|_| filtered.into())
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::CounterRng;

    use super::*;

    fn pose(at: Vec2, score: f32) -> ScoredPoints {
        ScoredPoints { points: [Some(at); BODY_JOINTS], scores: [score; BODY_JOINTS] }
    }

    fn at(k: i64) -> Micros {
        Micros(20_000 * k)
    }

    fn filter() -> BodyFilter {
        BodyFilter::new(BodyFilterConfig::default()).unwrap()
    }

    /// The variance that an alpha-beta filter leaves of white noise, with Kalata's gains.
    fn variance_left(score: f32) -> f64 {
        let KalmanConfig { acceleration_variance, measurement_variance, .. } =
            BodyFilterConfig::default().kalman(score);
        let lambda = (acceleration_variance * 0.02f64.powi(4) / measurement_variance).sqrt();
        let root = (lambda * lambda + 8.0 * lambda).sqrt();
        let alpha = ((lambda + 4.0) * root - lambda * lambda - 8.0 * lambda) / 8.0;
        let beta = 2.0 * (2.0 - alpha) - 4.0 * (1.0 - alpha).sqrt();
        (2.0 * alpha * alpha + beta * (2.0 - 3.0 * alpha)) / (alpha * (4.0 - 2.0 * alpha - beta))
    }

    #[test]
    fn a_joint_that_scores_little_is_smoothed_more() {
        let mut rng = CounterRng::new(5, "joints", 0);
        let noise: Vec<Vec2> = (0..5_000).map(|_| Vec2::new(rng.normal(), rng.normal())).collect();
        let wanted = [0.9, 0.6, 0.3].map(variance_left);
        assert!(wanted.is_sorted_by(|a, b| a > b));
        for (score, wanted) in [0.9, 0.6, 0.3].into_iter().zip(wanted) {
            let mut filter = filter();
            let mut left = 0.0;
            for (k, noise) in noise.iter().enumerate() {
                // The joint moves, so that a lag would count as an error too.
                let truth = Vec2::new(50.0 + 0.05 * k as f32, 80.0);
                let joint = filter.update(at(k as i64), &pose(truth + *noise, score))[4].unwrap();
                left += f64::from(joint.distance_squared(truth));
            }
            left /= 2.0 * noise.len() as f64;
            assert!((left / wanted - 1.0).abs() < 0.08, "{score}: {left}, not {wanted}");
        }
    }

    /// With the exponent of 4, half the score is half the cutoff.
    #[test]
    fn the_cutoff_goes_with_the_score() {
        let config = BodyFilterConfig::default();
        for score in [1.0, 0.5, 0.25] {
            let wanted = config.cutoff_hz * f64::from(score);
            assert!((config.kalman(score).cutoff_hz() - wanted).abs() < 1e-9);
        }
    }

    #[test]
    fn one_measurement_that_scores_next_to_nothing_moves_nothing() {
        let mut filter = filter();
        for k in 0..20 {
            filter.update(at(k), &pose(Vec2::ZERO, 0.8));
        }
        // An eighth of the score is 8⁴ = 4096 times the variance.
        let moved = filter.update(at(20), &pose(Vec2::splat(100.0), 0.1))[0].unwrap();
        assert!(moved.length() < 2.0, "{moved}");
        let moved = filter.update(at(21), &pose(Vec2::splat(100.0), 0.8))[0].unwrap();
        assert!(moved.length() > 50.0, "{moved}");
    }

    #[test]
    fn what_is_not_found_stays_so_and_after_a_gap_a_joint_begins_anew() {
        // At 20 ms a pose, the 25th is 0.5 s late, which is the longest gap.
        for (poses_missing, begins_anew) in [(24, false), (25, true)] {
            let mut filter = filter();
            filter.update(at(0), &pose(Vec2::ZERO, 0.7));
            for k in 1..=poses_missing {
                let nobody = ScoredPoints { points: [None; BODY_JOINTS], ..pose(Vec2::ZERO, 0.0) };
                assert_eq!(filter.update(at(k), &nobody), [None; BODY_JOINTS]);
            }
            let found = filter.update(at(poses_missing + 1), &pose(Vec2::splat(9.0), 0.7))[3];
            assert_eq!(found == Some(Vec2::splat(9.0)), begins_anew, "{found:?}");
        }
        let mut filter = filter();
        filter.update(at(9), &pose(Vec2::ZERO, 0.7));
        let earlier = filter.update(at(3), &pose(Vec2::ONE, 0.7))[0];
        assert_eq!(earlier, Some(Vec2::ONE), "another recording");
        filter.reset();
        assert_eq!(filter.update(at(4), &pose(Vec2::ZERO, 0.7))[0], Some(Vec2::ZERO));
    }

    #[test]
    fn settings_without_sense_are_refused() {
        for config in [
            BodyFilterConfig { cutoff_hz: 0.0, ..BodyFilterConfig::default() },
            BodyFilterConfig { cutoff_hz: f64::NAN, ..BodyFilterConfig::default() },
            BodyFilterConfig { score_exponent: -1.0, ..BodyFilterConfig::default() },
            BodyFilterConfig { max_gap_s: f64::INFINITY, ..BodyFilterConfig::default() },
        ] {
            assert!(BodyFilter::new(config).is_err(), "{config:?}");
        }
    }
}

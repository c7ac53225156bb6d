//! Errors of the velocities of joints.
//!
//! # Model
//! The truth and the predictions are resampled as [`BodyProtocol`] says. The velocity of the truth
//! is its gradient: central differences, one-sided ones at both ends. Both velocities are smoothed
//! coordinate by coordinate with a [`SavitzkyGolay`] filter, and their [`RootMeanSquare`] is taken.
//! The published program does so over the whole sequence. Where a joint is not known throughout,
//! each stretch in which it is known is treated as a sequence of its own here; stretches that are
//! shorter than a window are left out and counted.
//!
//! # Source
//! hpe-core's `evaluate_vel`.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::errors::mean_over_joints;
use super::track::Tracks;
use super::{BodyPrediction, BodyProtocol, BodyTruth, RootMeanSquare, SavitzkyGolay};
use crate::PoseError;
use crate::body::BODY_JOINTS;

/// Quantity that predictions hold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum PredictedVelocity {
    /// Positions in pixels, whose gradient is taken as that of the truth.
    Positions,
    /// Velocities, which times `scale` are in pixels a second.
    Velocities {
        /// 10 in published files.
        scale: f64,
    },
}

/// Evaluation protocol of velocities.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VelocityProtocol {
    /// Instants that are compared.
    pub sampling: BodyProtocol,
    /// Quantity that predictions hold.
    pub predicted: PredictedVelocity,
    /// Length of the filter's window in instants, an odd number.
    pub window: usize,
    /// Degree of the filter's polynomials.
    pub degree: usize,
}

impl Default for VelocityProtocol {
    fn default() -> Self {
        let predicted = PredictedVelocity::Velocities { scale: 1.0 };
        Self { sampling: BodyProtocol::default(), predicted, window: 501, degree: 3 }
    }
}

/// Errors of the velocities of joints. They add up over sequences.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VelocityErrors {
    /// In pixels a second, one per joint, in the order of networks.
    pub joints: [RootMeanSquare; BODY_JOINTS],
    /// Instants at which a joint is known, but not for the length of a window.
    pub left_out: u64,
}

impl VelocityErrors {
    /// Compares the velocities of a sequence.
    ///
    /// # Errors
    /// As [`BodySequence::evaluate`](super::BodySequence::evaluate), and if the filter makes no
    /// sense.
    pub fn evaluate(
        truth: &[BodyTruth],
        predicted: &[BodyPrediction],
        protocol: &VelocityProtocol,
    ) -> Result<Self, PoseError> {
        let filter = SavitzkyGolay::new(protocol.window, protocol.degree)?;
        let tracks = Tracks::new(truth, predicted, &protocol.sampling)?;
        let mut errors = Self::default();
        for joint in 0..BODY_JOINTS {
            let (mut truth, mut predicted) = (tracks.truth.sampler(), tracks.predicted.sampler());
            // One joint at a time: positions of all of them at all instants would be large.
            let known: Vec<_> = protocol
                .sampling
                .instants(tracks.end_s)?
                .map(|t_s| truth.at(t_s).joints[joint].zip(predicted.at(t_s).joints[joint]))
                .collect();
            for stretch in known.split(Option::is_none) {
                errors.push(joint, stretch, protocol, &filter);
            }
        }
        Ok(errors)
    }

    /// Adds a stretch of positions of the truth and what was predicted, none of which is missing.
    fn push(
        &mut self,
        joint: usize,
        stretch: &[Option<(DVec2, DVec2)>],
        protocol: &VelocityProtocol,
        filter: &SavitzkyGolay,
    ) {
        let (truth, predicted): (Vec<_>, Vec<_>) = stretch.iter().copied().flatten().unzip();
        let rate_hz = protocol.sampling.rate_hz;
        let predicted = match protocol.predicted {
            PredictedVelocity::Positions => gradient(&predicted, rate_hz),
            PredictedVelocity::Velocities { scale } => {
                predicted.iter().map(|v| v * scale).collect()
            }
        };
        let truth = smoothed(&gradient(&truth, rate_hz), filter);
        match truth.zip(smoothed(&predicted, filter)) {
            Some((truth, predicted)) => {
                let pairs = predicted.into_iter().zip(truth);
                pairs.for_each(|(predicted, truth)| self.joints[joint].push(predicted, truth));
            }
            None => self.left_out += stretch.len() as u64,
        }
    }

    /// Adds the errors of another sequence.
    pub fn merge(&mut self, other: &Self) {
        for (errors, more) in self.joints.iter_mut().zip(&other.joints) {
            errors.merge(more);
        }
        self.left_out += other.left_out;
    }

    /// The root mean square error in pixels a second, the mean over joints.
    pub fn rmse_px_s(&self) -> Option<f64> {
        mean_over_joints(self.joints.iter().map(RootMeanSquare::length))
    }

    /// The published one, in percent of the mean velocity, the mean over joints.
    pub fn rmse_percent(&self) -> Option<f64> {
        mean_over_joints(self.joints.iter().map(RootMeanSquare::percent))
    }
}

/// Differences a second of positions, as NumPy's `gradient`; of fewer than two they are 0.
fn gradient(positions: &[DVec2], rate_hz: f64) -> Vec<DVec2> {
    let last = positions.len().saturating_sub(1);
    let at = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
        (positions[after] - positions[before]) / (after - before).max(1) as f64 * rate_hz
    };
    (0..positions.len()).map(at).collect()
}

fn smoothed(values: &[DVec2], filter: &SavitzkyGolay) -> Option<Vec<DVec2>> {
    let coordinate =
        |of: fn(&DVec2) -> f64| filter.smoothed(&values.iter().map(of).collect::<Vec<_>>());
    let (x, y) = (coordinate(|v| v.x)?, coordinate(|v| v.y)?);
    Some(x.into_iter().zip(y).map(DVec2::from).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use glam::Vec2;

    use super::*;
    use crate::body::BodyPoints;

    /// Joint `k` moves by `(20 k, -30)` px a second.
    fn truth() -> Vec<BodyTruth> {
        let at = |t: f32| {
            let joints_px: BodyPoints = std::array::from_fn(|k| {
                Some(Vec2::new(100.0, 200.0) + t * Vec2::new(20.0 * k as f32, -30.0))
            });
            BodyTruth::by_torso(t.into(), joints_px)
        };
        [0.0, 4.0].map(at).to_vec()
    }

    fn predicted(error: Vec2) -> Vec<BodyPrediction> {
        let at = |t_s: f64| {
            let velocity = |k: usize| Some(Vec2::new(20.0 * k as f32, -30.0) + error);
            BodyPrediction { t_s, delay_s: 0.0, joints_px: std::array::from_fn(velocity) }
        };
        [1.0, 2.0, 3.0].map(at).to_vec()
    }

    /// Until 4 s the truth moves, and then it rests for a second.
    fn protocol() -> VelocityProtocol {
        VelocityProtocol { window: 51, ..VelocityProtocol::default() }
    }

    #[test]
    fn a_constant_error_of_velocity_is_found_again_while_joints_move() {
        let predicted = predicted(Vec2::new(3.0, 4.0));
        let errors = VelocityErrors::evaluate(&truth(), &predicted, &protocol()).unwrap();
        let head = errors.joints[0];
        // 4 s of (3, 4), and 1 s of (3, -26), about.
        let want = f64::sqrt(9.0 + (4.0 * 16.0 + 676.0) / 5.0);
        assert!((head.length().unwrap() - want).abs() < 0.1, "{:?} {want}", head.length());
        assert_eq!(head.count, 5_000);
    }

    #[test]
    fn positions_that_are_right_have_the_right_velocity() {
        let positions: Vec<_> = (0..50)
            .map(|k| 0.1 * f64::from(k))
            .map(|t_s| {
                let at = |k: usize| {
                    let t = t_s.min(4.0) as f32;
                    Some(Vec2::new(100.0, 200.0) + t * Vec2::new(20.0 * k as f32, -30.0))
                };
                BodyPrediction { t_s, delay_s: 0.0, joints_px: std::array::from_fn(at) }
            })
            .collect();
        let sampling = BodyProtocol { skipped_share: 0.0, ..BodyProtocol::default() };
        let protocol =
            VelocityProtocol { sampling, predicted: PredictedVelocity::Positions, ..protocol() };
        let errors = VelocityErrors::evaluate(&truth(), &positions, &protocol).unwrap();
        // But for the first 0.1 s, which have no prediction before them.
        assert!(errors.rmse_px_s().unwrap() < 30.0);
    }

    #[test]
    fn stretches_shorter_than_a_window_are_left_out_and_counted() {
        let mut predicted = predicted(Vec2::ZERO);
        predicted[1].joints_px[4] = None;
        let errors = VelocityErrors::evaluate(&truth(), &predicted, &protocol()).unwrap();
        // Known until 1 s and from 3 s on.
        assert!((2_999..=3_001).contains(&errors.joints[4].count), "{:?}", errors.joints[4]);
        let long = VelocityProtocol { window: 1_501, ..protocol() };
        let errors = VelocityErrors::evaluate(&truth(), &predicted, &long).unwrap();
        assert!((1_000..=1_001).contains(&errors.left_out), "{}", errors.left_out);
        let mut twice = errors.clone();
        twice.merge(&errors);
        assert_eq!((twice.left_out, twice.joints[0].count), (2 * errors.left_out, 10_000));
    }

    #[test]
    fn gradients_are_those_of_numpy() {
        let line = |xs: &[f64]| xs.iter().map(|x| DVec2::new(*x, 1.0)).collect::<Vec<_>>();
        // numpy.gradient([1, 2, 4, 7, 11]).
        let slope: Vec<_> =
            gradient(&line(&[1.0, 2.0, 4.0, 7.0, 11.0]), 1.0).iter().map(|v| v.x).collect();
        assert_eq!(slope, [1.0, 1.5, 2.5, 3.5, 4.0]);
        assert_eq!(gradient(&line(&[3.0]), 9.0), [DVec2::ZERO]);
    }
}

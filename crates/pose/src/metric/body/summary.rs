//! Scores of all sequences, and the table made of them.

use evpose_core::stats::bootstrap::{BootstrapConfig, Totals, bootstrap, mean_interval};
use evpose_core::stats::interval::Interval;
use serde::{Deserialize, Serialize};

use super::errors::mean_over_joints;
use super::{BODY_THRESHOLDS, BodyErrors, BodySequence, JointErrors, RootMeanSquare};
use crate::PoseError;
use crate::body::{BODY_JOINTS, JOINT_NAMES};

/// Scores of a method on every sequence, in their order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyEvaluation {
    /// One per sequence.
    pub sequences: Vec<BodySequence>,
}

impl BodyEvaluation {
    /// Scores with intervals, the PCK at thresholds in percent of the body's size.
    ///
    /// # Errors
    /// If a threshold is not from 1 to 100.
    pub fn summary(
        &self,
        percents: &[usize],
        config: &BootstrapConfig,
    ) -> Result<BodySummary, PoseError> {
        for percent in percents {
            let is_one = (1..=BODY_THRESHOLDS).contains(percent);
            PoseError::unless(is_one, "threshold in percent", *percent as f64, "from 1 to 100")?;
        }
        let scores = |of: fn(&BodySequence) -> &BodyErrors| {
            BodyScores::new(&self.sequences.iter().map(of).collect::<Vec<_>>(), percents, config)
        };
        let delays: Vec<_> = self.sequences.iter().map(|s| s.delay_s).collect();
        let gaps: Vec<_> = self.sequences.iter().map(|s| s.gap_s).collect();
        let jitter: Vec<_> = self.sequences.iter().map(|s| s.acceleration_px_s2).collect();
        // A bootstrap draw of sequences without two poses has no gaps, and so no rate.
        let rate = |gaps: &Totals| (gaps.sum > 0.0).then(|| gaps.count as f64 / gaps.sum);
        Ok(BodySummary {
            sequences: self.sequences.len(),
            percents: percents.to_vec(),
            resampled: scores(|s| &s.resampled),
            raw: scores(|s| &s.raw),
            delay_s: mean_interval(&delays, config),
            rate_hz: interval(&gaps, |a, b| *a = [*a, *b].into_iter().sum(), rate, config),
            acceleration_px_s2: mean_interval(&jitter, config),
            skipped: self.sequences.iter().map(|s| s.skipped).sum(),
        })
    }
}

/// The table of a method. None where nothing was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodySummary {
    /// How many sequences there were.
    pub sequences: usize,
    /// Thresholds of the PCK, in percent of the body's size.
    pub percents: Vec<usize>,
    /// At evenly spaced instants.
    pub resampled: BodyScores,
    /// At the instants of predictions.
    pub raw: BodyScores,
    /// How long a prediction took, in seconds.
    pub delay_s: Option<Interval>,
    /// Predictions a second.
    pub rate_hz: Option<Interval>,
    /// Error of the acceleration, in px/s²: the jitter.
    #[serde(default)]
    pub acceleration_px_s2: Option<Interval>,
    /// Predictions that came too early or too late in their sequences to count.
    pub skipped: u64,
}

/// Scores over all sequences: means over joints of each joint's mean, with 95% intervals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyScores {
    /// How many instants were compared.
    pub instants: u64,
    /// Share of correct joints at each of the thresholds asked for.
    pub pck: Vec<Option<Interval>>,
    /// The same at 1 %, 2 %, …, 100 %; empty where nothing was measured.
    pub curve: Vec<f64>,
    /// The area under that curve.
    pub auc: Option<Interval>,
    /// Mean distance, in pixels.
    pub mpjpe_px: Option<Interval>,
    /// Root mean square error, in pixels.
    pub rmse_px: Option<Interval>,
    /// Root mean square error, in percent of the position.
    pub rmse_percent: Option<Interval>,
    /// The same joint by joint, in the order of networks.
    pub joints: Vec<JointScores>,
}

/// Scores of one joint over all sequences. None where nothing was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointScores {
    /// Name of the joint.
    pub joint: String,
    /// Share of correct ones at each of the thresholds asked for.
    pub pck: Vec<Option<f64>>,
    /// The area under the curve.
    pub auc: Option<f64>,
    /// Mean distance, in pixels.
    pub mpjpe_px: Option<f64>,
    /// Root mean square error, in pixels.
    pub rmse_px: Option<f64>,
    /// Root mean square error, in percent of the position.
    pub rmse_percent: Option<f64>,
    /// How often the joint was labelled.
    pub labelled: u64,
    /// How often it was labelled and not found.
    pub missing: u64,
    /// How often it was labelled on a body of unknown size.
    pub unmeasured: u64,
    /// How often it was not labelled.
    pub unlabelled: u64,
    /// How often it was not labelled and found nevertheless.
    pub spurious: u64,
}

impl BodyScores {
    fn new(sequences: &[&BodyErrors], percents: &[usize], config: &BootstrapConfig) -> Self {
        let mut all = BodyErrors::default();
        sequences.iter().for_each(|sequence| all.merge(sequence));
        // Sequences are resampled whole: their frames depend on each other.
        let means = |number: &dyn Fn(&JointErrors) -> Totals| {
            let parts: Vec<_> = sequences.iter().map(|s| s.joints.each_ref().map(number)).collect();
            let merge = |a: &mut [Totals; BODY_JOINTS], b: &[Totals; BODY_JOINTS]| {
                a.iter_mut().zip(b).for_each(|(a, b)| *a = [*a, *b].into_iter().sum());
            };
            let mean = |joints: &[Totals; BODY_JOINTS]| {
                mean_over_joints(joints.map(Totals::mean).into_iter())
            };
            interval(&parts, merge, mean, config)
        };
        // Squares are merged before the root is taken: a mean of roots would be another quantity.
        let squares = |value: fn(&RootMeanSquare) -> Option<f64>| {
            let parts: Vec<_> =
                sequences.iter().map(|s| s.joints.each_ref().map(|j| j.squares)).collect();
            let merge = |a: &mut [RootMeanSquare; BODY_JOINTS],
                         b: &[RootMeanSquare; BODY_JOINTS]| {
                a.iter_mut().zip(b).for_each(|(a, b)| a.merge(b));
            };
            interval(&parts, merge, |joints| mean_over_joints(joints.iter().map(value)), config)
        };
        Self {
            instants: all.instants,
            pck: percents.iter().map(|&percent| means(&|j| j.pck.correct(percent))).collect(),
            curve: all.curve(),
            auc: means(&|j| j.pck.area()),
            mpjpe_px: means(&|j| j.distance_px),
            rmse_px: squares(RootMeanSquare::length),
            rmse_percent: squares(RootMeanSquare::percent),
            joints: JOINT_NAMES
                .iter()
                .zip(&all.joints)
                .map(|(name, errors)| JointScores::new(name, errors, percents))
                .collect(),
        }
    }
}

impl JointScores {
    fn new(name: &str, errors: &JointErrors, percents: &[usize]) -> Self {
        Self {
            joint: name.to_owned(),
            pck: percents.iter().map(|&percent| errors.pck.correct(percent).mean()).collect(),
            auc: errors.pck.area().mean(),
            mpjpe_px: errors.distance_px.mean(),
            rmse_px: errors.squares.length(),
            rmse_percent: errors.squares.percent(),
            labelled: errors.labelled,
            missing: errors.missing,
            unmeasured: errors.unmeasured,
            unlabelled: errors.unlabelled,
            spurious: errors.spurious,
        }
    }
}

/// The interval of a value of sequences that add up. Those that have none are left out.
fn interval<T: Clone + Default>(
    sequences: &[T],
    merge: impl Fn(&mut T, &T),
    value: impl Fn(&T) -> Option<f64>,
    config: &BootstrapConfig,
) -> Option<Interval> {
    // A draw of sequences without a value would have none itself.
    let measured: Vec<&T> = sequences.iter().filter(|sequence| value(sequence).is_some()).collect();
    let of_drawn = |drawn: &[usize]| {
        let mut all = T::default();
        drawn.iter().for_each(|&i| merge(&mut all, measured[i]));
        // Measured sequences have a value together, but for a percentage of a mean of exactly 0.
        value(&all).unwrap_or(f64::NAN)
    };
    (!measured.is_empty()).then(|| bootstrap(measured.len(), config, of_drawn))
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::metric::body::{BodyPrediction, BodyProtocol, BodyTruth};

    const QUICK: BootstrapConfig = BootstrapConfig { resamples: 200, seed: 3 };

    /// Four sequences of a person that stands still, whose predictions are 10, 20, 30 and 40 px
    /// off.
    fn evaluation() -> BodyEvaluation {
        let joints = |down: f32| {
            std::array::from_fn(|k| Some(Vec2::new(50.0 + 3.0 * k as f32, 90.0 + down)))
        };
        let truth = [BodyTruth { t_s: 1.0, joints_px: joints(0.0), size_px: Some(100.0) }];
        let sequences = (1..=4_u16).map(|n| {
            let joints_px = joints(10.0 * f32::from(n));
            let at = |k: u16| BodyPrediction { t_s: 0.05 * f64::from(k), delay_s: 0.02, joints_px };
            let predicted: Vec<_> = (0..40).map(at).collect();
            BodySequence::evaluate(&truth, &predicted, &BodyProtocol::default()).unwrap()
        });
        BodyEvaluation { sequences: sequences.collect() }
    }

    #[test]
    fn the_summary_holds_the_means_over_sequences_and_joints() {
        let summary = evaluation().summary(&[10, 25, 100], &QUICK).unwrap();
        assert_eq!((summary.sequences, summary.resampled.instants), (4, 8_000));
        let shares: Vec<_> = summary.raw.pck.iter().map(|pck| pck.unwrap().estimate).collect();
        assert_eq!(shares, [0.25, 0.5, 1.0]);
        let near = |interval: Option<Interval>, want: f64| {
            let Interval { estimate, low: Some(low), high: Some(high) } = interval.unwrap() else {
                panic!("{interval:?}");
            };
            assert!((estimate - want).abs() < 1e-4, "{estimate}, not {want}");
            assert!(low <= estimate && estimate <= high);
        };
        near(summary.resampled.mpjpe_px, 25.0);
        // This is the root of the mean of 10², 20², 30² and 40².
        near(summary.resampled.rmse_px, 750f64.sqrt());
        // An error of 10 % is correct at 91 of the 100 thresholds, one of 40 % at 61.
        near(summary.resampled.auc, (0.91 + 0.81 + 0.71 + 0.61) / 4.0);
        near(summary.delay_s, 0.02);
        near(summary.rate_hz, 20.0);
        let head = &summary.resampled.joints[0];
        assert_eq!((head.joint.as_str(), head.labelled, head.missing), ("head", 8_000, 0));
        assert!((head.mpjpe_px.unwrap() - 25.0).abs() < 1e-4);
    }

    #[test]
    fn more_joints_in_a_sequence_do_not_outweigh_the_joints_of_others() {
        let mut evaluation = evaluation();
        // The head is never labelled in the first sequence: its mean is over the other three.
        evaluation.sequences[0].raw.joints[0] = JointErrors::default();
        let scores = evaluation.summary(&[40], &QUICK).unwrap().raw;
        let want = (12.0 * 25.0 + 30.0) / 13.0;
        assert!((scores.mpjpe_px.unwrap().estimate - want).abs() < 1e-4);
        assert_eq!(scores.joints[0].labelled, 3 * 36 - 3);
    }

    #[test]
    fn nothing_measured_is_said_as_such_and_thresholds_have_bounds() {
        let summary = BodyEvaluation::default().summary(&[40], &QUICK).unwrap();
        assert_eq!((summary.raw.pck[0], summary.rate_hz), (None, None));
        assert!(summary.raw.curve.is_empty());
        for percent in [0, 101] {
            assert!(BodyEvaluation::default().summary(&[percent], &QUICK).is_err());
        }
    }
}

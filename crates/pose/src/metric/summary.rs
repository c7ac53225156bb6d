//! Scores of one sequence, of all sequences, and the table made of them.

use evpose_core::stats::bootstrap::{BootstrapConfig, Totals, mean_interval, ratio_interval};
use evpose_core::stats::interval::Interval;
use serde::{Deserialize, Serialize};

use super::{
    FingerScores, GestureConfusion, HandError, HandPoints, Pck, palm_errors_percent,
    root_aligned_errors_mm,
};
use crate::{HandParams, PoseError};

/// Pairs of gestures that a summary lists.
const GESTURE_LINES: usize = 60;

/// Scores of a method on one sequence.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SequenceScores {
    /// Distances between wrists, in millimetres.
    pub translation_mm: Totals,
    /// Angles between wrists, in degrees.
    pub rotation_deg: Totals,
    /// Root mean square differences of the articulation.
    pub articulation: Totals,
    /// Errors of 20 points relative to the wrist, in millimetres: their mean is the MPJPE.
    pub points_mm: Totals,
    /// The same errors as a curve.
    pub pck_3d: Pck,
    /// Errors of 7 points in the image, in percent of the palm.
    pub pck_2d: Pck,
    /// Errors of the acceleration of 21 points, in metres per second squared: the jitter.
    pub acceleration_m_s2: Totals,
    /// States of the fingers.
    pub fingers: FingerScores,
}

impl SequenceScores {
    /// Scores the 12 parameters of one frame.
    pub fn push_parameters(&mut self, predicted: &HandParams, truth: &HandParams) {
        let error = HandError::between(predicted, truth);
        self.translation_mm.push(error.translation_mm);
        self.rotation_deg.push(error.rotation_deg);
        self.articulation.push(error.articulation);
    }

    /// Scores the points of one frame.
    pub fn push_points(&mut self, predicted: &HandPoints, truth: &HandPoints) {
        for error_mm in root_aligned_errors_mm(&predicted.world_m, &truth.world_m) {
            self.points_mm.push(error_mm);
            self.pck_3d.push(error_mm);
        }
        self.fingers.push(&predicted.world_m, &truth.world_m);
        self.push_image_points(predicted, truth);
    }

    /// Scores one frame with a hand, of which no pose was predicted: every point is wrong. Means of distances have
    /// no value for it.
    pub fn push_missing(&mut self, truth: &HandPoints, has_space: bool) {
        let nowhere = [None; 21];
        for error_percent in palm_errors_percent(&nowhere, &truth.image_px) {
            self.pck_2d.push(error_percent);
        }
        if has_space {
            (1..truth.world_m.len()).for_each(|_| self.pck_3d.push(f64::INFINITY));
            self.fingers.push_missing();
        }
    }

    /// Scores the acceleration of the points in the middle of three frames, `step_s` apart.
    ///
    /// # Source
    /// The *acceleration error* of Kanazawa et al., *Learning 3D human dynamics from video*,
    /// CVPR 2019.
    pub fn push_acceleration(
        &mut self,
        predicted: [&HandPoints; 3],
        truth: [&HandPoints; 3],
        step_s: f64,
    ) {
        let acceleration = |points: &[&HandPoints; 3], i: usize| {
            // A second difference cancels most digits: single precision would add jitter.
            let [before, now, after] = points.map(|points| points.world_m[i].as_dvec3());
            (before - 2.0 * now + after) / (step_s * step_s)
        };
        for i in 0..predicted[0].world_m.len() {
            let error = acceleration(&predicted, i) - acceleration(&truth, i);
            self.acceleration_m_s2.push(error.length());
        }
    }

    /// Scores the points of one frame in the image alone: those of labels in 2D.
    pub fn push_image_points(&mut self, predicted: &HandPoints, truth: &HandPoints) {
        for error_percent in palm_errors_percent(&predicted.image_px, &truth.image_px) {
            self.pck_2d.push(error_percent);
        }
    }
}

/// Scores of a method on every sequence, in their order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HandEvaluation {
    /// One per sequence.
    pub sequences: Vec<SequenceScores>,
}

impl HandEvaluation {
    /// Means with intervals.
    pub fn summary(&self, config: &BootstrapConfig) -> HandSummary {
        let mean = |totals: fn(&SequenceScores) -> Totals| {
            mean_interval(&self.sequences.iter().map(totals).collect::<Vec<_>>(), config)
        };
        HandSummary {
            sequences: self.sequences.len(),
            frames: self.sequences.iter().map(|s| s.translation_mm.count).sum(),
            translation_mm: mean(|s| s.translation_mm),
            rotation_deg: mean(|s| s.rotation_deg),
            articulation: mean(|s| s.articulation),
            mpjpe_mm: mean(|s| s.points_mm),
            auc_3d: mean(|s| s.pck_3d.area()),
            auc_2d: mean(|s| s.pck_2d.area()),
            acceleration_m_s2: mean(|s| s.acceleration_m_s2),
            fingers: self.fingers(config),
        }
    }

    fn fingers(&self, config: &BootstrapConfig) -> Option<FingerSummary> {
        let mean = |totals: &dyn Fn(&FingerScores) -> Totals| {
            let each: Vec<Totals> = self.sequences.iter().map(|s| totals(&s.fingers)).collect();
            mean_interval(&each, config)
        };
        let mut all = FingerScores::default();
        self.sequences.iter().for_each(|s| all.merge(&s.fingers));
        Some(FingerSummary {
            states: mean(&|fingers| fingers.states())?,
            each: [0, 1, 2, 3, 4].map(|digit| all.right[digit].mean().unwrap_or_default()),
            gesture: mean(&|fingers| fingers.all_right)?,
            majority: all.majority()?,
            gestures: all.gestures().into_iter().take(GESTURE_LINES).collect(),
        })
    }

    /// Mean errors over those of a baseline on the same sequences: below 1 is better than it.
    ///
    /// # Errors
    /// If the baseline was evaluated on another number of sequences.
    pub fn ratios_to(
        &self,
        baseline: &Self,
        config: &BootstrapConfig,
    ) -> Result<HandRatios, PoseError> {
        let (left, right) = (self.sequences.len(), baseline.sequences.len());
        if left != right {
            return Err(PoseError::Unpaired { left, right });
        }
        let ratio = |totals: fn(&SequenceScores) -> Totals| {
            // Paired by sequence, since hard ones are hard for both.
            let pairs = self.sequences.iter().zip(&baseline.sequences);
            let pairs: Vec<_> =
                pairs.map(|(ours, theirs)| (totals(ours), totals(theirs))).collect();
            ratio_interval(&pairs, config)
        };
        Ok(HandRatios {
            translation: ratio(|s| s.translation_mm),
            rotation: ratio(|s| s.rotation_deg),
            articulation: ratio(|s| s.articulation),
        })
    }

    /// The curves over all sequences.
    pub fn curves(&self) -> PckCurves {
        let pooled = |pck: fn(&SequenceScores) -> &Pck| {
            let mut all = Pck::new();
            self.sequences.iter().for_each(|s| all.merge(pck(s)));
            all.curve()
        };
        PckCurves { pck_3d: pooled(|s| &s.pck_3d), pck_2d: pooled(|s| &s.pck_2d) }
    }
}

/// A line of the table: means over all frames, with 95% intervals. None where nothing was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HandSummary {
    /// How many sequences there were.
    pub sequences: usize,
    /// How many frames in all.
    pub frames: u64,
    /// Distance between wrists, in millimetres.
    pub translation_mm: Option<Interval>,
    /// Angle between wrists, in degrees.
    pub rotation_deg: Option<Interval>,
    /// Root mean square difference of the articulation.
    pub articulation: Option<Interval>,
    /// Mean error of 20 points relative to the wrist (MPJPE), in millimetres.
    pub mpjpe_mm: Option<Interval>,
    /// Area under the 3D curve, 0 to 100 mm: larger is better.
    pub auc_3d: Option<Interval>,
    /// Area under the 2D curve, 0 to 100% of the palm: larger is better.
    pub auc_2d: Option<Interval>,
    /// Error of the acceleration of 21 points, in metres per second squared: the jitter.
    #[serde(default)]
    pub acceleration_m_s2: Option<Interval>,
    /// States of the fingers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fingers: Option<FingerSummary>,
}

/// Shares of hands whose fingers are extended, bent or between as they truly are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FingerSummary {
    /// Of all fingers.
    pub states: Interval,
    /// Of each, in the order of [`DIGITS`](super::DIGITS).
    pub each: [f64; 5],
    /// Of hands with all five right.
    pub gesture: Interval,
    /// The share of a hand that is always in the most frequent states.
    pub majority: f64,
    /// Gestures and those that they are taken for, the most frequent pairs.
    pub gestures: Vec<GestureConfusion>,
}

/// Mean errors of one method over those of another, paired by sequence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HandRatios {
    /// Of the translation errors.
    pub translation: Option<Interval>,
    /// Of the rotation errors.
    pub rotation: Option<Interval>,
    /// Of the articulation errors.
    pub articulation: Option<Interval>,
}

/// Shares of correct points at the thresholds 0, 0.1, …, 99.9; empty where nothing was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PckCurves {
    /// Thresholds in millimetres.
    pub pck_3d: Vec<f64>,
    /// Thresholds in percent of the palm.
    pub pck_2d: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;

    /// Each score has a value of its own.
    fn distinct() -> SequenceScores {
        let value = |sum: f64| Totals { sum, count: 2 };
        let pck = |error: f64| {
            let mut pck = Pck::new();
            pck.push(error);
            pck
        };
        SequenceScores {
            translation_mm: value(2.0),
            rotation_deg: value(4.0),
            articulation: value(6.0),
            points_mm: value(8.0),
            pck_3d: pck(10.0),
            pck_2d: pck(40.0),
            acceleration_m_s2: value(10.0),
            fingers: FingerScores::default(),
        }
    }

    #[test]
    fn every_column_of_the_table_is_of_its_own_score() {
        let ours = HandEvaluation { sequences: vec![distinct(), distinct()] };
        let table = ours.summary(&BootstrapConfig::default());
        assert_eq!((table.sequences, table.frames), (2, 4));
        // The first threshold above 10 is 10.1, above 40 it is 40.1: 0.899 and 0.599 are left.
        for (column, wanted) in [
            (table.translation_mm, 1.0),
            (table.rotation_deg, 2.0),
            (table.articulation, 3.0),
            (table.mpjpe_mm, 4.0),
            (table.auc_3d, 0.899),
            (table.auc_2d, 0.599),
            (table.acceleration_m_s2, 5.0),
        ] {
            let Interval { estimate, low, high } = column.expect("measured");
            assert_eq!((estimate, low, high), (wanted, Some(wanted), Some(wanted)));
        }
        let scaled = SequenceScores {
            translation_mm: Totals { sum: 20.0, count: 2 },
            rotation_deg: Totals { sum: 80.0, count: 2 },
            articulation: Totals { sum: 600.0, count: 2 },
            ..distinct()
        };
        let baseline = HandEvaluation { sequences: vec![scaled.clone(), scaled] };
        let ratios = ours.ratios_to(&baseline, &BootstrapConfig::default()).expect("paired");
        let ratios = [ratios.translation, ratios.rotation, ratios.articulation];
        assert_eq!(ratios.map(|ratio| ratio.expect("measured").estimate), [0.1, 0.05, 0.01]);
        let curves = ours.curves();
        for (curve, first) in [(curves.pck_3d, 101), (curves.pck_2d, 401)] {
            assert_eq!(curve.iter().position(|share| *share > 0.0), Some(first));
            assert_eq!((curve.len(), curve[999]), (1_000, 1.0));
        }
    }

    #[test]
    fn parameters_go_to_their_own_scores() {
        let predicted = HandParams {
            articulation: [0.2; 6],
            translation_m: Vec3::Y * 0.002,
            rotation: Vec3::Z * 0.3,
        };
        let mut scores = SequenceScores::default();
        scores.push_parameters(&predicted, &HandParams::default());
        let totals = [scores.translation_mm, scores.rotation_deg, scores.articulation];
        for (totals, wanted) in totals.into_iter().zip([2.0, 0.3f64.to_degrees(), 0.2]) {
            assert!((totals.mean().expect("measured") - wanted).abs() < 1e-4, "{totals:?}");
        }
    }

    #[test]
    fn points_of_the_image_and_of_space_go_to_their_own_curves() {
        let points = |x_px: f32, x_m: f32| HandPoints {
            // The palm is 100 px.
            image_px: std::array::from_fn(|i| Some(Vec2::new(x_px, 100.0 / 9.0 * i as f32))),
            world_m: std::array::from_fn(|i| Vec3::new(if i > 0 { x_m } else { 0.0 }, 0.0, 1.0)),
        };
        let (truth, predicted) = (points(0.0, 0.0), points(30.05, 0.00705));
        let mut scores = SequenceScores::default();
        scores.push_points(&predicted, &truth);
        assert_eq!((scores.pck_3d.len(), scores.pck_2d.len(), scores.points_mm.count), (20, 7, 20));
        assert!((scores.points_mm.mean().expect("measured") - 7.05).abs() < 1e-4);
        // 30.1 and 7.1 are the first thresholds above.
        for (pck, wanted) in [(&scores.pck_2d, 0.699), (&scores.pck_3d, 0.929)] {
            assert!((pck.area().mean().expect("measured") - wanted).abs() < 1e-12, "{pck:?}");
        }
        let mut image = SequenceScores::default();
        image.push_image_points(&predicted, &truth);
        assert_eq!((&image.pck_2d, image.pck_3d.len()), (&scores.pck_2d, 0));
    }

    #[test]
    fn methods_on_different_sequences_are_not_compared() {
        let of = |count| HandEvaluation { sequences: vec![distinct(); count] };
        let error = of(2).ratios_to(&of(3), &BootstrapConfig::default());
        assert_eq!(error, Err(PoseError::Unpaired { left: 2, right: 3 }));
    }

    #[test]
    fn nothing_measured_is_said_as_such() {
        let empty = HandEvaluation::default();
        assert_eq!(empty.summary(&BootstrapConfig::default()).auc_3d, None);
        assert!(empty.curves().pck_2d.is_empty());
    }

    #[test]
    fn steady_motion_has_no_jitter_and_a_shake_has_that_of_its_second_difference() {
        let at = |x_m: f32| HandPoints { world_m: [Vec3::X * x_m; 21], image_px: [None; 21] };
        let truth = [at(0.0), at(0.125), at(0.25)];
        let shaken = [at(0.0), at(0.126), at(0.25)];
        let mut scores = SequenceScores::default();
        scores.push_acceleration(truth.each_ref(), truth.each_ref(), 1e-3);
        assert_eq!(scores.acceleration_m_s2.mean(), Some(0.0));
        let mut scores = SequenceScores::default();
        scores.push_acceleration(shaken.each_ref(), truth.each_ref(), 1e-3);
        // Twice a millimetre in a millisecond squared.
        let mean = scores.acceleration_m_s2.mean().expect("measured");
        assert!((mean - 2000.0).abs() < 1.0, "{mean}");
    }
}

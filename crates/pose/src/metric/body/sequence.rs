//! Errors of one sequence.

use evpose_core::stats::bootstrap::Totals;

use super::track::{Pose, Tracks};
use super::{BodyErrors, BodyPrediction, BodyProtocol, BodyTruth, MissingJoints};
use crate::PoseError;
use crate::body::BODY_JOINTS;

/// Scores of a method on one sequence.
///
/// The published program computes the PCK of a sequence from `resampled` and that of all sequences
/// together from `raw`; MPJPE and RMSE come from `resampled` in both.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodySequence {
    /// Errors at evenly spaced instants: uniform weight over the sequence's time.
    pub resampled: BodyErrors,
    /// Errors at the instants of predictions: each prediction weighs the same.
    pub raw: BodyErrors,
    /// Latencies of predictions, in seconds.
    pub delay_s: Totals,
    /// Times between predictions, in seconds.
    pub gap_s: Totals,
    /// Errors of the acceleration over three predictions in a row, in px/s²: the jitter.
    pub acceleration_px_s2: Totals,
    /// Predictions outside the evaluated part of the sequence.
    pub skipped: u64,
}

impl BodySequence {
    /// Compares predictions with the truth.
    ///
    /// # Errors
    /// If there are no labels, the last of them comes before the sequence begins, something is not
    /// finite, or a setting is out of its range.
    pub fn evaluate(
        truth: &[BodyTruth],
        predicted: &[BodyPrediction],
        protocol: &BodyProtocol,
    ) -> Result<Self, PoseError> {
        let tracks = Tracks::new(truth, predicted, protocol)?;
        let instants = protocol.instants(tracks.end_s)?;
        let kept = tracks.predicted.poses();
        let push = match protocol.missing {
            MissingJoints::Counted => BodyErrors::push,
            MissingJoints::Published { .. } => BodyErrors::push_published,
        };
        let mut sequence =
            Self { skipped: (predicted.len() - kept.len()) as u64, ..Self::default() };
        let mut labels = tracks.truth.sampler();
        // Predictions are in time order, and a sampler can only go forwards.
        let truth: Vec<Pose> = kept.iter().map(|(t_s, _)| labels.at(*t_s)).collect();
        for ((_, pose), truth) in kept.iter().zip(&truth) {
            push(&mut sequence.raw, pose, truth);
        }
        // Three in a row are the fewest that have an acceleration.
        for (kept, truth) in kept.windows(3).zip(truth.windows(3)) {
            let times_s = [kept[0].0, kept[1].0, kept[2].0];
            let errors = acceleration_errors(times_s, [0, 1, 2].map(|k| (&kept[k].1, &truth[k])));
            errors.for_each(|px_s2| sequence.acceleration_px_s2.push(px_s2));
        }
        // The published program resamples nothing where nothing was predicted.
        if !kept.is_empty() || protocol.missing == MissingJoints::Counted {
            let (mut labels, mut predictions) =
                (tracks.truth.sampler(), tracks.predicted.sampler());
            for t_s in instants {
                push(&mut sequence.resampled, &predictions.at(t_s), &labels.at(t_s));
            }
        }
        // Latencies are not part of the tracks, so that the same predictions are chosen again.
        for prediction in predicted.iter().filter(|prediction| tracks.counts(prediction.t_s)) {
            sequence.delay_s.push(prediction.delay_s);
        }
        for pair in kept.windows(2) {
            sequence.gap_s.push(pair[1].0 - pair[0].0);
        }
        Ok(sequence)
    }
}

/// Lengths of the differences of predicted and true acceleration, of the joints that all three
/// instants have; none where two instants are one.
fn acceleration_errors(
    [a_s, b_s, c_s]: [f64; 3],
    poses: [(&Pose, &Pose); 3],
) -> impl Iterator<Item = f64> {
    let (before_s, after_s) = (b_s - a_s, c_s - b_s);
    let error = move |joint: usize| {
        let of = |(predicted, truth): (&Pose, &Pose)| {
            Some(predicted.joints[joint]? - truth.joints[joint]?)
        };
        let [a, b, c] = [of(poses[0])?, of(poses[1])?, of(poses[2])?];
        // A second difference over uneven steps.
        let change = (c - b) / after_s - (b - a) / before_s;
        Some((change / (0.5 * (before_s + after_s))).length())
    };
    let all = (before_s > 0.0 && after_s > 0.0).then(|| (0..BODY_JOINTS).filter_map(error));
    all.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::body::{BodyPoints, number};

    /// A person that moves to the right by 100 px a second; the torso's diagonal is 50 px.
    fn points(t_s: f64) -> BodyPoints {
        let mut points = [Some(Vec2::new(100.0 + 100.0 * t_s as f32, 100.0)); BODY_JOINTS];
        points[number::HIP_L] = points[number::HIP_L].map(|hip| hip + Vec2::new(30.0, 40.0));
        points
    }

    fn truth() -> Vec<BodyTruth> {
        (0..=20)
            .map(|k| BodyTruth::by_torso(0.1 * f64::from(k), points(0.1 * f64::from(k))))
            .collect()
    }

    /// Too far down by `error_px`, ten times a second.
    fn predicted(error_px: f32) -> Vec<BodyPrediction> {
        let at = |k: u32| {
            let t_s = 0.1 * f64::from(k) + 0.05;
            let joints_px = points(t_s.min(2.0)).map(|p| p.map(|p| p + Vec2::new(0.0, error_px)));
            BodyPrediction { t_s, delay_s: 0.01 * f64::from(k % 2), joints_px }
        };
        (0..30).map(at).collect()
    }

    fn evaluate(predicted: &[BodyPrediction]) -> BodySequence {
        BodySequence::evaluate(&truth(), predicted, &BodyProtocol::default()).unwrap()
    }

    #[test]
    fn a_constant_error_is_found_again() {
        let sequence = evaluate(&predicted(20.0));
        // From 0.3 to 3 s, as the sequence ends at 3 s.
        assert_eq!((sequence.raw.instants, sequence.skipped), (27, 3));
        assert_eq!(sequence.resampled.instants, 3_000);
        assert!((sequence.raw.mpjpe_px().unwrap() - 20.0).abs() < 1e-4);
        assert_eq!((sequence.raw.pck(39), sequence.raw.pck(41)), (Some(0.0), Some(1.0)));
        assert!((sequence.delay_s.mean().unwrap() - 14.0 / 27.0 * 0.01).abs() < 1e-12);
        assert!((sequence.gap_s.mean().unwrap() - 0.1).abs() < 1e-12);
    }

    #[test]
    fn the_first_prediction_stands_for_the_time_before_it() {
        let sequence = evaluate(&predicted(0.0));
        // At 0 s the first one, of 0.35 s, is 35 px ahead: 70 % of the torso. At 2 s, between two
        // predictions, the person comes to rest: 2.5 px less in a triangle of 100 ms.
        assert!(sequence.raw.mpjpe_px().unwrap() < 1e-4);
        let errors = &sequence.resampled.joints[3];
        let want = 35.0 * 351.0 / 2.0 + 2.5 * 100.0 / 2.0;
        assert!((errors.distance_px.sum - want).abs() < 0.1, "{errors:?}");
        assert_eq!(errors.pck.correct(71).sum, 3_000.0);
    }

    #[test]
    fn a_steady_error_is_no_jitter_and_a_shake_has_that_of_its_second_difference() {
        // The truth comes to rest at 2 s, and nothing accelerates before.
        let mut steady = predicted(20.0);
        steady.truncate(19);
        let mean = |predicted: &[BodyPrediction]| evaluate(predicted).acceleration_px_s2.mean();
        assert!(mean(&steady).unwrap() < 0.05);
        for (k, prediction) in steady.iter_mut().enumerate() {
            let shake = Vec2::new(0.0, if k % 2 == 0 { 1.0 } else { -1.0 });
            prediction.joints_px = prediction.joints_px.map(|joint| joint.map(|at| at + shake));
        }
        // From 1 to -1 and back in steps of 0.1 s: 4 px / (0.1 s)².
        assert!((mean(&steady).unwrap() - 400.0).abs() < 0.1, "{:?}", mean(&steady));
    }

    #[test]
    fn the_order_of_predictions_and_labels_does_not_matter() {
        let (mut mixed, mut labels) = (predicted(9.0), truth());
        mixed.reverse();
        labels.reverse();
        let sequence = BodySequence::evaluate(&labels, &mixed, &BodyProtocol::default()).unwrap();
        let want = evaluate(&predicted(9.0));
        assert_eq!((sequence.raw, sequence.resampled), (want.raw, want.resampled));
    }

    #[test]
    fn a_method_that_finds_nobody_is_always_wrong() {
        let empty = evaluate(&[]);
        assert_eq!((empty.resampled.pck(100), empty.resampled.mpjpe_px()), (Some(0.0), None));
        assert_eq!(empty.resampled.joints[0].missing, 3_000);
        let published = BodyProtocol::published(640.0, 480.0);
        let empty = BodySequence::evaluate(&truth(), &[], &published).unwrap();
        assert_eq!(empty, BodySequence::default());
    }

    #[test]
    fn a_joint_that_is_lost_once_is_missing_until_it_is_found_again() {
        let mut lost = predicted(0.0);
        lost[10].joints_px[number::WRIST_L] = None;
        let sequence = evaluate(&lost);
        let [resampled, raw] = [&sequence.resampled, &sequence.raw].map(|e| e.joints[5].missing);
        // Between 0.95 and 1.15 s.
        assert!((199..=200).contains(&resampled) && raw == 1, "{resampled} {raw}");
    }

    #[test]
    fn sequences_that_cannot_be_evaluated_are_refused() {
        let evaluate = |truth: &[BodyTruth], predicted: &[BodyPrediction]| {
            BodySequence::evaluate(truth, predicted, &BodyProtocol::default()).unwrap_err()
        };
        assert_eq!(evaluate(&[], &[]), PoseError::NoLabels);
        let early = [BodyTruth::by_torso(-2.0, points(0.0))];
        assert!(matches!(evaluate(&early, &[]), PoseError::OutOfRange { .. }));
        let mut bad = predicted(0.0);
        bad[29].delay_s = f64::NAN;
        assert_eq!(evaluate(&truth(), &bad), PoseError::NotFinite { what: "prediction", row: 29 });
    }
}

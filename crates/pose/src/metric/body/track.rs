//! Joints over time, between the instants at which they are known.

use glam::{DVec2, Vec2};

use super::{BodyPrediction, BodyProtocol, BodyTruth, MissingJoints};
use crate::PoseError;
use crate::body::{BODY_JOINTS, BodyPoints};

/// Time from the last label to the end of a sequence.
const AFTER_LAST_S: f64 = 1.0;

/// Stands for a missing label in published files.
const UNLABELLED: DVec2 = DVec2::NEG_ONE;
/// Stands for a missing size in published files.
const NO_SIZE: f64 = -1.0;

/// The truth of a sequence and those of its predictions that count.
#[derive(Debug)]
pub(super) struct Tracks {
    pub(super) truth: Track,
    pub(super) predicted: Track,
    /// Predictions count after this.
    begin_s: f64,
    /// The end of the sequence.
    pub(super) end_s: f64,
}

impl Tracks {
    /// # Errors
    /// If there are no labels, the last of them comes before 0, or something is not finite.
    pub(super) fn new(
        truth: &[BodyTruth],
        predicted: &[BodyPrediction],
        protocol: &BodyProtocol,
    ) -> Result<Self, PoseError> {
        let truth = Track::of_truth(truth, protocol.missing)?;
        let predicted = Track::of_predictions(predicted, protocol.missing)?;
        let (last_s, _) = truth.poses.last().ok_or(PoseError::NoLabels)?;
        let field = "time of the last label in seconds";
        PoseError::unless(*last_s >= 0.0, field, *last_s, "0 or later")?;
        let end_s = last_s + AFTER_LAST_S;
        let mut tracks = Self { truth, predicted, begin_s: protocol.skipped_share * end_s, end_s };
        // Predictions are dropped last: which of them count depends on the end, which the labels set.
        let mut poses = std::mem::take(&mut tracks.predicted.poses);
        poses.retain(|(t_s, _)| tracks.counts(*t_s));
        tracks.predicted.poses = poses;
        Ok(tracks)
    }

    /// Whether a prediction of this time counts.
    pub(super) fn counts(&self, t_s: f64) -> bool {
        self.begin_s < t_s && t_s < self.end_s
    }
}

/// A body at an instant.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pose {
    /// In pixels.
    pub(super) joints: [Option<DVec2>; BODY_JOINTS],
    /// In pixels.
    pub(super) size: Option<f64>,
}

impl Pose {
    fn between(before: &Self, after: &Self, passed_s: f64, interval_s: f64) -> Self {
        // The order of NumPy's `interp`.
        let joint = |k: usize| {
            let (a, b) = before.joints[k].zip(after.joints[k])?;
            Some((b - a) / interval_s * passed_s + a)
        };
        let size = before.size.zip(after.size);
        Self {
            joints: std::array::from_fn(joint),
            size: size.map(|(a, b)| (b - a) / interval_s * passed_s + a),
        }
    }
}

/// Poses in the order of time.
#[derive(Debug)]
pub(super) struct Track {
    poses: Vec<(f64, Pose)>,
}

impl Track {
    /// Sorted by time; those of the same instant stay as they follow each other.
    ///
    /// # Errors
    /// If a time, a position or a size is not finite.
    fn of_truth(truth: &[BodyTruth], missing: MissingJoints) -> Result<Self, PoseError> {
        let (joint, size) = match missing {
            MissingJoints::Counted => (None, None),
            MissingJoints::Published { .. } => (Some(UNLABELLED), Some(NO_SIZE)),
        };
        let poses = truth.iter().enumerate().map(|(row, truth)| {
            let joints = filled(&truth.joints_px, joint);
            let pose = Pose { joints, size: truth.size_px.map(f64::from).or(size) };
            // An unknown size is no fault; only one that is not finite is.
            check("label", row, [truth.t_s, pose.size.unwrap_or(0.0)], &pose)?;
            Ok((truth.t_s, pose))
        });
        poses.collect::<Result<_, _>>().map(Self::sorted)
    }

    /// As [`of_truth`](Self::of_truth).
    fn of_predictions(
        predicted: &[BodyPrediction],
        missing: MissingJoints,
    ) -> Result<Self, PoseError> {
        let joint = match missing {
            MissingJoints::Counted => None,
            MissingJoints::Published { width_px, height_px } => {
                // As published: a missing joint is at minus the size of the image.
                Some(-DVec2::new(width_px.into(), height_px.into()))
            }
        };
        let poses = predicted.iter().enumerate().map(|(row, predicted)| {
            let pose = Pose { joints: filled(&predicted.joints_px, joint), size: None };
            check("prediction", row, [predicted.t_s, predicted.delay_s], &pose)?;
            Ok((predicted.t_s, pose))
        });
        poses.collect::<Result<_, _>>().map(Self::sorted)
    }

    fn sorted(mut poses: Vec<(f64, Pose)>) -> Self {
        poses.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        Self { poses }
    }

    pub(super) fn poses(&self) -> &[(f64, Pose)] {
        &self.poses
    }

    /// Ready to be asked at instants that ascend.
    pub(super) fn sampler(&self) -> Sampler<'_> {
        Sampler { poses: &self.poses, at: 0 }
    }
}

/// Answers for instants that ascend.
pub(super) struct Sampler<'a> {
    poses: &'a [(f64, Pose)],
    /// The last pose that is not after the instant, but for instants before all.
    at: usize,
}

impl Sampler<'_> {
    /// The pose at `t_s`: between two, the first one before it and the last one after it; nothing
    /// known where there are none.
    pub(super) fn at(&mut self, t_s: f64) -> Pose {
        while self.poses.get(self.at + 1).is_some_and(|(next_s, _)| *next_s <= t_s) {
            self.at += 1;
        }
        let Some((before_s, before)) = self.poses.get(self.at) else { return Pose::default() };
        match self.poses.get(self.at + 1) {
            // On a pose itself nothing is interpolated: joints that the next one lacks still count.
            Some((after_s, after)) if t_s > *before_s => {
                Pose::between(before, after, t_s - before_s, after_s - before_s)
            }
            _ => *before,
        }
    }
}

fn filled(joints: &BodyPoints, missing: Option<DVec2>) -> [Option<DVec2>; BODY_JOINTS] {
    joints.map(|joint| joint.map(Vec2::as_dvec2).or(missing))
}

fn check(what: &'static str, row: usize, times: [f64; 2], pose: &Pose) -> Result<(), PoseError> {
    let mut joints = pose.joints.iter().flatten();
    let are_finite = times.into_iter().all(f64::is_finite) && joints.all(|joint| joint.is_finite());
    if are_finite { Ok(()) } else { Err(PoseError::NotFinite { what, row }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All joints at `x`, but for the head.
    fn truth(t_s: f64, x: f32, head: Option<f32>, size_px: Option<f32>) -> BodyTruth {
        let mut joints_px = [Some(Vec2::new(x, 2.0 * x)); BODY_JOINTS];
        joints_px[0] = head.map(|x| Vec2::new(x, 0.0));
        BodyTruth { t_s, joints_px, size_px }
    }

    #[test]
    fn poses_are_interpolated_between_instants_and_held_at_both_ends() {
        let truth = [truth(3.0, 30.0, None, Some(5.0)), truth(1.0, 10.0, Some(1.0), Some(3.0))];
        let track = Track::of_truth(&truth, MissingJoints::Counted).unwrap();
        let mut sampler = track.sampler();
        let mut at = |t_s| {
            let pose = sampler.at(t_s);
            (pose.joints[5].unwrap().x, pose.joints[0].map(|head| head.x), pose.size.unwrap())
        };
        assert_eq!(at(0.0), (10.0, Some(1.0), 3.0));
        assert_eq!(at(1.0), (10.0, Some(1.0), 3.0));
        assert_eq!(at(1.5), (15.0, None, 3.5));
        assert_eq!(at(3.0), (30.0, None, 5.0));
        assert_eq!(at(9.0), (30.0, None, 5.0));
    }

    #[test]
    fn published_interpolation_runs_through_what_stands_for_nothing() {
        let truth = [truth(0.0, 10.0, Some(9.0), None), truth(1.0, 10.0, None, None)];
        let published = MissingJoints::Published { width_px: 640.0, height_px: 480.0 };
        let track = Track::of_truth(&truth, published).unwrap();
        let pose = track.sampler().at(0.5);
        assert_eq!((pose.joints[0], pose.size), (Some(DVec2::new(4.0, -0.5)), Some(-1.0)));
        let nothing = BodyPrediction { t_s: 0.0, delay_s: 0.0, joints_px: [None; BODY_JOINTS] };
        let track = Track::of_predictions(&[nothing], published).unwrap();
        assert_eq!(track.sampler().at(7.0).joints, [Some(DVec2::new(-640.0, -480.0)); BODY_JOINTS]);
    }

    #[test]
    fn an_empty_track_knows_nothing() {
        let track = Track::of_truth(&[], MissingJoints::Counted).unwrap();
        assert_eq!(track.sampler().at(1.0).joints, [None; BODY_JOINTS]);
    }

    #[test]
    fn what_is_not_finite_is_named() {
        let good = truth(0.0, 1.0, None, None);
        for bad in [
            truth(f64::NAN, 1.0, None, None),
            truth(0.0, f32::INFINITY, None, None),
            truth(0.0, 1.0, None, Some(f32::NAN)),
        ] {
            let fault = Track::of_truth(&[good.clone(), bad], MissingJoints::Counted).unwrap_err();
            assert_eq!(fault, PoseError::NotFinite { what: "label", row: 1 });
        }
    }
}

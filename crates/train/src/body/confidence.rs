//! The scores below which a joint is not drawn and a pose is of nobody, calibrated on validation images.
//!
//! # Model
//! A joint of a label is in view or not. A found one is right within [`RIGHT_TORSOS`] of the
//! torso's length of a joint that is in view, and spurious where none is. The threshold is the
//! highest of [`THRESHOLDS`] steps that gives up at most [`GIVEN_UP`] of the right joints: what is
//! gained are spurious and wrong ones that are not drawn. The threshold of poses is the highest of
//! hundredths that gives up at most [`GIVEN_UP_BY_POSES`] of the right joints, with poses that score
//! lower: what is gained are poses of nobody.

use evpose_pose::body::{BODY_JOINTS, BodyJoint, BodyLabel, BodyPoints, pose_score};
use evpose_pose::metric::body::BodyTruth;
use evpose_task::body::{BodyCheckpoint, BodyPredictor, BodyPredictorOptions};
use glam::Vec2;
use rayon::prelude::*;

use super::frames::BodyFrames;
use crate::TrainError;

const RIGHT_TORSOS: f32 = 0.4;
const GIVEN_UP: f64 = 0.01;
/// Of images of all that is randomised, where poses of people and of things that move overlap: a lower
/// share would leave most of the latter: see `docs/guide/poses.md`.
const GIVEN_UP_BY_POSES: f64 = 0.08;
const THRESHOLDS: usize = 60;
/// The lowest threshold, the published one, and the highest.
const LOWEST: f64 = 0.01;
const HIGHEST: f64 = 0.6;

/// Scores of the joints that a network found.
#[derive(Debug, Clone, Default, PartialEq)]
struct FoundScores {
    /// Of right joints.
    right: Vec<f32>,
    /// Of joints that are not in view.
    spurious: Vec<f32>,
    /// Of all joints of an image, with the number of right ones among them.
    poses: Vec<([f32; BODY_JOINTS], usize)>,
}

impl FoundScores {
    fn push(&mut self, joints: &[BodyJoint], label: &BodyLabel, size_px: Vec2) {
        let mut labelled: BodyPoints = BodyPoints::default();
        for (point, keypoint) in labelled.iter_mut().zip(&label.keypoints) {
            *point = keypoint.is_labelled().then(|| keypoint.position * size_px);
        }
        // Distances are in torsos: images show people of any size.
        let torso_px = BodyTruth::by_torso(0.0, labelled).size_px;
        // How many joints of this pose are right is the difference.
        let right_before = self.right.len();
        let mut scores = [0.0; BODY_JOINTS];
        for (score, joint) in scores.iter_mut().zip(joints) {
            *score = joint.score;
        }
        for (joint, truth) in joints.iter().zip(labelled) {
            let Some(at) = joint.position else { continue };
            match (truth, torso_px) {
                (None, _) => self.spurious.push(joint.score),
                (Some(truth), Some(torso_px)) => {
                    if truth.distance(at * size_px) <= RIGHT_TORSOS * torso_px {
                        self.right.push(joint.score);
                    }
                }
                // Without a torso there is no measure.
                (Some(_), None) => {}
            }
        }
        self.poses.push((scores, self.right.len() - right_before));
    }

    fn merge(mut self, other: Self) -> Self {
        self.right.extend(other.right);
        self.spurious.extend(other.spurious);
        self.poses.extend(other.poses);
        self
    }

    fn threshold(&self) -> Option<f32> {
        if self.right.is_empty() {
            return None;
        }
        let most = (GIVEN_UP * self.right.len() as f64).floor() as usize;
        let at = |step: usize| {
            // Scores spread over decades, so the steps are geometric.
            let share = step as f64 / (THRESHOLDS - 1) as f64;
            (LOWEST * (HIGHEST / LOWEST).powf(share)) as f32
        };
        let lost = |threshold: f32| self.right.iter().filter(|score| **score < threshold).count();
        (0..THRESHOLDS).rev().map(at).find(|threshold| lost(*threshold) <= most)
    }

    /// The threshold of poses whose joints with scores below `threshold` are dropped.
    fn min_score(&self, threshold: f32) -> Option<f32> {
        if self.right.is_empty() {
            return None;
        }
        // Joints below it are not reported, so a pose must not score by them either.
        let cut = |score: f32| if score < threshold { 0.0 } else { score };
        let score = |scores: &[f32; BODY_JOINTS]| pose_score(&scores.map(cut));
        let poses: Vec<(f32, usize)> =
            self.poses.iter().map(|(scores, right)| (score(scores), *right)).collect();
        let lost = |min_score: f32| -> usize {
            poses.iter().filter(|(score, _)| *score < min_score).map(|(_, right)| right).sum()
        };
        let most = (GIVEN_UP_BY_POSES * self.right.len() as f64).floor() as usize;
        (0..=60u8).rev().map(|k| 0.01 * f32::from(k)).find(|min_score| lost(*min_score) <= most)
    }
}

/// Puts the thresholds into a checkpoint that it has on validation images.
///
/// # Errors
/// If the network cannot be compiled.
pub(super) fn calibrate_confidence(
    checkpoint: &mut BodyCheckpoint,
    frames: &BodyFrames,
    samples: usize,
) -> Result<(), TrainError> {
    // Every joint, since thresholds are chosen from the scores of wrong ones, too.
    let options =
        BodyPredictorOptions { confidence: Some(LOWEST as f32), ..BodyPredictorOptions::default() };
    let predictor = BodyPredictor::new(checkpoint, options, None)?;
    let count = samples.min(frames.len());
    let scores = (0..count)
        .into_par_iter()
        .map_init(
            || predictor.another(),
            |predictor, k| {
                // Spread over all images, which are sorted by sequence.
                let frame = &frames.frames[k * frames.len() / count];
                let size_px = Vec2::new(frame.image.width() as f32, frame.image.height() as f32);
                let mut scores = FoundScores::default();
                scores.push(&predictor.joints(&frame.image), &frame.label, size_px);
                scores
            },
        )
        .reduce(FoundScores::default, FoundScores::merge);
    // Without a right joint nothing can be calibrated, and the defaults stay.
    if let Some(threshold) = scores.threshold() {
        checkpoint.config.decoding.confidence = threshold;
        if let Some(min_score) = scores.min_score(threshold) {
            checkpoint.config.detection.min_score = min_score;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_gives_up_one_right_joint_in_a_hundred() {
        let right: Vec<f32> = (1..=1000).map(|k| 0.001 * k as f32).collect();
        let scores =
            FoundScores { right: right.clone(), spurious: vec![0.005; 10], poses: Vec::new() };
        let threshold = scores.threshold().unwrap();
        let lost = right.iter().filter(|score| **score < threshold).count();
        assert!(lost <= 10, "{lost} lost at {threshold}");
        assert!(threshold >= 0.01);
        let certain = FoundScores { right: vec![0.5; 100], ..FoundScores::default() };
        assert!(certain.threshold().unwrap() > 0.4);
        assert_eq!(FoundScores::default().threshold(), None);
    }

    #[test]
    fn poses_of_a_low_score_are_given_up_with_few_right_joints() {
        // The higher a pose scores, the more of its joints are right.
        let poses: Vec<_> =
            (0..60).map(|k| ([0.01 * k as f32 + 0.005; BODY_JOINTS], k as usize / 10)).collect();
        let right = vec![0.5; poses.iter().map(|(_, right)| right).sum()];
        let scores = FoundScores { right, spurious: Vec::new(), poses };
        // Of 150 right joints, 12 may be lost: the ten of 0.1 to 0.2, and two of those above.
        let min_score = scores.min_score(0.0).unwrap();
        assert!((min_score - 0.21).abs() < 1e-6, "{min_score}");
        assert_eq!(scores.min_score(0.3), Some(0.0), "joints that are left out score nothing");
        assert_eq!(FoundScores::default().min_score(0.1), None);
    }

    #[test]
    fn joints_out_of_view_are_spurious_and_near_ones_right() {
        use evpose_pose::body::{Keypoint, Visibility};
        let keypoint = |k: usize| Keypoint {
            position: Vec2::new(0.1, 0.05 * k as f32),
            visibility: if k == 5 { Visibility::Unlabelled } else { Visibility::Visible },
        };
        let label =
            BodyLabel { keypoints: (0..13).map(keypoint).collect(), ..BodyLabel::default() };
        let joint = |k: usize| BodyJoint {
            position: Some(Vec2::new(if k == 3 { 0.9 } else { 0.1 }, 0.05 * k as f32)),
            score: 0.1 * k as f32,
        };
        let joints: Vec<BodyJoint> = (0..13).map(joint).collect();
        let mut scores = FoundScores::default();
        scores.push(&joints, &label, Vec2::splat(100.0));
        assert_eq!(scores.spurious, [0.5]);
        assert_eq!(scores.right.len(), 11, "all but one out of view and one far away");
    }
}

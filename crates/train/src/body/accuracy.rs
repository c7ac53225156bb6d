//! The share of correctly detected joints, which training logs for each batch.

use evpose_pose::body::{BodyJoint, BodyLabel, number};
use glam::Vec2;
use serde::{Deserialize, Serialize};

/// The length that errors are relative to. Lengths are relative to the image's width and height, so
/// that in an image wider than high an error counts for more upright than across, as published.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyMeasure {
    /// The mean of the torso's two diagonals, from hips to the shoulders of the other sides; one of
    /// them if the other is not known, the length in the annotation if none is.
    #[default]
    Torso,
    /// The torso's length in the annotation, if there is one, otherwise as `Torso`. Published
    /// annotations of eH3.6M have the lengths of other parts there.
    WrittenTorso,
    /// The head's size in the annotation.
    Head,
}

/// The criterion of a correct detection.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BodyAccuracyConfig {
    /// The length that errors are relative to.
    pub measure: BodyMeasure,
    /// The largest error, relative to it.
    pub threshold: f32,
}

impl Default for BodyAccuracyConfig {
    /// As published for all data but MPII, for which half of the head's size is allowed.
    fn default() -> Self {
        Self { measure: BodyMeasure::Torso, threshold: 0.2 }
    }
}

/// Counts of correctly detected joints.
///
/// # Model
/// A detection is correct if it is at most `threshold` times the measure from where it should be.
/// The share of those labelled is taken for each joint, then their mean, so that joints seldom
/// labelled count as much.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BodyAccuracy {
    correct: Vec<u64>,
    labelled: Vec<u64>,
    without_measure: u64,
}

impl BodyMeasure {
    /// The length for a person; none if it is not known.
    pub fn length(self, label: &BodyLabel) -> Option<f32> {
        let written = |size: Option<f32>| size.filter(|size| *size > 0.0);
        match self {
            Self::Torso => torso(label).or(written(label.torso_size)),
            Self::WrittenTorso => written(label.torso_size).or_else(|| torso(label)),
            Self::Head => written(label.head_size_scaled),
        }
    }
}

/// The mean of the diagonals that are known.
fn torso(label: &BodyLabel) -> Option<f32> {
    let at = |joint: usize| Some(label.keypoints.get(joint)?).filter(|at| at.is_labelled());
    let diagonal =
        |[hip, shoulder]: [usize; 2]| Some(at(hip)?.position.distance(at(shoulder)?.position));
    let diagonals = [[number::HIP_L, number::SHOULDER_R], [number::HIP_R, number::SHOULDER_L]];
    // Both diagonals are of nearly one length, so one stands for both if a joint is not labelled.
    match diagonals.map(diagonal) {
        [Some(a), Some(b)] => Some(0.5 * (a + b)),
        [one, other] => one.or(other),
    }
}

impl BodyAccuracy {
    /// No counts yet, for bodies of `joints` joints.
    pub fn new(joints: usize) -> Self {
        Self { correct: vec![0; joints], labelled: vec![0; joints], without_measure: 0 }
    }

    /// Counts the joints of one body, compared with its label.
    ///
    /// # Panics
    /// If the counts of joints differ.
    pub fn push(
        &mut self,
        config: BodyAccuracyConfig,
        detections: &[BodyJoint],
        label: &BodyLabel,
    ) {
        let (joints, truth) = (self.correct.len(), &label.keypoints);
        assert_eq!([detections.len(), truth.len()], [joints; 2], "as many joints everywhere");
        // Without its measure, an error has no unit.
        let Some(measure) = config.measure.length(label) else {
            self.without_measure += 1;
            return;
        };
        let max_error = config.threshold * measure;
        for (joint, (detection, truth)) in detections.iter().zip(truth).enumerate() {
            if !truth.is_labelled() {
                continue;
            }
            let is_near = |at: Vec2| at.distance(truth.position) <= max_error;
            // A joint that was not detected is wrong.
            let is_correct = detection.position.is_some_and(is_near);
            self.correct[joint] += u64::from(is_correct);
            self.labelled[joint] += 1;
        }
    }

    /// The share of correct detections of each joint; none where it was never labelled.
    pub fn per_joint(&self) -> Vec<Option<f64>> {
        let share = |(&correct, &labelled): (&u64, &u64)| {
            (labelled > 0).then(|| correct as f64 / labelled as f64)
        };
        self.correct.iter().zip(&self.labelled).map(share).collect()
    }

    /// The mean over joints that were labelled; none without any.
    pub fn mean(&self) -> Option<f64> {
        let shares: Vec<f64> = self.per_joint().into_iter().flatten().collect();
        (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
    }

    /// Bodies that were not counted because nothing was known to compare errors with.
    pub fn without_measure(&self) -> u64 {
        self.without_measure
    }
}

#[cfg(test)]
mod tests {
    use evpose_pose::body::{Keypoint, Visibility};

    use super::*;

    /// Shoulders a fifth apart, hips half of the image below: diagonals of `0.5385`.
    fn label() -> BodyLabel {
        let mut positions = [Vec2::splat(0.5); 13];
        // Both diagonals are 0.2 wide and 0.5 high: sqrt(0.29) long.
        positions[number::SHOULDER_L] = Vec2::new(0.6, 0.2);
        positions[number::SHOULDER_R] = Vec2::new(0.4, 0.2);
        positions[number::HIP_L] = Vec2::new(0.6, 0.7);
        positions[number::HIP_R] = Vec2::new(0.4, 0.7);
        let keypoints =
            positions.map(|position| Keypoint { position, visibility: Visibility::Visible });
        BodyLabel {
            keypoints: keypoints.to_vec(),
            center: Vec2::splat(0.5),
            ..BodyLabel::default()
        }
    }

    fn off(label: &BodyLabel, by: impl Fn(usize) -> Vec2) -> Vec<BodyJoint> {
        let joint = |(joint, at): (usize, &Keypoint)| BodyJoint {
            position: Some(at.position + by(joint)),
            score: 1.0,
        };
        label.keypoints.iter().enumerate().map(joint).collect()
    }

    #[test]
    fn a_fifth_of_the_torso_is_allowed() {
        let (config, label) = (BodyAccuracyConfig::default(), label());
        let allowed = 0.2 * 0.29f32.sqrt();
        let mut accuracy = BodyAccuracy::new(13);
        let error =
            |joint: usize| Vec2::new(0.0, if joint < 4 { allowed + 1e-3 } else { allowed - 1e-3 });
        accuracy.push(config, &off(&label, error), &label);
        assert_eq!(accuracy.mean(), Some(9.0 / 13.0));
        assert_eq!(accuracy.per_joint()[3..5], [Some(0.0), Some(1.0)]);
    }

    #[test]
    fn joints_count_alike_however_often_they_are_labelled() {
        let (config, mut label) = (BodyAccuracyConfig::default(), label());
        let mut accuracy = BodyAccuracy::new(13);
        let right = off(&label, |_| Vec2::ZERO);
        accuracy.push(config, &right, &label);
        label.keypoints[0].visibility = Visibility::Unlabelled;
        let mut missing = right;
        missing.iter_mut().for_each(|joint| joint.position = None);
        (0..3).for_each(|_| accuracy.push(config, &missing, &label));
        assert_eq!(accuracy.per_joint()[..2], [Some(1.0), Some(0.25)]);
        assert_eq!(accuracy.mean(), Some(4.0 / 13.0));
        assert_eq!(BodyAccuracy::new(13).mean(), None);
    }

    #[test]
    fn measures_are_of_what_is_known() {
        let mut label = label();
        assert_eq!(BodyMeasure::Head.length(&label), None);
        label.head_size_scaled = Some(0.1);
        label.torso_size = Some(0.25);
        assert_eq!(BodyMeasure::Head.length(&label), Some(0.1));
        assert_eq!(BodyMeasure::WrittenTorso.length(&label), Some(0.25));
        let torso = BodyMeasure::Torso.length(&label);
        assert!(torso.is_some_and(|torso| (torso - 0.29f32.sqrt()).abs() < 1e-6));
        label.keypoints[number::HIP_L].position = Vec2::new(0.4, 1.2);
        label.keypoints[number::HIP_R].visibility = Visibility::Unlabelled;
        assert_eq!(BodyMeasure::Torso.length(&label), Some(1.0));
        label.keypoints[number::SHOULDER_R].visibility = Visibility::Unlabelled;
        assert_eq!(BodyMeasure::Torso.length(&label), Some(0.25));
        label.torso_size = Some(0.0);
        assert_eq!(BodyMeasure::WrittenTorso.length(&label), None);
        let mut accuracy = BodyAccuracy::new(13);
        let found = off(&label, |_| Vec2::ZERO);
        accuracy.push(BodyAccuracyConfig::default(), &found, &label);
        assert_eq!((accuracy.without_measure(), accuracy.mean()), (1, None));
    }
}

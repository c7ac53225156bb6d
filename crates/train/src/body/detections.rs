//! Whether somebody is reported where somebody is, and joints where they are in view.

use evpose_core::Micros;
use evpose_pose::body::BodyPoints;
use evpose_pose::metric::body::BodyPrediction;
use serde::Serialize;

use super::recordings::PoseTrack;

/// Counts of poses with and without somebody in view. Of labels of others, a joint that is not labelled
/// counts as out of view.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct DetectionCounts {
    /// Times of evaluation at which nobody is in view.
    pub empty: u64,
    /// Those of them at which a pose is reported.
    pub false_poses: u64,
    /// Their uninterrupted runs.
    pub false_detections: u64,
    /// Duration of `empty`, in minutes.
    pub empty_min: f64,
    /// Times at which at least a joint is in view.
    pub people: u64,
    /// Those of them at which no pose is reported.
    pub missed_poses: u64,
    /// Joints of people that are out of view.
    pub joints_out_of_view: u64,
    /// Those of them that are left out.
    pub joints_left_out: u64,
}

impl DetectionCounts {
    /// Counts predictions of a recording, which are `every` apart.
    pub fn of(track: &PoseTrack, predictions: &[BodyPrediction], every: Micros) -> Self {
        let mut counts = Self::default();
        let mut was_false = false;
        for prediction in predictions {
            let Some(truth) = track.at(Micros::from_seconds(prediction.t_s)) else { continue };
            let is_false = counts.push(&truth, &prediction.joints_px, every);
            // False poses in a row are one false detection: somebody who watches sees one ghost.
            counts.false_detections += u64::from(is_false && !was_false);
            was_false = is_false;
        }
        counts
    }

    /// Counts a pose; returns whether it is reported where nobody is.
    fn push(&mut self, truth: &BodyPoints, predicted: &BodyPoints, every: Micros) -> bool {
        let is_reported = predicted.iter().any(Option::is_some);
        if truth.iter().all(Option::is_none) {
            self.empty += 1;
            self.empty_min += every.as_seconds() / 60.0;
            self.false_poses += u64::from(is_reported);
            return is_reported;
        }
        self.people += 1;
        self.missed_poses += u64::from(!is_reported);
        for (_, predicted) in truth.iter().zip(predicted).filter(|(truth, _)| truth.is_none()) {
            self.joints_out_of_view += 1;
            self.joints_left_out += u64::from(predicted.is_none());
        }
        false
    }

    /// The counts of both.
    #[must_use]
    pub fn merge(self, other: Self) -> Self {
        Self {
            empty: self.empty + other.empty,
            false_poses: self.false_poses + other.false_poses,
            false_detections: self.false_detections + other.false_detections,
            empty_min: self.empty_min + other.empty_min,
            people: self.people + other.people,
            missed_poses: self.missed_poses + other.missed_poses,
            joints_out_of_view: self.joints_out_of_view + other.joints_out_of_view,
            joints_left_out: self.joints_left_out + other.joints_left_out,
        }
    }

    /// False detections per minute without anybody; none if somebody always is there.
    pub fn false_per_minute(&self) -> Option<f64> {
        (self.empty > 0).then(|| self.false_detections as f64 / self.empty_min)
    }
}

#[cfg(test)]
mod tests {
    use evpose_pose::body::BODY_JOINTS;
    use evpose_sim::person::{PoseRow, PoseTable};
    use glam::{Vec2, Vec3};

    use super::*;

    const NOBODY: BodyPoints = [None; BODY_JOINTS];

    fn somebody(in_view: usize) -> BodyPoints {
        std::array::from_fn(|k| (k < in_view).then_some(Vec2::ONE))
    }

    #[test]
    fn runs_of_false_poses_missed_people_and_joints_out_of_view_are_counted() {
        let truth = [NOBODY, NOBODY, NOBODY, NOBODY, somebody(6), somebody(13), somebody(1)];
        let predicted =
            [somebody(3), somebody(3), NOBODY, somebody(1), somebody(8), NOBODY, NOBODY];
        let row = |(k, joints_px): (usize, BodyPoints)| PoseRow {
            t: Micros(60_000_000 * k as i64),
            joints_px,
            joints_m: [Vec3::ZERO; BODY_JOINTS],
        };
        let rows = truth.into_iter().enumerate().map(row).collect();
        let predictions: Vec<BodyPrediction> = (0..)
            .zip(predicted)
            .map(|(k, joints_px)| BodyPrediction {
                t_s: 60.0 * f64::from(k),
                delay_s: 0.0,
                joints_px,
            })
            .collect();
        let track = PoseTrack(PoseTable { rows });
        let counts = DetectionCounts::of(&track, &predictions, Micros(60_000_000));
        assert_eq!((counts.empty, counts.false_poses, counts.false_detections), (4, 3, 2));
        assert!((counts.false_per_minute().unwrap() - 0.5).abs() < 1e-12);
        assert_eq!((counts.people, counts.missed_poses), (3, 2));
        // Of six in view two are too many, and all twelve of the last pose are left out.
        assert_eq!((counts.joints_out_of_view, counts.joints_left_out), (7 + 12, 5 + 12));
        assert_eq!(DetectionCounts::default().false_per_minute(), None);
        let twice = counts.merge(counts);
        assert_eq!((twice.empty, twice.joints_left_out), (8, 34));
    }
}

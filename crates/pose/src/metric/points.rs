//! Errors of the points of a hand, in the image and in space.
//!
//! # Model
//! *2D-PCKp*: 7 points (wrist, five fingertips, middle finger's knuckle), the distance between
//! prediction and truth in percent of the palm, which reaches from the true wrist to the true
//! knuckle. Nothing is aligned.
//!
//! *3D*: 21 points relative to the wrist, each hand to its own, in millimetres. Nothing is rotated
//! or scaled. The wrist itself, now always right, is left out.
//!
//! # Source
//! EventHands' evaluation program.

use glam::{Vec2, Vec3};

/// The evaluated points of one hand: [`crate::EVALUATION_JOINTS`] says which they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandPoints {
    /// In world metres.
    pub world_m: [Vec3; 21],
    /// In pixels; none behind the camera or where nobody labelled the point.
    pub image_px: [Option<Vec2>; 21],
}

impl HandPoints {
    /// Its points in pixels, if the whole hand is before the camera.
    pub fn in_front(&self) -> Option<[Vec2; 21]> {
        let mut out = [Vec2::ZERO; 21];
        for (out, point) in out.iter_mut().zip(self.image_px) {
            *out = point?;
        }
        Some(out)
    }
}

/// Indices of the points that are evaluated in the image: wrist, fingertips, knuckle.
pub const PALM_POINTS: [usize; 7] = [0, 1, 2, 3, 4, 5, KNUCKLE];

const WRIST: usize = 0;
/// `middle1`, the knuckle of the middle finger.
const KNUCKLE: usize = 9;

/// Errors of the labelled ones among the 7 image points, in percent of the palm.
///
/// A point that was labelled but not predicted has an infinite error. Where the palm's own two
/// points are not labelled or coincide, there is no measure and so no error.
pub fn palm_errors_percent<'a>(
    predicted_px: &'a [Option<Vec2>; 21],
    truth_px: &'a [Option<Vec2>; 21],
) -> impl Iterator<Item = f64> + use<'a> {
    let palm_px =
        truth_px[WRIST].zip(truth_px[KNUCKLE]).map(|(wrist, knuckle)| wrist.distance(knuckle));
    let palm_px = palm_px.map(f64::from).filter(|&length| length > 0.0);
    PALM_POINTS.into_iter().filter_map(move |i| {
        let (palm_px, truth) = palm_px.zip(truth_px[i])?;
        let error_px = predicted_px[i].map_or(f64::INFINITY, |p| f64::from(p.distance(truth)));
        Some(100.0 * error_px / palm_px)
    })
}

/// Errors of the 20 points beside the wrist in millimetres, both hands moved to a common wrist.
pub fn root_aligned_errors_mm(predicted_m: &[Vec3; 21], truth_m: &[Vec3; 21]) -> [f64; 20] {
    std::array::from_fn(|i| {
        let predicted = predicted_m[i + 1] - predicted_m[WRIST];
        let truth = truth_m[i + 1] - truth_m[WRIST];
        1e3 * f64::from(predicted.distance(truth))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EVALUATION_JOINTS;

    /// Points on a line, 5 px apart: the palm is 45 px.
    fn row() -> [Option<Vec2>; 21] {
        std::array::from_fn(|i| Some(Vec2::new(5.0 * i as f32, 7.0)))
    }

    #[test]
    fn the_palm_points_are_the_published_ones() {
        let names = PALM_POINTS.map(|i| EVALUATION_JOINTS[i]);
        let tips = ["thumb_tip", "index_tip", "middle_tip", "ring_tip", "pinky_tip"];
        assert_eq!(names[0], "wrist");
        assert_eq!(names[1..6], tips);
        assert_eq!(names[6], "middle1");
    }

    #[test]
    fn a_tenth_of_the_palm_is_ten_percent() {
        let moved = row().map(|p| p.map(|p| p + Vec2::new(0.0, 4.5)));
        let errors: Vec<f64> = palm_errors_percent(&moved, &row()).collect();
        assert_eq!(errors.len(), 7);
        assert!(errors.iter().all(|e| (e - 10.0).abs() < 1e-5), "{errors:?}");
    }

    #[test]
    fn points_without_a_label_are_left_out_and_unpredicted_ones_are_wrong() {
        let (mut predicted, mut truth) = (row(), row());
        truth[2] = None;
        predicted[4] = None;
        let errors: Vec<f64> = palm_errors_percent(&predicted, &truth).collect();
        assert_eq!(errors, [0.0, 0.0, 0.0, f64::INFINITY, 0.0, 0.0]);
    }

    #[test]
    fn without_a_palm_there_is_no_measure() {
        let mut truth = row();
        truth[KNUCKLE] = None;
        assert_eq!(palm_errors_percent(&row(), &truth).count(), 0);
        truth[KNUCKLE] = truth[WRIST];
        assert_eq!(palm_errors_percent(&row(), &truth).count(), 0);
    }

    #[test]
    fn where_the_hand_is_does_not_matter_in_space_but_its_points_do() {
        let truth: [Vec3; 21] = std::array::from_fn(|i| Vec3::new(0.0, 0.01 * i as f32, 0.0));
        let mut predicted = truth.map(|p| p + Vec3::new(0.5, -0.2, 0.1));
        predicted[7] += Vec3::new(0.003, 0.004, 0.0);
        let errors = root_aligned_errors_mm(&predicted, &truth);
        for (i, error) in errors.into_iter().enumerate() {
            let want = if i + 1 == 7 { 5.0 } else { 0.0 };
            assert!((error - want).abs() < 1e-3, "point {}: {error}", i + 1);
        }
    }
}

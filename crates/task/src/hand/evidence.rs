//! Whether a window shows the hand that a network of joints sees in it.

use evpose_core::{Micros, SensorSize};
use evpose_pose::HandPose;
use evpose_sim::raster::Camera;
use glam::Vec2;

/// Margin about the joints, as a share of the larger side of their box: fingertips lie inside of the skin.
const MARGIN: f32 = 0.25;
/// Time in which the evidence that is asked for falls to a third: a hand that moves slowly is seen at last, one that
/// rests is not.
const PATIENCE_S: f32 = 1.0;

/// The evidence of poses: active pixels of a window in the box about the hand, relative to the larger side of the box.
///
/// # Model
/// Events come from motion. In a window in which little of the hand moves, the joints of a network are a guess, and
/// where the hand was is the better one. An outline that moves by a few pixels has a number of pixels in proportion
/// to the size of the hand. Of windows of 100 ms as of the last 10 ms of them, the same recordings were answered best by
/// a limit between (development set; the limit that is best there is best within a factor of two).
#[derive(Debug)]
pub(super) struct HandEvidence {
    camera: Camera,
    min_evidence: f32,
    /// Time of the last pose with enough.
    last: Option<Micros>,
}

impl HandEvidence {
    /// For the view of `camera`.
    pub(super) fn new(camera: Camera, min_evidence: f32) -> Self {
        Self { camera, min_evidence, last: None }
    }

    /// Whether the window at `t` with these values, `[2][rows][columns]` of the view, shows the hand of `pose`: all of
    /// those that have no joints.
    pub(super) fn is_enough(&mut self, t: Micros, values: &[f32], pose: &HandPose) -> bool {
        let Some(joints) = &pose.joints else { return true };
        let held_s = self.last.map_or(f32::INFINITY, |last| (t - last).as_seconds() as f32);
        let asked = self.min_evidence * (-held_s / PATIENCE_S).exp();
        let points =
            joints.camera_m.map(|point_m| self.camera.pinhole().image_from_camera(point_m));
        let is_enough = of_box(points.into_iter().flatten(), values, self.camera.sensor()) >= asked;
        if is_enough {
            self.last = Some(t);
        }
        is_enough
    }

    /// Forgets everything.
    pub(super) fn reset(&mut self) {
        self.last = None;
    }
}

/// Active pixels in the box about points, over the larger side of the box.
fn of_box(points_px: impl Iterator<Item = Vec2>, values: &[f32], size: SensorSize) -> f32 {
    let (low, high) = points_px
        .fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let side = (high - low).max_element();
    if !side.is_finite() {
        return 0.0;
    }
    let ends = Vec2::new(size.width.into(), size.height.into());
    let low = (low - MARGIN * side).clamp(Vec2::ZERO, ends).as_usizevec2();
    let high = (high + MARGIN * side).clamp(Vec2::ZERO, ends).as_usizevec2();
    let rows = values.chunks_exact(size.width.into()).enumerate();
    let rows = rows.filter(|(row, _)| (low.y..high.y).contains(&(row % usize::from(size.height))));
    let active =
        rows.map(|(_, row)| row[low.x..high.x].iter().filter(|value| **value > 0.0).count());
    active.sum::<usize>() as f32 / side.max(1.0)
}

#[cfg(test)]
mod tests {
    use evpose_pose::HandJoints;
    use glam::Vec3;

    use super::*;
    use crate::hand::HandConfig;

    #[test]
    fn a_hand_is_seen_by_the_events_about_it_and_a_slow_one_at_last() {
        let camera = HandConfig::default().simulation.camera();
        let size = camera.sensor();
        // Joints on a line of 6 cm, half a metre away.
        let camera_m = std::array::from_fn(|k| Vec3::new(0.003 * k as f32 - 0.03, 0.0, -0.5));
        let (scores, rotations) = ([0.5; 21], [Vec3::ZERO; 15]);
        let joints = HandJoints { camera_m, scores, presence: 0.9, rotations };
        let pose = HandPose { joints: Some(joints), ..HandPose::default() };
        let centre = camera.pinhole().principal_px.as_usizevec2();
        let side = (camera_m[20].x - camera_m[0].x) * 2.0 * camera.pinhole().focal_px;
        let window = |active: usize, row: usize| {
            let mut values = vec![0.0; 2 * size.pixels()];
            let first = row * usize::from(size.width) + centre.x - active / 2;
            values[first..first + active].fill(0.5);
            values
        };
        let mut evidence = HandEvidence::new(camera, 0.5);
        let enough = (0.5 * side).ceil() as usize + 1;
        let mut at = |t_s: f64, active: usize, row: usize| {
            evidence.is_enough(Micros::from_seconds(t_s), &window(active, row), &pose)
        };
        assert!(at(0.0, enough, centre.y));
        assert!(!at(0.1, enough / 3, centre.y));
        assert!(!at(0.1, enough, 2), "events beside the hand");
        assert!(at(2.0, enough / 3, centre.y), "little by little");
        assert!(!at(9.0, 0, centre.y), "a hand at rest");
        // A regressor says nothing of where the hand is seen.
        assert!(evidence.is_enough(Micros(0), &window(0, 0), &HandPose::default()));
    }
}

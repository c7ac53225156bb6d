//! Poses of a hand between labels.

use evpose_core::Micros;
use evpose_pose::HandParams;
use evpose_pose::rotation::axis_angle_from_matrix;
use glam::{Mat3, Quat, Vec3};

use super::format::LabelledHand;

/// The pose of a hand at a time among `labels`, which are in the order of time: articulation and
/// translation interpolated linearly, the rotation spherically. None outside of them.
pub(super) fn pose_at(labels: &[LabelledHand<HandParams>], t: Micros) -> Option<HandParams> {
    let next = labels.partition_point(|label| label.t < t);
    let after = labels.get(next)?;
    // Asked first, since no label lies before the first one.
    if after.t == t {
        return Some(after.label);
    }
    let before = labels.get(next.checked_sub(1)?)?;
    let share = (t - before.t).0 as f32 / (after.t - before.t).0 as f32;
    let (from, to) = (&before.label, &after.label);
    Some(HandParams {
        articulation: std::array::from_fn(|k| {
            from.articulation[k] + (to.articulation[k] - from.articulation[k]) * share
        }),
        translation_m: from.translation_m.lerp(to.translation_m, share),
        rotation: slerp(from.rotation, to.rotation, share),
    })
}

/// Spherical interpolation of axis-angle vectors, the short way.
fn slerp(from: Vec3, to: Vec3, share: f32) -> Vec3 {
    let between = Quat::from_scaled_axis(from).slerp(Quat::from_scaled_axis(to), share);
    axis_angle_from_matrix(Mat3::from_quat(between))
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;

    #[test]
    fn rotations_go_the_short_way_across_a_half_turn() {
        let hand = |rotation: f32, x: f32| HandParams {
            articulation: [x; 6],
            translation_m: Vec3::X * x,
            rotation: Vec3::Z * rotation,
        };
        let labels = [
            LabelledHand { t: Micros(0), label: hand(PI - 0.2, 0.0) },
            LabelledHand { t: Micros(10), label: hand(-(PI - 0.1), 1.0) },
        ];
        let pose = pose_at(&labels, Micros(5)).unwrap();
        // 0.3 rad lie between them; the middle is 0.05 short of a half turn.
        assert!((pose.rotation - Vec3::Z * (PI - 0.05)).length() < 1e-3, "{}", pose.rotation);
        assert!(
            (pose.translation_m.x - 0.5).abs() < 1e-6 && (pose.articulation[5] - 0.5).abs() < 1e-6
        );
        assert_eq!(pose_at(&labels, Micros(10)), Some(labels[1].label));
        assert_eq!(pose_at(&labels, Micros(11)), None);
        assert_eq!(pose_at(&labels, Micros(-1)), None);
    }
}

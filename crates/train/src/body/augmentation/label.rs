//! Labels of images that were mirrored and mapped.

use evpose_pose::body::{BodyLabel, Keypoint, MIRRORED, Visibility};
use glam::{DAffine2, Vec2};

/// The label of the view: all points mapped. Joints that leave the image
/// become unlabelled, others there are forgotten, and the middle stays inside.
pub(super) fn moved(label: &BodyLabel, map: DAffine2, is_mirrored: bool) -> BodyLabel {
    let to = |at: Vec2| map.transform_point2(at.as_dvec2()).as_vec2();
    let inside =
        |points: &[Vec2]| points.iter().map(|&at| to(at)).filter(|&at| is_inside(at)).collect();
    // In a mirror, left is right.
    let from = |joint: usize, joints: usize| match MIRRORED.get(joint) {
        Some(&other) if is_mirrored && other < joints => other,
        _ => joint,
    };
    let joints = label.keypoints.len();
    let keypoint = |joint: usize| {
        let Keypoint { position, visibility } = label.keypoints[from(joint, joints)];
        let position = to(position);
        let visibility = if is_inside(position) { visibility } else { Visibility::Unlabelled };
        Keypoint { position, visibility }
    };
    let others = label.other_keypoints.len();
    // The root of the change of area, since lengths here have no direction.
    let size = map.matrix2.determinant().abs().sqrt() as f32;
    BodyLabel {
        keypoints: (0..joints).map(keypoint).collect(),
        center: to(label.center).clamp(Vec2::ZERO, Vec2::ONE),
        head_size: label.head_size.map(|head| head * size),
        head_size_scaled: label.head_size_scaled.map(|head| head * size),
        torso_size: label.torso_size.map(|torso| torso * size),
        other_centers: inside(&label.other_centers),
        other_keypoints: (0..others)
            .map(|joint| inside(&label.other_keypoints[from(joint, others)]))
            .collect(),
    }
}

/// The number of unlabelled joints.
pub(super) fn unlabelled(label: &BodyLabel) -> usize {
    label.keypoints.iter().filter(|keypoint| !keypoint.is_labelled()).count()
}

/// Whether a point is in the image, border included.
pub(super) fn is_inside(at: Vec2) -> bool {
    at.cmpge(Vec2::ZERO).all() && at.cmple(Vec2::ONE).all()
}

#[cfg(test)]
mod tests {
    use super::super::geometry::mirror;
    use super::*;

    fn label() -> BodyLabel {
        let keypoint = |joint: usize| Keypoint {
            position: Vec2::new(joint as f32 / 13.0, 0.25),
            visibility: if joint == 5 { Visibility::Hidden } else { Visibility::Visible },
        };
        BodyLabel {
            keypoints: (0..13).map(keypoint).collect(),
            center: Vec2::new(0.25, 0.5),
            torso_size: Some(0.5),
            other_centers: vec![Vec2::new(0.125, 0.75)],
            other_keypoints: (0..13)
                .map(|joint| vec![Vec2::new(0.0, joint as f32 / 16.0)])
                .collect(),
            ..BodyLabel::default()
        }
    }

    #[test]
    fn a_mirror_exchanges_left_and_right() {
        let mirrored = moved(&label(), mirror(), true);
        // The left wrist was hidden; now the right one is, on the other side.
        let right = mirrored.keypoints[6];
        assert_eq!(right.visibility, Visibility::Hidden);
        assert!(right.position.distance(Vec2::new(1.0 - 5.0 / 13.0, 0.25)) < 1e-6);
        assert_eq!(mirrored.other_keypoints[6], [Vec2::new(1.0, 5.0 / 16.0)]);
        assert_eq!(mirrored.torso_size, Some(0.5));
    }

    #[test]
    fn two_mirrors_are_none() {
        let twice = moved(&moved(&label(), mirror(), true), mirror(), true);
        let original = label();
        for (a, b) in twice.keypoints.iter().zip(&original.keypoints) {
            assert!(a.position.distance(b.position) < 1e-6 && a.visibility == b.visibility);
        }
        assert_eq!(BodyLabel { keypoints: original.keypoints.clone(), ..twice }, original);
    }

    #[test]
    fn what_leaves_the_image_is_forgotten() {
        let map = DAffine2::from_translation(glam::DVec2::new(-0.25, 0.0));
        let moved = moved(&label(), map, false);
        // Joints 0 to 3 were in the first quarter.
        let lost: Vec<usize> = (0..13).filter(|&j| !moved.keypoints[j].is_labelled()).collect();
        assert_eq!(lost, [0, 1, 2, 3]);
        assert_eq!(unlabelled(&moved), 4);
        assert_eq!((moved.center, moved.other_centers.len()), (Vec2::new(0.0, 0.5), 0));
        assert!(
            moved.other_keypoints.len() == 13 && moved.other_keypoints.iter().all(Vec::is_empty)
        );
    }
}

//! Keypoints of COCO, which networks of others find, and the thirteen joints made of them.

use glam::Vec2;

use super::{BODY_JOINTS, BodyJoint};

/// Keypoints of a person in COCO: nose, eyes, ears, shoulders, elbows, wrists, hips, knees, ankles,
/// the left one first.
pub const COCO_KEYPOINTS: usize = 17;

/// Keypoints of the face, which come first.
const FACE: usize = 5;
/// Index of the left ear; the right one follows.
const EARS: usize = 3;

/// The thirteen joints, in the order of networks, of the keypoints of a person.
///
/// # Model
/// The head is the midpoint of the ears, which is about the middle of the head from any side; with
/// an ear unseen, the mean of the keypoints of the face that were detected. Its score is the mean
/// of theirs. The other joints are keypoints as they are.
pub fn joints_of_coco(keypoints: &[BodyJoint; COCO_KEYPOINTS]) -> [BodyJoint; BODY_JOINTS] {
    std::array::from_fn(|joint| match joint {
        0 => head(&keypoints[..FACE]),
        _ => keypoints[FACE + joint - 1],
    })
}

fn head(face: &[BodyJoint]) -> BodyJoint {
    let seen = |points: &[BodyJoint]| -> Vec<(Vec2, f32)> {
        points.iter().filter_map(|point| Some((point.position?, point.score))).collect()
    };
    let ears = seen(&face[EARS..]);
    // One ear alone would pull the head to its side of the face.
    let used = if ears.len() == 2 { ears } else { seen(face) };
    if used.is_empty() {
        return BodyJoint { position: None, score: 0.0 };
    }
    let share = 1.0 / used.len() as f32;
    let position = used.iter().map(|(at, _)| *at).sum::<Vec2>() * share;
    let score = used.iter().map(|(_, score)| score).sum::<f32>() * share;
    BodyJoint { position: Some(position), score }
}

/// COCO's names of its keypoints, as in its annotation files.
pub const COCO_KEYPOINT_NAMES: [&str; COCO_KEYPOINTS] = [
    "nose",
    "left_eye",
    "right_eye",
    "left_ear",
    "right_ear",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_hip",
    "right_hip",
    "left_knee",
    "right_knee",
    "left_ankle",
    "right_ankle",
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::JOINT_NAMES;

    fn keypoints() -> [BodyJoint; COCO_KEYPOINTS] {
        std::array::from_fn(|k| BodyJoint {
            position: Some(Vec2::new(k as f32, 1.0)),
            score: 0.125 * k as f32,
        })
    }

    #[test]
    fn joints_below_the_head_are_keypoints_of_the_same_name() {
        let joints = joints_of_coco(&keypoints());
        for (joint, name) in joints.iter().zip(JOINT_NAMES).skip(1) {
            let (part, side) = name.rsplit_once('_').unwrap_or((name, ""));
            let coco = format!("{}_{part}", if side == "l" { "left" } else { "right" });
            let at = COCO_KEYPOINT_NAMES.iter().position(|name| *name == coco);
            assert_eq!(joint.position.map(|position| position.x as usize), at, "{name}");
        }
    }

    #[test]
    fn the_head_is_between_the_ears_or_in_the_middle_of_what_is_seen_of_the_face() {
        let mut keypoints = keypoints();
        let at = |keypoints: &[BodyJoint; COCO_KEYPOINTS]| {
            let head = joints_of_coco(keypoints)[0];
            (head.position.map(|position| position.x), head.score)
        };
        assert_eq!(at(&keypoints), (Some(3.5), 0.4375));
        keypoints[4].position = None;
        assert_eq!(at(&keypoints), (Some(1.5), 0.1875), "nose, eyes and an ear");
        keypoints[..FACE].iter_mut().for_each(|point| point.position = None);
        assert_eq!(at(&keypoints), (None, 0.0));
    }
}

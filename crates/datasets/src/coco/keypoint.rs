//! Names of keypoints, and the joints made of them.

use evpose_pose::body::{BODY_JOINTS, BodyPoints, JOINT_NAMES, number};
use glam::Vec2;

/// A joint, or a part of the face that stands in for the middle of the head.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamedKeypoint {
    /// Index of a joint, in the order of networks.
    Joint(usize),
    /// A point of the face.
    Face,
}

/// COCO's names of points of the face.
const FACE: [&str; 5] = ["nose", "left_eye", "right_eye", "left_ear", "right_ear"];

/// The keypoint of a name of this project (`wrist_l`) or of COCO (`left_wrist`, `Left Wrist`).
pub fn keypoint_by_name(name: &str) -> Option<NamedKeypoint> {
    let name = name.trim().to_lowercase().replace([' ', '-'], "_");
    let name = name.as_str();
    if FACE.contains(&name) {
        return Some(NamedKeypoint::Face);
    }
    let own = match name.split_once('_') {
        Some(("left", joint)) => format!("{joint}_l"),
        Some(("right", joint)) => format!("{joint}_r"),
        _ => name.to_owned(),
    };
    JOINT_NAMES.iter().position(|known| *known == own).map(NamedKeypoint::Joint)
}

/// The joints of labelled keypoints: the head is the mean of the points of the face, unless it is
/// labelled itself.
pub(super) fn joints(keypoints: impl IntoIterator<Item = (NamedKeypoint, Vec2)>) -> BodyPoints {
    let mut joints_px = [None; BODY_JOINTS];
    let (mut face, mut count) = (Vec2::ZERO, 0.0);
    for (keypoint, at_px) in keypoints {
        match keypoint {
            NamedKeypoint::Joint(joint) => joints_px[joint] = Some(at_px),
            NamedKeypoint::Face => {
                face += at_px;
                count += 1.0;
            }
        }
    }
    if count > 0.0 {
        joints_px[number::HEAD] = joints_px[number::HEAD].or(Some(face / count));
    }
    joints_px
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_coco_and_of_this_project_are_known() {
        assert_eq!(
            keypoint_by_name("left_shoulder"),
            Some(NamedKeypoint::Joint(number::SHOULDER_L))
        );
        assert_eq!(keypoint_by_name("ankle_r"), Some(NamedKeypoint::Joint(number::ANKLE_R)));
        assert_eq!(keypoint_by_name("right_eye"), Some(NamedKeypoint::Face));
        let spaced = ["left shoulder", "Left-Shoulder"].map(keypoint_by_name);
        assert_eq!(spaced, [Some(NamedKeypoint::Joint(number::SHOULDER_L)); 2]);
        assert_eq!(keypoint_by_name("left_toe"), None);
    }

    #[test]
    fn the_head_is_the_mean_of_the_face_unless_it_is_labelled() {
        let face = [
            (NamedKeypoint::Face, Vec2::new(2.0, 4.0)),
            (NamedKeypoint::Face, Vec2::new(4.0, 8.0)),
        ];
        assert_eq!(joints(face)[number::HEAD], Some(Vec2::new(3.0, 6.0)));
        let head = (NamedKeypoint::Joint(number::HEAD), Vec2::ONE);
        assert_eq!(joints([face[0], head])[number::HEAD], Some(Vec2::ONE));
        assert_eq!(joints([])[number::HEAD], None);
    }
}

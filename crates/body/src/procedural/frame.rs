//! The joints of the procedural body at rest, in the T-pose, and the frame of its right hand.
//!
//! Model coordinates as SMPL+H: x to the body's left, y up, z forward. The right arm points along
//! -x with the palm down and the thumb forward.

use glam::Vec3;

use crate::skeleton::{
    BODY_JOINTS, HAND_JOINTS, JOINTS, LEFT_HAND, RIGHT_COLLAR, RIGHT_ELBOW, RIGHT_HAND,
    RIGHT_SHOULDER, RIGHT_WRIST,
};

use super::digits::{DIGITS, Digit};

/// Joints of the body: rounded values of a person of 1.7 m in the T-pose.
pub(super) const BODY_JOINTS_M: [Vec3; BODY_JOINTS] = [
    Vec3::new(0.0, -0.22, 0.03),     // pelvis
    Vec3::new(0.065, -0.31, 0.02),   // left hip
    Vec3::new(-0.065, -0.31, 0.02),  // right hip
    Vec3::new(0.0, -0.11, 0.0),      // spine 1
    Vec3::new(0.10, -0.69, 0.01),    // left knee
    Vec3::new(-0.10, -0.69, 0.01),   // right knee
    Vec3::new(0.0, 0.02, 0.0),       // spine 2
    Vec3::new(0.09, -1.10, -0.03),   // left ankle
    Vec3::new(-0.09, -1.10, -0.03),  // right ankle
    Vec3::new(0.0, 0.08, 0.02),      // spine 3
    Vec3::new(0.12, -1.16, 0.09),    // left foot
    Vec3::new(-0.12, -1.16, 0.09),   // right foot
    Vec3::new(0.0, 0.29, -0.01),     // neck
    Vec3::new(0.08, 0.19, -0.01),    // left collar
    Vec3::new(-0.08, 0.19, -0.01),   // right collar
    Vec3::new(0.0, 0.36, 0.03),      // head
    Vec3::new(0.175, 0.225, -0.02),  // left shoulder
    Vec3::new(-0.175, 0.225, -0.02), // right shoulder
    Vec3::new(0.43, 0.21, -0.04),    // left elbow
    Vec3::new(-0.43, 0.21, -0.04),   // right elbow
    Vec3::new(0.68, 0.22, -0.045),   // left wrist
    Vec3::new(-0.68, 0.22, -0.045),  // right wrist
];

pub(super) const COLLAR_M: Vec3 = BODY_JOINTS_M[RIGHT_COLLAR];
pub(super) const SHOULDER_M: Vec3 = BODY_JOINTS_M[RIGHT_SHOULDER];
pub(super) const ELBOW_M: Vec3 = BODY_JOINTS_M[RIGHT_ELBOW];
pub(super) const WRIST_M: Vec3 = BODY_JOINTS_M[RIGHT_WRIST];

/// A point given as millimetres (distal, dorsal, radial) from the right wrist.
pub(super) fn hand_point([distal, dorsal, radial]: [f32; 3]) -> Vec3 {
    WRIST_M + Vec3::new(-distal, dorsal, radial) * 1e-3
}

/// The unit vector along (distal, dorsal, radial) of the right hand.
pub(super) fn direction([distal, dorsal, radial]: [f32; 3]) -> Vec3 {
    Vec3::new(-distal, dorsal, radial).normalize()
}

/// The mirror image of a point in the plane between left and right.
fn mirrored(point_m: Vec3) -> Vec3 {
    Vec3::new(-point_m.x, point_m.y, point_m.z)
}

pub(super) fn rest_joints(digits: &[Digit; DIGITS]) -> [Vec3; JOINTS] {
    std::array::from_fn(|joint| {
        let finger = |k: usize| digits[k / 3].points_m[k % 3];
        match joint {
            0..BODY_JOINTS => BODY_JOINTS_M[joint],
            LEFT_HAND..RIGHT_HAND => mirrored(finger((joint - LEFT_HAND) % HAND_JOINTS)),
            _ => finger(joint - RIGHT_HAND),
        }
    })
}

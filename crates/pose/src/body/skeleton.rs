//! The thirteen joints of a body, in the two orders that files and networks have them.

use glam::Vec2;

/// Joints of a body.
pub const BODY_JOINTS: usize = 13;

/// Names of the joints, in the order of networks and annotations: MoveNet's without a face.
///
/// Left and right are the person's.
pub const JOINT_NAMES: [&str; BODY_JOINTS] = [
    "head",
    "shoulder_l",
    "shoulder_r",
    "elbow_l",
    "elbow_r",
    "wrist_l",
    "wrist_r",
    "hip_l",
    "hip_r",
    "knee_l",
    "knee_r",
    "ankle_l",
    "ankle_r",
];

/// Indices of joints in the order of networks.
pub mod number {
    /// Middle of the head.
    pub const HEAD: usize = 0;
    /// Left shoulder.
    pub const SHOULDER_L: usize = 1;
    /// Right shoulder.
    pub const SHOULDER_R: usize = 2;
    /// Left elbow.
    pub const ELBOW_L: usize = 3;
    /// Right elbow.
    pub const ELBOW_R: usize = 4;
    /// Left wrist.
    pub const WRIST_L: usize = 5;
    /// Right wrist.
    pub const WRIST_R: usize = 6;
    /// Left hip.
    pub const HIP_L: usize = 7;
    /// Right hip.
    pub const HIP_R: usize = 8;
    /// Left knee.
    pub const KNEE_L: usize = 9;
    /// Right knee.
    pub const KNEE_R: usize = 10;
    /// Left ankle.
    pub const ANKLE_L: usize = 11;
    /// Right ankle.
    pub const ANKLE_R: usize = 12;
}

/// Joints between which limbs are drawn, in the order of networks.
///
/// # Source
/// hpe-core, which draws none to the head.
pub const LIMBS: [[usize; 2]; 12] = [
    [2, 4],
    [4, 6],
    [1, 3],
    [3, 5],
    [2, 1],
    [2, 8],
    [1, 7],
    [8, 7],
    [8, 10],
    [10, 12],
    [7, 9],
    [9, 11],
];

/// Index of each joint's mirror image, in the order of networks.
pub const MIRRORED: [usize; BODY_JOINTS] = [0, 2, 1, 4, 3, 6, 5, 8, 7, 10, 9, 12, 11];

/// Index in the order of files of each joint in the order of networks.
const NETWORK_FROM_FILE: [usize; BODY_JOINTS] = [0, 2, 1, 4, 3, 8, 7, 5, 6, 10, 9, 12, 11];
/// Index in the order of networks of each joint in the order of files.
const FILE_FROM_NETWORK: [usize; BODY_JOINTS] = [0, 2, 1, 4, 3, 7, 8, 6, 5, 10, 9, 12, 11];

/// Joints of one person in an image, in pixels, in the order of networks; none where it is not
/// known.
pub type BodyPoints = [Option<Vec2>; BODY_JOINTS];

/// Joints in the order of hpe-core and DHP19 (head, shoulders, elbows, hips, hands, knees, feet;
/// the right one first but for hips) brought into that of networks.
pub fn network_from_file<T: Copy>(joints: &[T; BODY_JOINTS]) -> [T; BODY_JOINTS] {
    NETWORK_FROM_FILE.map(|joint| joints[joint])
}

/// The inverse of [`network_from_file`].
pub fn file_from_network<T: Copy>(joints: &[T; BODY_JOINTS]) -> [T; BODY_JOINTS] {
    FILE_FROM_NETWORK.map(|joint| joints[joint])
}

/// Length of the torso's diagonal from the left hip to the right shoulder: the measure of errors.
pub fn torso(joints: &BodyPoints) -> Option<f32> {
    let (hip, shoulder) = (joints[number::HIP_L]?, joints[number::SHOULDER_R]?);
    Some(hip.distance(shoulder))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As hpe-core writes them.
    const FILE_NAMES: [&str; BODY_JOINTS] = [
        "head",
        "shoulder_r",
        "shoulder_l",
        "elbow_r",
        "elbow_l",
        "hip_l",
        "hip_r",
        "wrist_r",
        "wrist_l",
        "knee_r",
        "knee_l",
        "ankle_r",
        "ankle_l",
    ];

    #[test]
    fn both_orders_name_the_same_joints() {
        assert_eq!(network_from_file(&FILE_NAMES), JOINT_NAMES);
        assert_eq!(file_from_network(&JOINT_NAMES), FILE_NAMES);
    }

    #[test]
    fn a_mirror_exchanges_left_and_right_and_nothing_else() {
        for (name, mirrored) in JOINT_NAMES.iter().zip(MIRRORED) {
            let want = match name.rsplit_once('_') {
                Some((part, "l")) => format!("{part}_r"),
                Some((part, _)) => format!("{part}_l"),
                None => (*name).to_owned(),
            };
            assert_eq!(JOINT_NAMES[mirrored], want);
        }
    }
}

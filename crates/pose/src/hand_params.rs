//! The 12 parameters of a hand.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Number of values of a [`HandParams`].
pub const PARAMETERS: usize = 12;

/// The 21 evaluated points of a hand, in their published order.
pub const EVALUATION_JOINTS: [&str; 21] = [
    "wrist",
    "thumb_tip",
    "index_tip",
    "middle_tip",
    "ring_tip",
    "pinky_tip",
    "index1",
    "index2",
    "index3",
    "middle1",
    "middle2",
    "middle3",
    "pinky1",
    "pinky2",
    "pinky3",
    "ring1",
    "ring2",
    "ring3",
    "thumb1",
    "thumb2",
    "thumb3",
];

/// Bones between these points, as pairs of their indices: thumb, index, middle, ring, pinky, each
/// from the wrist to the tip.
pub const HAND_BONES: [[usize; 2]; 20] = [
    [0, 18],
    [18, 19],
    [19, 20],
    [20, 1],
    [0, 6],
    [6, 7],
    [7, 8],
    [8, 2],
    [0, 9],
    [9, 10],
    [10, 11],
    [11, 3],
    [0, 15],
    [15, 16],
    [16, 17],
    [17, 4],
    [0, 12],
    [12, 13],
    [13, 14],
    [14, 5],
];

/// Pose of a hand in the world, a right one unless said otherwise, as `.meta` files store it and
/// the network predicts it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct HandParams {
    /// First six coefficients of the articulation basis, dimensionless, about -2 to 2.
    pub articulation: [f32; 6],
    /// Position of the wrist joint in metres.
    pub translation_m: Vec3,
    /// Rotation of the wrist joint as an axis times an angle in radians, angle in [0, π].
    pub rotation: Vec3,
}

/// Names of the parameters as columns of tables, in the published order.
pub const PARAMETER_NAMES: [&str; PARAMETERS] = [
    "articulation_1",
    "articulation_2",
    "articulation_3",
    "articulation_4",
    "articulation_5",
    "articulation_6",
    "translation_x_m",
    "translation_y_m",
    "translation_z_m",
    "rotation_x_rad",
    "rotation_y_rad",
    "rotation_z_rad",
];

impl HandParams {
    /// Reads the published order: articulation, translation, rotation.
    pub fn from_array(values: [f32; PARAMETERS]) -> Self {
        let [a, b, c, d, e, f, x, y, z, rx, ry, rz] = values;
        Self {
            articulation: [a, b, c, d, e, f],
            translation_m: Vec3::new(x, y, z),
            rotation: Vec3::new(rx, ry, rz),
        }
    }

    /// The published order: articulation, translation, rotation.
    pub fn to_array(self) -> [f32; PARAMETERS] {
        let [a, b, c, d, e, f] = self.articulation;
        let (t, r) = (self.translation_m, self.rotation);
        [a, b, c, d, e, f, t.x, t.y, t.z, r.x, r.y, r.z]
    }

    /// As [`Self::from_array`], from the doubles of a `.meta` file.
    pub fn from_f64(values: [f64; PARAMETERS]) -> Self {
        Self::from_array(values.map(|v| v as f32))
    }

    /// As [`Self::to_array`], for a `.meta` file.
    pub fn to_f64(self) -> [f64; PARAMETERS] {
        self.to_array().map(f64::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bones_lead_from_the_wrist_to_every_tip() {
        for finger in HAND_BONES.chunks(4) {
            assert_eq!(finger[0][0], 0);
            assert!(finger.windows(2).all(|pair| pair[0][1] == pair[1][0]));
            let name = EVALUATION_JOINTS[finger[3][1]];
            let digit = name.strip_suffix("_tip").expect("the last bone ends at a tip");
            for (bone, number) in finger.iter().zip(1..=3) {
                assert_eq!(EVALUATION_JOINTS[bone[1]], format!("{digit}{number}"));
            }
        }
    }

    #[test]
    fn the_published_order_is_kept() {
        let values: [f32; PARAMETERS] = std::array::from_fn(|i| i as f32 * 0.1);
        assert_eq!(HandParams::from_array(values).to_array(), values);
    }
}

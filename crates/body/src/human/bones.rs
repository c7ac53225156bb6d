//! Bones with the flesh around them, and which of them hold a place on the surface.

use glam::Vec3;

use crate::implicit::cone::smooth_step;
use crate::skeleton::JOINTS;

/// How far over the middle of the body bones of one side reach.
const OVER_MIDDLE_M: f32 = 0.03;
/// Over how much of its thickness a bone shares the surface with its neighbours.
const SHARING: f32 = 0.28;
/// Shares below this are dropped.
const MIN_SHARE: f32 = 0.02;

/// A bone: the joint that moves it, where it lies at rest, and how thick the flesh around it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bone {
    pub(super) joint: usize,
    pub(super) start_m: Vec3,
    pub(super) end_m: Vec3,
    pub(super) radius_m: f32,
    /// On the body's left (1), right (-1) or in the middle (0).
    pub(super) side: f32,
}

/// The bones of the middle: joint, ends as y and z, radius.
const MIDDLE: [(usize, [f32; 2], [f32; 2], f32); 6] = [
    (0, [-0.29, 0.005], [-0.20, 0.005], 0.125),
    (3, [-0.15, 0.005], [-0.05, 0.005], 0.115),
    (6, [-0.02, 0.005], [0.06, 0.005], 0.115),
    (9, [0.09, 0.0], [0.21, -0.01], 0.115),
    (12, [0.27, -0.01], [0.345, 0.0], 0.055),
    (15, [0.40, 0.03], [0.49, 0.03], 0.09),
];

/// The bones of the left side: joint, ends, radius.
const LEFT: [(usize, [f32; 3], [f32; 3], f32); 8] = [
    (1, [0.085, -0.33, 0.0], [0.10, -0.66, 0.012], 0.080),
    (4, [0.10, -0.72, 0.008], [0.09, -1.06, -0.03], 0.050),
    (7, [0.09, -1.13, -0.045], [0.115, -1.155, 0.07], 0.040),
    (10, [0.118, -1.165, 0.105], [0.125, -1.17, 0.15], 0.030),
    (13, [0.07, 0.20, -0.02], [0.145, 0.215, -0.02], 0.060),
    (16, [0.195, 0.217, -0.022], [0.40, 0.21, -0.038], 0.050),
    (18, [0.455, 0.211, -0.04], [0.66, 0.22, -0.045], 0.038),
    (20, [0.70, 0.22, -0.045], [0.85, 0.212, -0.04], 0.030),
];

pub(super) fn bones() -> Vec<Bone> {
    let middle = MIDDLE.map(|(joint, start, end, radius_m)| Bone {
        joint,
        start_m: Vec3::new(0.0, start[0], start[1]),
        end_m: Vec3::new(0.0, end[0], end[1]),
        radius_m,
        side: 0.0,
    });
    let sides = LEFT.into_iter().flat_map(|(joint, start, end, radius_m)| {
        let (start_m, end_m) = (Vec3::from(start), Vec3::from(end));
        // The left side is at positive x.
        let mirror = Vec3::new(-1.0, 1.0, 1.0);
        let left = Bone { joint, start_m, end_m, radius_m, side: 1.0 };
        // Joints of the body come in pairs, the left one first.
        let right = Bone {
            joint: joint + 1,
            start_m: start_m * mirror,
            end_m: end_m * mirror,
            radius_m,
            side: -1.0,
        };
        [left, right]
    });
    middle.into_iter().chain(sides).collect()
}

impl Bone {
    /// Distance to the flesh around the bone, as far as that is known: negative inside.
    fn gap_m(&self, point_m: Vec3) -> f32 {
        let axis = self.end_m - self.start_m;
        let along = (point_m - self.start_m).dot(axis) / axis.length_squared();
        let nearest_m = self.start_m + axis * along.clamp(0.0, 1.0);
        let mut offset = point_m - nearest_m;
        if self.side == 0.0 && self.radius_m > 0.1 {
            // The trunk is wider than deep.
            offset.x *= 0.8;
            offset.z *= 1.2;
        }
        offset.length() - self.radius_m
    }
}

/// Skin weights of a point on the surface; they sum to one.
///
/// A bone's share falls off with how much farther it is than the nearest one.
pub(super) fn shares(bones: &[Bone], point_m: Vec3) -> [f32; JOINTS] {
    let gaps_m: Vec<f32> = bones.iter().map(|bone| bone.gap_m(point_m)).collect();
    // A bone of one side holds skin of the other only just over the middle, however near it is.
    let on_side = |bone: &Bone| match bone.side {
        0.0 => 1.0,
        side => smooth_step(-OVER_MIDDLE_M, OVER_MIDDLE_M, side * point_m.x),
    };
    let nearest = gaps_m.iter().zip(bones).filter(|(_, bone)| on_side(bone) > 0.0);
    let nearest = nearest.min_by(|a, b| a.0.total_cmp(b.0));
    let Some((&nearest_m, nearest)) = nearest else { return [0.0; JOINTS] };
    let reach_m = SHARING * nearest.radius_m;
    let mut shares = [0.0; JOINTS];
    for (bone, gap_m) in bones.iter().zip(&gaps_m) {
        let farther = (gap_m - nearest_m) / reach_m;
        shares[bone.joint] += on_side(bone) / (1.0 + farther * farther).powi(3);
    }
    let total: f32 = shares.iter().sum();
    // Tiny shares cost time in every frame and move nothing that is seen.
    for share in &mut shares {
        *share = if *share < MIN_SHARE * total { 0.0 } else { *share };
    }
    let total: f32 = shares.iter().sum();
    shares.map(|share| share / total)
}

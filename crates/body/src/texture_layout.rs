//! Texture layout of the procedural arm.
//!
//! The layout has no seams: u runs along the limb, the same for all five digits, and v around it
//! from the back (0) over either side to the palm (1), as the angle between the rest pose's normal
//! and the back of the hand, divided by π. Both sides of a digit, and all digits, share texels.
//!
//! A crease across the joints is a line of constant u with v near 1, a nail the patch of u in
//! [`U_NAIL`] with v below [`V_NAIL`], the palm's lines lie between [`U_WRIST`] and [`U_KNUCKLE`].
//! For patterns that must not repeat, take the rest position ([`crate::BodyModel::template_m`]).

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use crate::skeleton::{JOINTS, RIGHT_ELBOW, RIGHT_SHOULDER};
use crate::{BodyModel, ShapedBody};

/// The inner end of the upper arm.
pub const U_SHOULDER: f32 = 0.0;
/// U coordinate of the elbow.
pub const U_ELBOW: f32 = 0.15;
/// U coordinate of the wrist.
pub const U_WRIST: f32 = 0.35;
/// First joints of the fingers; second joint of the thumb.
pub const U_KNUCKLE: f32 = 0.60;
/// Second joints of the fingers.
pub const U_MIDDLE_JOINT: f32 = 0.75;
/// Third joints of all digits.
pub const U_END_JOINT: f32 = 0.87;
/// Tips.
pub const U_TIP: f32 = 1.0;
/// The nails, from root to edge.
pub const U_NAIL: [f32; 2] = [0.925, 0.99];
/// The nails reach this far to either side.
pub const V_NAIL: f32 = 0.30;

/// Texture coordinates in this layout for a model that has none: `u` by the nearest bone of arm and
/// hand, `v` by the normal, in a rest pose with the back of the hand up.
///
/// `rest` is the mean shape.
pub fn coordinates(model: &BodyModel, rest: &ShapedBody) -> Vec<Vec2> {
    let bones = bones(model, rest);
    let normals = rest.normals.iter();
    rest.vertices_m
        .iter()
        .zip(normals)
        .map(|(&vertex_m, normal)| {
            let nearest = bones.iter().map(|bone| bone.at(vertex_m));
            let u = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, u)| u);
            Vec2::new(u, normal.y.clamp(-1.0, 1.0).acos() / PI)
        })
        .collect()
}

/// A stretch of the limb and the part of the texture it has.
struct Bone {
    start_m: Vec3,
    end_m: Vec3,
    u: [f32; 2],
}

impl Bone {
    /// Distance of a point in metres, and the texture's u beside it.
    fn at(&self, point_m: Vec3) -> (f32, f32) {
        let axis = self.end_m - self.start_m;
        let along =
            (point_m - self.start_m).dot(axis) / axis.length_squared().max(f32::MIN_POSITIVE);
        let along = along.clamp(0.0, 1.0);
        let distance_m = (self.start_m + axis * along).distance(point_m);
        (distance_m, self.u[0] + (self.u[1] - self.u[0]) * along)
    }
}

fn bones(model: &BodyModel, rest: &ShapedBody) -> Vec<Bone> {
    // Digits of the skeleton in the order of the finger tips: thumb, index, middle, ring, pinky.
    const DIGITS: [usize; 5] = [4, 0, 1, 3, 2];
    let joint = |number: usize| rest.joints_m[number];
    let mut bones = Vec::new();
    if model.parents.len() == JOINTS {
        let (shoulder, elbow) = (joint(RIGHT_SHOULDER), joint(RIGHT_ELBOW));
        bones.push(Bone { start_m: shoulder, end_m: elbow, u: [U_SHOULDER, U_ELBOW] });
        bones.push(Bone { start_m: elbow, end_m: joint(model.wrist), u: [U_ELBOW, U_WRIST] });
    }
    for (digit, tip) in DIGITS.into_iter().zip(model.fingertips) {
        let first = model.right_hand.first_joint + 3 * digit;
        let points = [
            joint(model.wrist),
            joint(first),
            joint(first + 1),
            joint(first + 2),
            rest.vertices_m[tip as usize],
        ];
        let palm = U_KNUCKLE - U_WRIST;
        // The thumb's first bone lies in the palm.
        let first_u = if digit == 4 { U_WRIST + 0.3 * palm } else { U_KNUCKLE };
        let second_u = if digit == 4 { U_KNUCKLE } else { U_MIDDLE_JOINT };
        let u = [U_WRIST, first_u, second_u, U_END_JOINT, U_TIP];
        for (points, u) in points.windows(2).zip(u.windows(2)) {
            bones.push(Bone { start_m: points[0], end_m: points[1], u: [u[0], u[1]] });
        }
    }
    bones
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_procedural_arm_is_laid_out_much_as_it_was_made() {
        let model = BodyModel::procedural_arm();
        let rest = model.shaped(&[]);
        let found = coordinates(&model, &rest);
        let differences = found.iter().zip(&model.uvs).map(|(a, b)| (*a - *b).abs());
        let sum: Vec2 = differences.clone().sum();
        let mean = sum / found.len() as f32;
        // Around the limb it is the same formula; along it, bones are blended where it was made.
        assert!(mean.x < 0.02 && mean.y < 1e-6, "{mean}");
        assert!(differences.map(|d| d.x).fold(0.0, f32::max) < 0.3);
    }
}

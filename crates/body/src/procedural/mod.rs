//! A right arm and hand made in code: the model that needs no files.
//!
//! It hangs on SMPL+H's skeleton with human proportions, so that motions, labels and evaluation are
//! those of the published simulator. The surface is polygonised from an implicit body
//! ([`anatomy`]) that is built around the bones ([`digits`], [`frame`]).

mod anatomy;
mod articulation;
mod binding;
mod digits;
mod frame;
mod grid;
mod proportions;
mod regressor;
#[cfg(test)]
mod tests;

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use crate::implicit::surface;
use crate::normals::area_weighted_normals;
use crate::skeleton::{JOINTS, RIGHT_ELBOW, RIGHT_HAND, RIGHT_SHOULDER, RIGHT_WRIST, parents};
use crate::{BodyModel, HandBasis, ShapeSpace};

use anatomy::Anatomy;
use binding::Binding;
use digits::{DIGITS, Digit, THUMB};

impl BodyModel {
    /// The procedural right arm: one closed surface from the upper arm to the finger tips, ten
    /// shape directions, six grasp synergies. The same on every machine.
    pub fn procedural_arm() -> Self {
        let digits = digits::digits();
        let joints_m = frame::rest_joints(&digits);
        let anatomy = Anatomy::new(&digits);
        let (template_m, faces) = surface(|point_m| anatomy.distance(point_m), &grid::grid());
        let bindings = binding::bind(&template_m, &faces, &anatomy, &digits);
        let right_hand = articulation::right_hand(&digits);
        let (joint_regressor, joint_offsets_m) = joint_rows(&template_m, &joints_m);
        Self {
            shape_directions_m: proportions::shape_directions(
                &template_m,
                &bindings,
                &joints_m,
                &digits,
            ),
            shape_space: ShapeSpace::Linear,
            pose_directions_m: Vec::new(),
            joint_regressor,
            joint_offsets_m,
            joint_directions_m: Vec::new(),
            parents: parents().to_vec(),
            skin: bindings.iter().map(binding::skin_weights).collect(),
            further_weights: Vec::new(),
            uvs: texture_coordinates(&template_m, &faces, &bindings),
            left_hand: Some(articulation::mirrored(&right_hand)),
            right_hand,
            wrist: RIGHT_WRIST,
            fingertips: fingertips(&template_m, &digits),
            template_m,
            faces,
        }
    }
}

/// All joints at rest, hands included.
pub(crate) fn rest_joints() -> [Vec3; JOINTS] {
    frame::rest_joints(&digits::digits())
}

/// How the left and the right hand articulate.
pub(crate) fn hands_at_rest() -> (HandBasis, HandBasis) {
    let right = articulation::right_hand(&digits::digits());
    (articulation::mirrored(&right), right)
}

/// Rows and offsets of all joints: those inside the surface follow it, the others stay.
fn joint_rows(vertices_m: &[Vec3], joints_m: &[Vec3; JOINTS]) -> (Vec<Vec<(u32, f32)>>, Vec<Vec3>) {
    let drawn =
        |joint: usize| matches!(joint, RIGHT_SHOULDER | RIGHT_ELBOW | RIGHT_WRIST | RIGHT_HAND..);
    joints_m
        .iter()
        .enumerate()
        .map(|(joint, &joint_m)| {
            if drawn(joint) {
                (regressor::regressor_row(vertices_m, joint_m), Vec3::ZERO)
            } else {
                (Vec::new(), joint_m)
            }
        })
        .unzip()
}

/// Texture coordinates in the layout of [`crate::texture_layout`].
fn texture_coordinates(vertices_m: &[Vec3], faces: &[[u32; 3]], bindings: &[Binding]) -> Vec<Vec2> {
    area_weighted_normals(vertices_m, faces)
        .iter()
        .zip(bindings)
        .map(|(normal, binding)| Vec2::new(binding.along, normal.y.clamp(-1.0, 1.0).acos() / PI))
        .collect()
}

/// The vertices nearest to the tips: thumb, index, middle, ring, pinky.
fn fingertips(vertices_m: &[Vec3], digits: &[Digit; DIGITS]) -> [u32; 5] {
    const INDEX: usize = 0;
    const MIDDLE: usize = 1;
    const PINKY: usize = 2;
    const RING: usize = 3;
    [THUMB, INDEX, MIDDLE, RING, PINKY].map(|digit| {
        let tip_m = digits[digit].points_m[3];
        let nearest = vertices_m
            .iter()
            .enumerate()
            .min_by(|a, b| a.1.distance_squared(tip_m).total_cmp(&b.1.distance_squared(tip_m)));
        nearest.map_or(0, |(vertex, _)| vertex as u32)
    })
}

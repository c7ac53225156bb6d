//! A whole human made in code: a body that needs no files and no licence.
//!
//! It hangs on SMPL+H's skeleton, so that motions move it as they move the published bodies. The
//! surface is polygonised from an implicit body ([`anatomy`]); the same on every machine.

mod anatomy;
mod bones;
mod garments;
mod proportions;
#[cfg(test)]
mod tests;

use glam::{Vec2, Vec3};

pub use garments::Garments;

use crate::clothes_layout;
use crate::implicit::{Grid, surface};
use crate::model::SkinWeights;
use crate::normals::area_weighted_normals;
use crate::procedural::{hands_at_rest, rest_joints};
use crate::skeleton::{JOINTS, RIGHT_WRIST, parents};
use crate::{BodyModel, ShapeSpace};

/// Size of the cells in which the surface is looked for.
const CELL_M: f32 = 0.021;
/// Opposite corners of the space that the body takes at rest.
const SPACE_M: [Vec3; 2] = [Vec3::new(-0.92, -1.25, -0.22), Vec3::new(0.92, 0.62, 0.24)];
/// The same with hats, skirts and bags.
const DRESSED_SPACE_M: [Vec3; 2] = [Vec3::new(-0.95, -1.28, -0.36), Vec3::new(0.95, 0.74, 0.32)];

impl BodyModel {
    /// The procedural human: one closed surface from head to toes, twelve shape directions
    /// (stature, weight, legs, shoulders, hips, belly, arms, muscles, head, hands and feet,
    /// trousers, top). Hands are mittens that the wrists move. [`clothes_layout`] says what lies
    /// where in its texture.
    pub fn procedural_human() -> Self {
        let anatomy = anatomy::Anatomy::new();
        Self::human_of(|point_m| anatomy.distance(point_m), SPACE_M)
    }

    /// The same in an outfit: skeleton, skinning and shape directions are those of the bare one.
    pub fn dressed_human(garments: &Garments) -> Self {
        let anatomy = anatomy::Anatomy::new();
        let dressed = |point_m| garments.over(anatomy.distance(point_m), point_m);
        Self::human_of(dressed, DRESSED_SPACE_M)
    }

    /// The human whose surface at rest is where `distance` is zero.
    fn human_of(distance: impl Fn(Vec3) -> f32, [low_m, high_m]: [Vec3; 2]) -> Self {
        let (template_m, faces) = surface(distance, &Grid::even(low_m, high_m, CELL_M));
        let joints_m = rest_joints();
        let bones = bones::bones();
        let shares: Vec<[f32; JOINTS]> =
            template_m.iter().map(|&point_m| bones::shares(&bones, point_m)).collect();
        let directions = proportions::directions(&template_m, &shares, &joints_m);
        let (left_hand, right_hand) = hands_at_rest();
        Self {
            shape_directions_m: directions.vertices_m,
            shape_space: ShapeSpace::Linear,
            pose_directions_m: Vec::new(),
            joint_regressor: vec![Vec::new(); JOINTS],
            joint_offsets_m: joints_m.to_vec(),
            joint_directions_m: directions.joints_m,
            parents: parents().to_vec(),
            skin: shares
                .iter()
                .map(|shares| SkinWeights::strongest(shares.iter().copied().enumerate()))
                .collect(),
            further_weights: Vec::new(),
            uvs: texture_coordinates(&template_m, &faces),
            left_hand: Some(left_hand),
            right_hand,
            wrist: RIGHT_WRIST,
            fingertips: [nearest(&template_m, Vec3::new(-0.87, 0.21, -0.04)); 5],
            template_m,
            faces,
        }
    }
}

fn texture_coordinates(vertices_m: &[Vec3], faces: &[[u32; 3]]) -> Vec<Vec2> {
    let normals = area_weighted_normals(vertices_m, faces);
    vertices_m
        .iter()
        .zip(&normals)
        .map(|(&at_m, &normal)| clothes_layout::coordinates(at_m, normal))
        .collect()
}

/// The vertex nearest to a point: where a mitten ends.
pub(crate) fn nearest(vertices_m: &[Vec3], point_m: Vec3) -> u32 {
    let distance = |vertex_m: &Vec3| vertex_m.distance_squared(point_m);
    let places = vertices_m.iter().enumerate();
    places.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))).map_or(0, |(i, _)| i as u32)
}

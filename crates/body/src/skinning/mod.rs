//! From a shape and a pose to vertices in the world.
//!
//! # Model
//! Linear blend skinning: joint transforms are chained from the root,
//! `Gᵢ = G_parent·[Rᵢ | Jᵢ − J_parent]`, `Aᵢ = Gᵢ·T(−Jᵢ)`, and a vertex moves by `Σ wⱼ·Aⱼ`. Normals
//! turn by the 3x3 part of the same sum, as published, which is exact for rigid parts only.
//!
//! # Source
//! Loper et al., *SMPL* (SIGGRAPH Asia 2015), Eq. 2-4, 6-9.

mod blend;
#[cfg(test)]
mod tests;

use evpose_pose::rotation::matrix_from_axis_angle;
use evpose_pose::{EVALUATION_JOINTS, HandParams};
use glam::{Affine3A, Mat3, Vec3};

use crate::fingers::HandRotations;
use crate::normals::area_weighted_normals;
use crate::{BodyModel, BodyPose, PosedBody, ShapedBody};

impl BodyModel {
    /// Poses `shaped`; `out` is overwritten.
    pub fn pose(&self, shaped: &ShapedBody, pose: &BodyPose, out: &mut PosedBody) {
        self.pose_joints(shaped, pose, out);
        self.skin_surface(shaped, pose, out);
    }

    /// The hand placed so that its wrist frame is the one of `params`; the arm hangs on it as in
    /// the published player.
    ///
    /// The whole body moves by `T(position)·R(rotation)·(T(wrist)·R(wrist))⁻¹`.
    pub fn pose_hand(&self, shaped: &ShapedBody, params: &HandParams, out: &mut PosedBody) {
        self.pose_hand_at(shaped, params, Vec3::ZERO, out);
    }

    /// The same with the forearm at another angle to the hand: `wrist` is the axis times the angle,
    /// in radians, by which the hand is bent against it.
    pub fn pose_hand_at(
        &self,
        shaped: &ShapedBody,
        params: &HandParams,
        wrist: Vec3,
        out: &mut PosedBody,
    ) {
        let mut pose = BodyPose::for_playback(self, params);
        pose.joints[self.wrist] = wrist;
        self.place_hand(shaped, &pose, params, out);
    }

    /// As [`Self::pose_hand`], with rotations of the hand's joints in place of its articulation.
    pub fn pose_hand_with(
        &self,
        shaped: &ShapedBody,
        params: &HandParams,
        rotations: &HandRotations,
        out: &mut PosedBody,
    ) {
        let mut pose = BodyPose::for_playback(self, params);
        pose.set_hand_rotations(&self.right_hand, rotations);
        // The wrist's own rotation does not count: it is placed.
        self.place_hand(shaped, &pose, params, out);
    }

    /// The evaluated points of [`Self::pose_hand`], in the order of [`EVALUATION_JOINTS`], in metres: of the surface, only
    /// the fingertips are moved.
    pub fn hand_points(
        &self,
        shaped: &ShapedBody,
        params: &HandParams,
    ) -> [Vec3; EVALUATION_JOINTS.len()] {
        let pose = BodyPose::for_playback(self, params);
        let mut posed = PosedBody::default();
        self.place_joints(shaped, &pose, params, &mut posed);
        let tips_m = self.fingertips.map(|vertex| self.vertex_m(vertex, shaped, &pose, &posed));
        posed.points_with(self, tips_m)
    }

    /// Moves the body in `pose` so that its wrist frame is the one of `params`.
    fn place_hand(
        &self,
        shaped: &ShapedBody,
        pose: &BodyPose,
        params: &HandParams,
        out: &mut PosedBody,
    ) {
        self.place_joints(shaped, pose, params, out);
        self.skin_surface(shaped, pose, out);
    }

    /// As [`Self::place_hand`], without the surface.
    fn place_joints(
        &self,
        shaped: &ShapedBody,
        pose: &BodyPose,
        params: &HandParams,
        out: &mut PosedBody,
    ) {
        self.pose_joints(shaped, pose, out);
        let predicted = Affine3A::from_mat3_translation(
            matrix_from_axis_angle(params.rotation),
            params.translation_m,
        );
        let world_from_body = predicted * out.joints[self.wrist].inverse();
        for joint in &mut out.joints {
            *joint = world_from_body * *joint;
        }
        // Exactly, not up to the rounding of an inverse.
        out.joints[self.wrist] = predicted;
    }

    /// A single vertex with the joints of `posed`, in metres.
    fn vertex_m(
        &self,
        vertex: u32,
        shaped: &ShapedBody,
        pose: &BodyPose,
        posed: &PosedBody,
    ) -> Vec3 {
        let index = vertex as usize;
        let mut rest_m = shaped.vertices_m[index];
        for (direction_m, value) in self.pose_directions_m.iter().zip(pose_feature(pose)) {
            rest_m += direction_m[index] * value;
        }
        let moved_m = |(joint, weight): (usize, f32)| {
            weight * posed.joints[joint].transform_point3(rest_m - shaped.joints_m[joint])
        };
        let further = self.further_weights.iter().filter(|further| further.vertex == vertex);
        let further = further.map(|further| (usize::from(further.joint), further.weight));
        self.skin[index].iter().chain(further).map(moved_m).sum()
    }

    /// Transforms of the joints only: all that following the wrist takes.
    pub fn pose_joints(&self, shaped: &ShapedBody, pose: &BodyPose, out: &mut PosedBody) {
        out.joints.clear();
        for (joint, (&parent, &rest_m)) in self.parents.iter().zip(&shaped.joints_m).enumerate() {
            let rotation = pose.joints[joint];
            // Most joints of the body rest.
            let matrix = if rotation == Vec3::ZERO {
                Mat3::IDENTITY
            } else {
                matrix_from_axis_angle(rotation)
            };
            let transform = match parent {
                None => Affine3A::from_mat3_translation(matrix, rest_m + pose.translation_m),
                Some(parent) => {
                    let offset_m = rest_m - shaped.joints_m[parent];
                    out.joints[parent] * Affine3A::from_mat3_translation(matrix, offset_m)
                }
            };
            out.joints.push(transform);
        }
    }

    /// Moves the surface with the joints already in `out`.
    fn skin_surface(&self, shaped: &ShapedBody, pose: &BodyPose, out: &mut PosedBody) {
        let world_from_rest: Vec<Affine3A> = out
            .joints
            .iter()
            .zip(&shaped.joints_m)
            .map(|(joint, &rest_m)| *joint * Affine3A::from_translation(-rest_m))
            .collect();
        let PosedBody { vertices_m, normals, .. } = out;
        if self.pose_directions_m.is_empty() {
            self.blend(&world_from_rest, &shaped.vertices_m, &shaped.normals, vertices_m, normals);
        } else {
            let corrected_m = self.with_pose_correctives(&shaped.vertices_m, pose);
            let rest_normals = area_weighted_normals(&corrected_m, &self.faces);
            self.blend(&world_from_rest, &corrected_m, &rest_normals, vertices_m, normals);
        }
    }

    /// Vertices with the displacements that the rotations of joints 1.. bring.
    fn with_pose_correctives(&self, shaped_m: &[Vec3], pose: &BodyPose) -> Vec<Vec3> {
        let mut vertices_m = shaped_m.to_vec();
        for (direction_m, value) in self.pose_directions_m.iter().zip(pose_feature(pose)) {
            if value != 0.0 {
                for (vertex_m, &offset_m) in vertices_m.iter_mut().zip(direction_m) {
                    *vertex_m += offset_m * value;
                }
            }
        }
        vertices_m
    }
}

/// The values that displacements of vertices are in proportion to: rotations of joints 1.. less the identity.
fn pose_feature(pose: &BodyPose) -> impl Iterator<Item = f32> {
    pose.joints.iter().skip(1).flat_map(|&rotation| {
        // Row by row: the transpose of glam's columns.
        (matrix_from_axis_angle(rotation) - Mat3::IDENTITY).transpose().to_cols_array()
    })
}

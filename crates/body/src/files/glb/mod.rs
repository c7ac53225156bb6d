//! Hands of binary glTF files (`.glb`) whose joints have the names of WebXR.
//!
//! # Model
//! Linear blend skinning in the pose in which the mesh was bound: a joint rests where the inverse of
//! its inverse bind matrix puts it. The hand is turned so that its fingers point as those of the
//! published models do, and gets the articulation of the procedural hand, so that the 12 parameters
//! move it like any other.
//!
//! # Source
//! Khronos, *glTF 2.0*, section 3.7.3.

mod accessor;
mod joints;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::{Mat3, Mat4, Vec2, Vec3};
use gltf::binary::Glb;
use gltf::json::Root;
use gltf::{Gltf, Semantic};

use evpose_pose::HandSide;

use super::{FieldFault, ModelFile, ModelFileError, ModelKind};
use crate::texture_layout::coordinates;
use crate::{BodyModel, SkinWeights};
use evpose_pickle::Array;
use joints::{JOINTS, is_needed};

/// Joints of a hand and its wrist.
const COUNT: usize = 16;
const PARENTS: [Option<usize>; COUNT] = {
    let p = Some::<usize>;
    [
        None,
        p(0),
        p(1),
        p(2),
        p(0),
        p(4),
        p(5),
        p(0),
        p(7),
        p(8),
        p(0),
        p(10),
        p(11),
        p(0),
        p(13),
        p(14),
    ]
};
/// Thumb, index, middle, ring, pinky.
const LAST_JOINTS: [usize; 5] = [15, 3, 6, 12, 9];

/// Whether bytes are binary glTF.
pub(super) fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF")
}

/// Reads the first skinned mesh.
pub(super) fn model(path: &Path, bytes: &[u8]) -> Result<ModelFile, ModelFileError> {
    let none = |reason: &str| ModelFileError::NotAModel {
        path: path.to_owned(),
        reason: reason.to_owned(),
    };
    let fault = |field: &'static str, fault: FieldFault| ModelFileError::Field {
        path: path.to_owned(),
        field,
        fault,
    };
    // Bytes behind the length that the header states, or fewer, are not this file's.
    let stated = bytes.get(8..12).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    if stated.map(|stated| stated as usize) != Some(bytes.len()) {
        let reason = "the file has not the length that its header states".to_owned();
        return Err(ModelFileError::Archive {
            path: path.to_owned(),
            byte: bytes.len() as u64,
            reason,
        });
    }
    if !is_whole(bytes) {
        return Err(none("glTF whose meshes have no positions"));
    }
    let file = Gltf::from_slice(bytes).map_err(|error| none(&error.to_string()))?;
    let blob = file.blob.as_deref().ok_or_else(|| none("glTF without a binary part"))?;
    let node = file.nodes().find(|node| node.skin().is_some() && node.mesh().is_some());
    let skinned = node.and_then(|node| node.skin().zip(node.mesh()));
    let (skin, mesh) = skinned.ok_or_else(|| none("glTF without a skinned mesh"))?;

    let names: Vec<String> = skin.joints().map(|j| j.name().unwrap_or("").to_owned()).collect();
    let lacks: Vec<&'static str> = JOINTS
        .map(|(name, _)| name)
        .into_iter()
        .filter(|n| !names.iter().any(|m| m == n))
        .collect();
    let needed: Vec<&str> = lacks.iter().copied().filter(|name| is_needed(name)).collect();
    if !needed.is_empty() {
        return Err(none(&format!("a skin without the WebXR joints {}", needed.join(", "))));
    }
    let matrices =
        skin.inverse_bind_matrices().ok_or_else(|| none("a skin without bind matrices"))?;
    let matrices =
        accessor::read(&matrices, blob).map_err(|why| fault("inverseBindMatrices", why))?;
    let bound = bound(&matrices, names.len()).map_err(|why| fault("inverseBindMatrices", why))?;

    let (mut template_m, mut weights, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for primitive in mesh.primitives() {
        let base = template_m.len();
        let array = |semantic: Semantic, field: &'static str| {
            let accessor = primitive.get(&semantic);
            let accessor = accessor.ok_or_else(|| none(&format!("a mesh without {field}")))?;
            accessor::read(&accessor, blob).map_err(|why| fault(field, why))
        };
        let positions = array(Semantic::Positions, "POSITION")?;
        template_m.extend(points(&positions).map_err(|why| fault("POSITION", why))?);
        let (joints, shares) =
            (array(Semantic::Joints(0), "JOINTS_0")?, array(Semantic::Weights(0), "WEIGHTS_0")?);
        let count = template_m.len() - base;
        weights.extend(
            skin_of(&joints, &shares, count, &names).map_err(|why| fault("WEIGHTS_0", why))?,
        );
        let indices = primitive.indices().ok_or_else(|| none("a mesh without triangles"))?;
        let indices = accessor::read(&indices, blob).map_err(|why| fault("indices", why))?;
        for corners in indices.values.as_chunks::<3>().0 {
            if let Some(&value) = corners.iter().find(|value| !(0.0..count as f64).contains(*value))
            {
                let last = count.saturating_sub(1);
                return Err(fault(
                    "indices",
                    FieldFault::Index { index: faces.len() * 3, value, last },
                ));
            }
            faces.push(corners.map(|value| (value as usize + base) as u32));
        }
    }
    if template_m.is_empty() {
        return Err(none("a mesh without vertices"));
    }
    let at = |joint: usize| {
        let name = JOINTS.iter().find(|(name, own)| *own == joint && is_needed(name));
        name.and_then(|(name, _)| names.iter().position(|n| n == name)).map(|k| bound[k])
    };
    let rest: Vec<Mat4> = (0..COUNT).filter_map(at).collect();
    let (turn, side) = turn(&rest).ok_or_else(|| none("a hand without a direction"))?;
    let mut joints_m: Vec<Vec3> = rest.iter().map(|m| turn * m.w_axis.truncate()).collect();
    template_m.iter_mut().for_each(|vertex_m| *vertex_m = turn * *vertex_m);
    joints_m.truncate(COUNT);
    let arm = BodyModel::procedural_arm();
    let mut hand = match (side, arm.left_hand) {
        (HandSide::Left, Some(left)) => left,
        _ => arm.right_hand,
    };
    hand.first_joint = 1;
    let mut missing = vec![
        "shape directions: the hand has one shape",
        "pose correctives: skin keeps its shape where joints bend",
        "forearm: the hand ends at the wrist",
    ];
    missing.extend(lacks);
    let mut model = BodyModel {
        shape_directions_m: Vec::new(),
        pose_directions_m: Vec::new(),
        joint_regressor: vec![Vec::new(); COUNT],
        parents: PARENTS.to_vec(),
        further_weights: Vec::new(),
        uvs: vec![Vec2::ZERO; template_m.len()],
        left_hand: None,
        right_hand: hand,
        wrist: 0,
        fingertips: LAST_JOINTS.map(|joint| tip(&template_m, &weights, &joints_m, joint)),
        joint_offsets_m: joints_m,
        joint_directions_m: Vec::new(),
        skin: weights,
        template_m,
        faces,
    };
    model.uvs = coordinates(&model, &model.shaped(&[]));
    let (kind, format) = (ModelKind::Jointed(side), "binary glTF");
    Ok(ModelFile { kind, format, model, hand_components: 6, missing })
}

/// Whether the positions of every mesh exist: the library's own check of their bounds takes that for
/// granted.
fn is_whole(bytes: &[u8]) -> bool {
    let Some(root) = Glb::from_slice(bytes).ok().and_then(|glb| Root::from_slice(&glb.json).ok())
    else {
        return false;
    };
    let mut primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    primitives.all(|primitive| {
        primitive.attributes.iter().all(|(_, at)| at.value() < root.accessors.len())
    })
}

/// Where every joint is in the pose of the mesh.
fn bound(matrices: &Array, joints: usize) -> Result<Vec<Mat4>, FieldFault> {
    if matrices.shape != [joints, 16] {
        let (expected, found) = (format!("[{joints}, 16]"), matrices.shape.clone());
        return Err(FieldFault::Shape { expected, found });
    }
    let (matrices, _) = matrices.values.as_chunks::<16>();
    let inverse = |(k, matrix): (usize, &[f64; 16])| {
        let bound = Mat4::from_cols_array(&matrix.map(|value| value as f32)).inverse();
        let is_place = bound.is_finite() && bound.w_axis.abs().max_element() < 1e4;
        if is_place {
            Ok(bound)
        } else {
            Err(FieldFault::Value { index: 16 * k, value: matrix[0] })
        }
    };
    matrices.iter().enumerate().map(inverse).collect()
}

fn points(array: &Array) -> Result<Vec<Vec3>, FieldFault> {
    if array.shape.get(1) != Some(&3) {
        let (expected, found) = ("[vertices, 3]".to_owned(), array.shape.clone());
        return Err(FieldFault::Shape { expected, found });
    }
    if let Some(index) = array.values.iter().position(|value| !(value.abs() < 1e4)) {
        return Err(FieldFault::Value { index, value: array.values[index] });
    }
    let (points, _) = array.values.as_chunks::<3>();
    Ok(points.iter().map(|point| Vec3::from_array(point.map(|value| value as f32))).collect())
}

/// Weights of every vertex on the model's joints.
fn skin_of(
    joints: &Array,
    weights: &Array,
    vertices: usize,
    names: &[String],
) -> Result<Vec<SkinWeights>, FieldFault> {
    for array in [joints, weights] {
        if array.shape != [vertices, 4] {
            let (expected, found) = (format!("[{vertices}, 4]"), array.shape.clone());
            return Err(FieldFault::Shape { expected, found });
        }
    }
    let joint_of = |value: f64| {
        let name = names.get(value as usize)?;
        JOINTS.iter().find(|(known, _)| known == name).map(|(_, joint)| *joint)
    };
    let rows = joints.values.as_chunks::<4>().0.iter().zip(weights.values.as_chunks::<4>().0);
    rows.enumerate()
        .map(|(vertex, (joints, weights))| {
            let mut shares = [0.0f32; COUNT];
            for (k, (&joint, &weight)) in joints.iter().zip(weights).enumerate() {
                if weight == 0.0 {
                    continue;
                }
                let index = 4 * vertex + k;
                let joint = joint_of(joint).ok_or(FieldFault::Index {
                    index,
                    value: joint,
                    last: names.len() - 1,
                })?;
                if !(0.0..=1.0).contains(&weight) {
                    return Err(FieldFault::Value { index, value: weight });
                }
                shares[joint] += weight as f32;
            }
            let sum = shares.iter().sum::<f32>();
            if (sum - 1.0).abs() > 0.02 {
                return Err(FieldFault::Sum { vertex, sum: sum.into() });
            }
            Ok(SkinWeights::strongest(shares.into_iter().enumerate()))
        })
        .collect()
}

/// The rotation that brings fingers to the model's direction and the back of the hand up, and which
/// hand it is: seen from its back, the index finger of a right hand is left of the others.
fn turn(rest: &[Mat4]) -> Option<(Mat3, HandSide)> {
    let at = |joint: usize| Some(rest.get(joint)?.w_axis.truncate());
    let forward = (at(4)? - at(0)?).try_normalize()?;
    let across = at(1)? - at(7)?;
    let across = (across - forward * across.dot(forward)).try_normalize()?;
    let up = forward.cross(across);
    let is_right = up.dot(rest.first()?.y_axis.truncate()) > 0.0;
    let (side, forward_x) = if is_right { (HandSide::Right, -1.0) } else { (HandSide::Left, 1.0) };
    let found = Mat3::from_cols(forward * forward_x, if is_right { up } else { -up }, across);
    Some((found.transpose(), side))
}

/// The outermost vertex that a finger's last joint moves.
fn tip(vertices_m: &[Vec3], skin: &[SkinWeights], joints_m: &[Vec3], joint: usize) -> u32 {
    let (end_m, before_m) = (joints_m[joint], joints_m[joint - 1]);
    let along = |vertex: &(usize, &Vec3)| (*vertex.1 - end_m).dot(end_m - before_m);
    let of_joint = vertices_m
        .iter()
        .enumerate()
        .filter(|(vertex, _)| usize::from(skin[*vertex].joints[0]) == joint);
    of_joint.max_by(|a, b| along(a).total_cmp(&along(b))).map_or(0, |(vertex, _)| vertex as u32)
}

//! Hands of binary glTF files (`.glb`) whose joints have the names of WebXR.
//!
//! # Model
//! Linear blend skinning in the pose in which the mesh was bound: a joint rests where the inverse
//! of its inverse bind matrix puts it. The hand is turned so that its fingers point as those of the
//! published models do, and gets the articulation of the procedural hand, so that the 12 parameters
//! move it like any other.
//!
//! # Source
//! Khronos, *glTF 2.0*, section 3.7.3.

mod accessor;
mod faults;
mod joints;
mod mesh;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::{Mat3, Mat4, Vec2, Vec3};
use gltf::binary::Glb;
use gltf::json::Root;
use gltf::{Gltf, Skin};

use evpose_pose::HandSide;

use super::{FieldFault, ModelFile, ModelFileError, ModelKind};
use crate::texture_layout::coordinates;
use crate::{BodyModel, ShapeSpace, SkinWeights};
use evpose_containers::pickle::Array;
use faults::Faults;
use joints::{HAND_SIZE, JOINTS, is_needed};
use mesh::SkinnedMesh;

/// Parent of every joint, in the order of MANO.
const PARENTS: [Option<usize>; HAND_SIZE] = {
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
/// Last joints of thumb, index, middle, ring and pinky.
const LAST_JOINTS: [usize; 5] = [15, 3, 6, 12, 9];

/// Whether bytes are binary glTF.
pub(super) fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF")
}

/// Reads the first skinned mesh.
pub(super) fn model(path: &Path, bytes: &[u8]) -> Result<ModelFile, ModelFileError> {
    let faults = Faults { path };
    check_container(bytes, &faults)?;
    let file = Gltf::from_slice(bytes).map_err(|error| faults.not_a_model(&error.to_string()))?;
    let blob =
        file.blob.as_deref().ok_or_else(|| faults.not_a_model("glTF without a binary part"))?;
    let node = file.nodes().find(|node| node.skin().is_some() && node.mesh().is_some());
    let skinned = node.and_then(|node| node.skin().zip(node.mesh()));
    let (skin, mesh) = skinned.ok_or_else(|| faults.not_a_model("glTF without a skinned mesh"))?;

    let names: Vec<String> = skin.joints().map(|j| j.name().unwrap_or("").to_owned()).collect();
    let missing_joints = missing_joints(&names, &faults)?;
    let mut mesh = SkinnedMesh::read(&mesh, blob, &names, &faults)?;
    let rest = rest_joints(&skin, blob, &names, &faults)?;
    let (rotation, side) = canonical_rotation(&rest)
        .ok_or_else(|| faults.not_a_model("a hand without a direction"))?;
    let joints_m: Vec<Vec3> = rest.iter().map(|m| rotation * m.w_axis.truncate()).collect();
    mesh.template_m.iter_mut().for_each(|vertex_m| *vertex_m = rotation * *vertex_m);

    let mut missing = vec![
        "shape directions: the hand has one shape",
        "pose correctives: skin keeps its shape where joints bend",
        "forearm: the hand ends at the wrist",
    ];
    missing.extend(missing_joints);
    let (kind, format) = (ModelKind::Jointed(side), "binary glTF");
    let model = body_model(mesh, joints_m, side);
    Ok(ModelFile { kind, format, model, hand_components: 6, missing })
}

/// Checks the stated length and the positions, which the library takes for granted.
fn check_container(bytes: &[u8], faults: &Faults<'_>) -> Result<(), ModelFileError> {
    // Bytes behind the length that the header states, or fewer, are not this file's.
    let stated = bytes.get(8..12).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    if stated.map(|stated| stated as usize) != Some(bytes.len()) {
        return Err(ModelFileError::Archive {
            path: faults.path.to_owned(),
            byte: bytes.len() as u64,
            reason: "the file has not the length that its header states".to_owned(),
        });
    }
    if !is_whole(bytes) {
        return Err(faults.not_a_model("glTF whose meshes have no positions"));
    }
    Ok(())
}

/// Names of the optional joints that a skin does not have.
fn missing_joints(
    names: &[String],
    faults: &Faults<'_>,
) -> Result<Vec<&'static str>, ModelFileError> {
    let missing: Vec<&'static str> = JOINTS
        .map(|(name, _)| name)
        .into_iter()
        .filter(|n| !names.iter().any(|m| m == n))
        .collect();
    let needed: Vec<&str> = missing.iter().copied().filter(|name| is_needed(name)).collect();
    if needed.is_empty() {
        return Ok(missing);
    }
    Err(faults.not_a_model(&format!("a skin without the WebXR joints {}", needed.join(", "))))
}

/// Bind transforms of the model's joints, in their order.
fn rest_joints(
    skin: &Skin<'_>,
    blob: &[u8],
    names: &[String],
    faults: &Faults<'_>,
) -> Result<Vec<Mat4>, ModelFileError> {
    const FIELD: &str = "inverseBindMatrices";
    let matrices = skin
        .inverse_bind_matrices()
        .ok_or_else(|| faults.not_a_model("a skin without bind matrices"))?;
    let matrices =
        accessor::read(&matrices, blob).map_err(|fault| faults.in_field(FIELD, fault))?;
    let bound =
        bind_transforms(&matrices, names.len()).map_err(|fault| faults.in_field(FIELD, fault))?;
    let at = |joint: usize| {
        let name = JOINTS.iter().find(|(name, own)| *own == joint && is_needed(name));
        name.and_then(|(name, _)| names.iter().position(|n| n == name)).map(|k| bound[k])
    };
    Ok((0..HAND_SIZE).filter_map(at).collect())
}

/// The hand as a body model with the articulation of the procedural hand.
fn body_model(mesh: SkinnedMesh, joints_m: Vec<Vec3>, side: HandSide) -> BodyModel {
    let SkinnedMesh { template_m, skin, faces } = mesh;
    let arm = BodyModel::procedural_arm();
    let mut hand = match (side, arm.left_hand) {
        (HandSide::Left, Some(left)) => left,
        _ => arm.right_hand,
    };
    hand.first_joint = 1;
    let mut model = BodyModel {
        shape_directions_m: Vec::new(),
        shape_space: ShapeSpace::Linear,
        pose_directions_m: Vec::new(),
        joint_regressor: vec![Vec::new(); HAND_SIZE],
        parents: PARENTS.to_vec(),
        further_weights: Vec::new(),
        uvs: vec![Vec2::ZERO; template_m.len()],
        left_hand: None,
        right_hand: hand,
        wrist: 0,
        fingertips: LAST_JOINTS.map(|joint| tip(&template_m, &skin, &joints_m, joint)),
        joint_offsets_m: joints_m,
        joint_directions_m: Vec::new(),
        skin,
        template_m,
        faces,
    };
    // Texture coordinates follow from the rest pose.
    model.uvs = coordinates(&model, &model.shaped(&[]));
    model
}

/// Whether the positions of every mesh exist: the library's own check of their bounds takes that
/// for granted.
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

/// Inverses of the inverse bind matrices: the joints in the bind pose of the mesh.
fn bind_transforms(matrices: &Array, joints: usize) -> Result<Vec<Mat4>, FieldFault> {
    if matrices.shape != [joints, 16] {
        let (expected, actual) = (format!("[{joints}, 16]"), matrices.shape.clone());
        return Err(FieldFault::Shape { expected, actual });
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

/// The rotation to the canonical orientation, fingers along x and the back of the hand up, and the
/// side of the hand: seen from its back, the index finger of a right hand is left of the others.
fn canonical_rotation(rest: &[Mat4]) -> Option<(Mat3, HandSide)> {
    let at = |joint: usize| Some(rest.get(joint)?.w_axis.truncate());
    let forward = (at(4)? - at(0)?).try_normalize()?;
    let across = at(1)? - at(7)?;
    let across = (across - forward * across.dot(forward)).try_normalize()?;
    let up = forward.cross(across);
    let is_right = up.dot(rest.first()?.y_axis.truncate()) > 0.0;
    let (side, forward_x) = if is_right { (HandSide::Right, -1.0) } else { (HandSide::Left, 1.0) };
    let rotation = Mat3::from_cols(forward * forward_x, if is_right { up } else { -up }, across);
    Some((rotation.transpose(), side))
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

//! From the arrays of a file to a model, every one checked before it is used.

use evpose_containers::pickle::{Array, Sparse};
use evpose_pose::HandSide;
use glam::{Vec2, Vec3};

use super::fields::Fields;
use super::skin::skin;
use super::{FieldFault, ModelFile, ModelFileError, ModelKind};
use crate::skeleton::{HAND_JOINTS, JOINTS, LEFT_HAND, RIGHT_HAND, RIGHT_WRIST, parents};
use crate::texture_layout::coordinates;
use crate::{BodyModel, HandBasis, ShapeSpace};

const HAND_AND_WRIST: usize = 1 + HAND_JOINTS;
const HAND_VERTICES: usize = 778;
const BODY_VERTICES: usize = 6890;
/// Thumb, index, middle, ring, pinky.
const HAND_TIPS: [u32; 5] = [744, 320, 443, 554, 671];
const BODY_TIPS: [u32; 5] = [6207, 5782, 5906, 6017, 6134];
const ANGLES: usize = 3 * HAND_JOINTS;
/// Components of which the 12 parameters of a hand have coefficients.
const MIN_COMPONENTS: usize = 6;
/// Shape directions; the longest published file has 300.
const MAX_SHAPES: usize = 512;
/// Lengths in metres, weights and angles of a model are far below.
const MAX_MAGNITUDE: f64 = 1e4;

/// The model that the arrays describe.
pub(super) fn model(mut fields: Fields) -> Result<ModelFile, ModelFileError> {
    let tree = fields.required("kintree_table", "which joint hangs on which")?;
    // The number of joints says which kind of model it is.
    let joints = tree.shape.last().copied().unwrap_or(0);
    let is_body = match joints {
        HAND_AND_WRIST => false,
        JOINTS => true,
        _ => {
            let reason = format!("`kintree_table` of shape {:?}", tree.shape);
            let reason = reason + "; a hand has 16 joints, a body with hands 52";
            return Err(ModelFileError::NotAModel { path: fields.path().to_owned(), reason });
        }
    };
    let parents = check(&fields, "kintree_table", parents_of(&tree, joints))?;
    let count = if is_body { BODY_VERTICES } else { HAND_VERTICES };

    let template = fields.required("v_template", "vertices of the mean shape")?;
    let template_m = check(&fields, "v_template", vectors(&template, &[count, 3], 1))?.remove(0);
    let shapes = fields.required("shapedirs", "how shape coefficients move vertices")?;
    let shape_count = shapes.shape.last().copied().unwrap_or(0).min(MAX_SHAPES);
    let shape_directions_m =
        check(&fields, "shapedirs", vectors(&shapes, &[count, 3, shape_count], shape_count))?;
    let mut missing = Vec::new();
    let pose_directions_m = match fields.optional("posedirs")? {
        Some(poses) => {
            // Nine entries of a rotation for every joint but the root.
            let entries = 9 * (joints - 1);
            check(&fields, "posedirs", vectors(&poses, &[count, 3, entries], entries))?
        }
        None => {
            missing.push("pose correctives (posedirs): skin keeps its shape where joints bend");
            Vec::new()
        }
    };
    let joint_regressor = regressor(&mut fields, joints, count)?;
    let weights = fields.required("weights", "which joints move which vertices")?;
    let checked = shape(&weights, &[count, joints]).and_then(|()| skin(&weights, joints));
    let (skin, further_weights) = check(&fields, "weights", checked)?;
    let faces = fields.required("f", "triangles between vertices")?;
    let faces = check(&fields, "f", triangles(&faces, count))?;

    let (left_hand, (right_hand, hand_components)) = if is_body {
        let (left, _) = basis(&mut fields, "hands_componentsl", "hands_meanl", LEFT_HAND)?;
        (Some(left), basis(&mut fields, "hands_componentsr", "hands_meanr", RIGHT_HAND)?)
    } else {
        missing.push("forearm: the hand ends at the wrist");
        (None, basis(&mut fields, "hands_components", "hands_mean", 1)?)
    };
    // Files of this kind have none.
    missing.push("texture coordinates: a made-up skin is laid along the limb");
    let mut model = BodyModel {
        uvs: vec![Vec2::ZERO; count],
        joint_offsets_m: vec![Vec3::ZERO; joints],
        joint_directions_m: Vec::new(),
        wrist: if is_body { RIGHT_WRIST } else { 0 },
        fingertips: if is_body { BODY_TIPS } else { HAND_TIPS },
        template_m,
        shape_directions_m,
        shape_space: ShapeSpace::Linear,
        pose_directions_m,
        joint_regressor,
        parents,
        skin,
        further_weights,
        faces,
        left_hand,
        right_hand,
    };
    // Coordinates follow from the shape at rest, which needs the model.
    model.uvs = coordinates(&model, &model.shaped(&[]));
    if !is_body && side(&model) == HandSide::Left && has_mirrored_size(&model) {
        missing.push(MIRRORED);
        let offsets_m = model.shape_directions_m.iter_mut().flatten();
        offsets_m.for_each(|offset_m| offset_m.x = -offset_m.x);
    }
    let kind = if is_body { ModelKind::Body } else { ModelKind::Hand(side(&model)) };
    Ok(ModelFile { kind, format: fields.format(), model, hand_components, missing })
}

/// Note on a left hand with the shape directions of a right one.
const MIRRORED: &str = "shape directions of a left hand: the file has those of the right one along x, as the published \
                        MANO_LEFT.pkl, and they are mirrored";
/// Correlation of the offsets of the first shape direction with the vertices' positions from which on
/// it is one of size, as in MANO.
const MIN_CORRELATION: f32 = 0.3;

/// Whether the first shape direction, that of the size of a hand, makes it longer along x where it makes
/// it shorter along y and z: the published `MANO_LEFT.pkl` has offsets along x with the wrong sign.
///
/// # Source
/// <https://github.com/vchoutas/smplx/issues/48>; InterHand2.6M's code turns the sign likewise.
fn has_mirrored_size(model: &BodyModel) -> bool {
    let Some(size_m) = model.shape_directions_m.first() else { return false };
    let template_m = &model.template_m;
    let mean_m = template_m.iter().sum::<Vec3>() / template_m.len() as f32;
    // Along x alone, and along the other two together.
    let correlation = |axes: Vec3| {
        let (mut product, mut places, mut offsets) = (0.0, 0.0, 0.0);
        for (vertex_m, offset_m) in template_m.iter().zip(size_m) {
            let (place, offset) = ((*vertex_m - mean_m) * axes, *offset_m * axes);
            product += place.dot(offset);
            places += place.length_squared();
            offsets += offset.length_squared();
        }
        product / (places * offsets).sqrt().max(f32::MIN_POSITIVE)
    };
    let (x, others) = (correlation(Vec3::X), correlation(Vec3::Y + Vec3::Z));
    x * others < 0.0 && x.abs().min(others.abs()) > MIN_CORRELATION
}

fn check<T>(
    fields: &Fields,
    field: &'static str,
    result: Result<T, FieldFault>,
) -> Result<T, ModelFileError> {
    result.map_err(|fault| fields.fault(field, fault))
}

fn shape(array: &Array, expected: &[usize]) -> Result<(), FieldFault> {
    if array.shape == expected {
        return Ok(());
    }
    Err(FieldFault::Shape { expected: format!("{expected:?}"), actual: array.shape.clone() })
}

fn checked(index: usize, value: f64) -> Result<f32, FieldFault> {
    // Not a number compares as false.
    if value.abs() <= MAX_MAGNITUDE {
        Ok(value as f32)
    } else {
        Err(FieldFault::Value { index, value })
    }
}

/// `[vertices, 3, directions]` as one list of vectors for every direction.
fn vectors(
    array: &Array,
    expected: &[usize],
    directions: usize,
) -> Result<Vec<Vec<Vec3>>, FieldFault> {
    shape(array, expected)?;
    let values: Vec<f32> = array
        .values
        .iter()
        .enumerate()
        .map(|(index, &value)| checked(index, value))
        .collect::<Result<_, _>>()?;
    Ok((0..directions)
        .map(|direction| {
            let vertices = values.chunks_exact(3 * directions);
            let at = |v: &[f32], axis: usize| v[axis * directions + direction];
            vertices.map(|v| Vec3::new(at(v, 0), at(v, 1), at(v, 2))).collect()
        })
        .collect())
}

/// The tree: row 0 has the parent's number in the column of every joint, row 1 the joint's own; the
/// root's parent is a number no joint has. Motion and hands rely on the published tree.
fn parents_of(table: &Array, joints: usize) -> Result<Vec<Option<usize>>, FieldFault> {
    shape(table, &[2, joints])?;
    let (parent_ids, own_ids) = table.values.split_at(joints);
    let column = |id: f64| own_ids.iter().position(|&own| own == id);
    let expected: Vec<Option<usize>> = if joints == JOINTS {
        parents().to_vec()
    } else {
        // Three joints a finger, the first of which hangs on the wrist.
        (0..joints).map(|j| j.checked_sub(1).map(|k| if k % 3 == 0 { 0 } else { k })).collect()
    };
    for (joint, (&parent, expected)) in parent_ids.iter().zip(&expected).enumerate() {
        if column(parent) != *expected {
            return Err(FieldFault::Tree { joint });
        }
    }
    Ok(expected)
}

/// The joint regressor: a matrix, a sparse one, or its entries as rows `(joint, vertex, weight)`.
fn regressor(
    fields: &mut Fields,
    joints: usize,
    vertices: usize,
) -> Result<Vec<Vec<(u32, f32)>>, ModelFileError> {
    const FIELD: &str = "J_regressor";
    let sparse = match fields.sparse(FIELD)? {
        Some(sparse) => sparse,
        None => {
            let array = fields.required(FIELD, "where joints lie between vertices")?;
            check(fields, FIELD, entries(&array, joints, vertices))?
        }
    };
    let mut rows = vec![Vec::new(); joints];
    let expected = [joints, vertices];
    // Entries are places in a matrix of this shape.
    if sparse.shape != expected {
        let (expected, actual) = (format!("{expected:?}"), sparse.shape.to_vec());
        return Err(fields.fault(FIELD, FieldFault::Shape { expected, actual }));
    }
    for (index, (joint, vertex, weight)) in sparse.entries.into_iter().enumerate() {
        let weight = check(fields, FIELD, checked(index, weight))?;
        // Dense matrices are nearly all zeros.
        if weight != 0.0 {
            rows[joint].push((vertex as u32, weight));
        }
    }
    Ok(rows)
}

fn entries(array: &Array, joints: usize, vertices: usize) -> Result<Sparse, FieldFault> {
    let size = [joints, vertices];
    match array.shape.as_slice() {
        &[rows, columns] if [rows, columns] == size => {
            let entries = array.values.iter().enumerate().filter(|(_, value)| **value != 0.0);
            let entries = entries.map(|(at, &value)| (at / vertices, at % vertices, value));
            Ok(Sparse { shape: size, entries: entries.collect() })
        }
        [_, 3] => {
            let column = |k: usize| -> Vec<f64> {
                array.values.iter().skip(k).step_by(3).copied().collect()
            };
            Ok(Sparse::from_triplets(size, &column(0), &column(1), &column(2))?)
        }
        actual => {
            let expected = format!("{size:?}, or rows of (joint, vertex, weight)");
            Err(FieldFault::Shape { expected, actual: actual.to_vec() })
        }
    }
}

fn triangles(array: &Array, vertices: usize) -> Result<Vec<[u32; 3]>, FieldFault> {
    let (&[_, 3], (corners, [])) = (array.shape.as_slice(), array.values.as_chunks::<3>()) else {
        let actual = array.shape.clone();
        return Err(FieldFault::Shape { expected: "[triangles, 3]".to_owned(), actual });
    };
    let mut faces = Vec::with_capacity(corners.len());
    for (face, corners) in corners.iter().enumerate() {
        for (k, &value) in corners.iter().enumerate() {
            if !(value >= 0.0 && value < vertices as f64 && value.fract() == 0.0) {
                let (index, last) = (3 * face + k, vertices - 1);
                return Err(FieldFault::Index { index, value, last });
            }
        }
        faces.push(corners.map(|value| value as u32));
    }
    Ok(faces)
}

/// A hand's articulation, and how many components it has.
fn basis(
    fields: &mut Fields,
    components: &'static str,
    mean: &'static str,
    first_joint: usize,
) -> Result<(HandBasis, usize), ModelFileError> {
    let rows = fields.required(components, "how coefficients bend the fingers")?;
    let count = rows.shape.first().copied().unwrap_or(0);
    if rows.shape != [count, ANGLES] || !(MIN_COMPONENTS..=ANGLES).contains(&count) {
        let expected = format!("[{ANGLES}, {ANGLES}], or fewer rows but at least 6");
        return Err(fields.fault(components, FieldFault::Shape { expected, actual: rows.shape }));
    }
    let offsets = fields.required(mean, "the hand's mean pose")?;
    check(fields, mean, shape(&offsets, &[ANGLES]))?;
    let mut basis = HandBasis {
        first_joint,
        mean: [0.0; ANGLES],
        components: Box::new([[0.0; ANGLES]; ANGLES]),
    };
    for (index, &value) in rows.values.iter().enumerate() {
        basis.components[index / ANGLES][index % ANGLES] =
            check(fields, components, checked(index, value))?;
    }
    for (index, &value) in offsets.values.iter().enumerate() {
        basis.mean[index] = check(fields, mean, checked(index, value))?;
    }
    Ok((basis, count))
}

/// Side of the hand: arms are stretched out, the body's left is along +x.
fn side(model: &BodyModel) -> HandSide {
    let tips = model.fingertips.iter().map(|&tip| model.template_m[tip as usize].x);
    let tips: f32 = tips.sum::<f32>() / model.fingertips.len() as f32;
    let all = model.template_m.iter().map(|vertex_m| vertex_m.x).sum::<f32>();
    if tips > all / model.template_m.len() as f32 { HandSide::Left } else { HandSide::Right }
}

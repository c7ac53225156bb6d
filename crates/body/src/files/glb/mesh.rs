//! Vertices, skin weights and faces of a skinned glTF mesh.

use evpose_containers::pickle::Array;
use glam::Vec3;
use gltf::{Mesh, Primitive, Semantic};

use super::accessor;
use super::faults::Faults;
use super::joints::{HAND_SIZE, JOINTS};
use crate::SkinWeights;
use crate::files::{FieldFault, ModelFileError};

/// All primitives of a mesh, joined.
#[derive(Default)]
pub(super) struct SkinnedMesh {
    /// Vertex positions in the bind pose, in metres.
    pub(super) template_m: Vec<Vec3>,
    pub(super) skin: Vec<SkinWeights>,
    pub(super) faces: Vec<[u32; 3]>,
}

impl SkinnedMesh {
    /// Reads a mesh whose skin has joints of these names.
    pub(super) fn read(
        mesh: &Mesh<'_>,
        blob: &[u8],
        names: &[String],
        faults: &Faults<'_>,
    ) -> Result<Self, ModelFileError> {
        let mut joined = Self::default();
        for primitive in mesh.primitives() {
            joined.push(&primitive, blob, names, faults)?;
        }
        if joined.template_m.is_empty() {
            return Err(faults.not_a_model("a mesh without vertices"));
        }
        Ok(joined)
    }

    /// Appends a primitive.
    fn push(
        &mut self,
        primitive: &Primitive<'_>,
        blob: &[u8],
        names: &[String],
        faults: &Faults<'_>,
    ) -> Result<(), ModelFileError> {
        // Primitives share one mesh: indices of the next begin here.
        let base = self.template_m.len();
        let array = |semantic: Semantic, field: &'static str| {
            let accessor = primitive.get(&semantic);
            let accessor =
                accessor.ok_or_else(|| faults.not_a_model(&format!("a mesh without {field}")))?;
            accessor::read(&accessor, blob).map_err(|fault| faults.in_field(field, fault))
        };
        let positions = array(Semantic::Positions, "POSITION")?;
        self.template_m
            .extend(points(&positions).map_err(|fault| faults.in_field("POSITION", fault))?);
        let (joints, weights) =
            (array(Semantic::Joints(0), "JOINTS_0")?, array(Semantic::Weights(0), "WEIGHTS_0")?);
        let count = self.template_m.len() - base;
        self.skin.extend(
            skin_weights(&joints, &weights, count, names)
                .map_err(|fault| faults.in_field("WEIGHTS_0", fault))?,
        );
        let indices =
            primitive.indices().ok_or_else(|| faults.not_a_model("a mesh without triangles"))?;
        let indices =
            accessor::read(&indices, blob).map_err(|fault| faults.in_field("indices", fault))?;
        for corners in indices.values.as_chunks::<3>().0 {
            if let Some(&value) = corners.iter().find(|value| !(0.0..count as f64).contains(*value))
            {
                let (index, last) = (self.faces.len() * 3, count.saturating_sub(1));
                return Err(faults.in_field("indices", FieldFault::Index { index, value, last }));
            }
            // Indices count from the primitive's own first vertex.
            self.faces.push(corners.map(|value| (value as usize + base) as u32));
        }
        Ok(())
    }
}

/// Vertex positions of an accessor of three components.
fn points(array: &Array) -> Result<Vec<Vec3>, FieldFault> {
    if array.shape.get(1) != Some(&3) {
        let (expected, actual) = ("[vertices, 3]".to_owned(), array.shape.clone());
        return Err(FieldFault::Shape { expected, actual });
    }
    if let Some(index) = array.values.iter().position(|value| value.is_nan() || value.abs() >= 1e4)
    {
        return Err(FieldFault::Value { index, value: array.values[index] });
    }
    let (points, _) = array.values.as_chunks::<3>();
    Ok(points.iter().map(|point| Vec3::from_array(point.map(|value| value as f32))).collect())
}

/// Skin weights of every vertex on the model's joints.
fn skin_weights(
    joints: &Array,
    weights: &Array,
    vertices: usize,
    names: &[String],
) -> Result<Vec<SkinWeights>, FieldFault> {
    for array in [joints, weights] {
        if array.shape != [vertices, 4] {
            let (expected, actual) = (format!("[{vertices}, 4]"), array.shape.clone());
            return Err(FieldFault::Shape { expected, actual });
        }
    }
    let joint_of = |value: f64| {
        let name = names.get(value as usize)?;
        JOINTS.iter().find(|(known, _)| known == name).map(|(_, joint)| *joint)
    };
    let rows = joints.values.as_chunks::<4>().0.iter().zip(weights.values.as_chunks::<4>().0);
    rows.enumerate()
        .map(|(vertex, (joints, weights))| {
            // Several bones of a file can be one joint here.
            let mut shares = [0.0f32; HAND_SIZE];
            for (k, (&joint, &weight)) in joints.iter().zip(weights).enumerate() {
                // Slots that are not used may name any joint.
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
            // Weights in bytes are rounded.
            if (sum - 1.0).abs() > 0.02 {
                return Err(FieldFault::Sum { vertex, sum: sum.into() });
            }
            Ok(SkinWeights::strongest(shares.into_iter().enumerate()))
        })
        .collect()
}

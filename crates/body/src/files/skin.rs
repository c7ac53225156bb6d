//! Skinning weights of a file: four of a vertex in place, further ones beside.

use evpose_containers::pickle::Array;

use super::FieldFault;
use crate::{FurtherWeight, SkinWeights};

/// Weights below are left out: 1e-7 of a metre-sized body is a ten-thousandth of a millimetre.
const LEAST: f64 = 1e-8;
/// How far a vertex's weights may be from a whole; single precision leaves 1e-6.
const TOLERANCE: f64 = 1e-3;

/// The weights of `[vertices, joints]`, none scaled.
///
/// # Errors
/// Negative or non-finite weights, and vertices whose weights do not have sum one.
pub(super) fn skin(
    weights: &Array,
    joints: usize,
) -> Result<(Vec<SkinWeights>, Vec<FurtherWeight>), FieldFault> {
    let (mut skin, mut further) = (Vec::new(), Vec::new());
    for (vertex, row) in weights.values.chunks_exact(joints).enumerate() {
        // Rounding leaves tiny negative weights.
        let is_weight = |value: f64| value.is_finite() && value > -TOLERANCE && value < 2.0;
        if let Some(joint) = row.iter().position(|&value| !is_weight(value)) {
            return Err(FieldFault::Value { index: vertex * joints + joint, value: row[joint] });
        }
        let sum: f64 = row.iter().sum();
        if (sum - 1.0).abs() > TOLERANCE {
            return Err(FieldFault::Sum { vertex, sum });
        }
        let mut sorted: Vec<(usize, f64)> =
            row.iter().copied().enumerate().filter(|&(_, weight)| weight > LEAST).collect();
        // Ties go by the joint's number, so that the four are the same everywhere.
        sorted.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut four = SkinWeights { joints: [0; 4], weights: [0.0; 4] };
        for (slot, (joint, weight)) in sorted.into_iter().enumerate() {
            let (joint, weight) = (joint as u8, weight as f32);
            if slot < four.joints.len() {
                four.joints[slot] = joint;
                four.weights[slot] = weight;
            } else {
                further.push(FurtherWeight { vertex: vertex as u32, joint, weight });
            }
        }
        skin.push(four);
    }
    Ok((skin, further))
}

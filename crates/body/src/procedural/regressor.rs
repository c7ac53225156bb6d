//! Joints as weighted sums of the vertices around them.
//!
//! # Model
//! The weights `wᵢ = a + b·(vᵢ − J)` over the nearest vertices with `Σ wᵢ = 1` and `Σ wᵢ·vᵢ = J`:
//! the shortest such weights. They return the joint exactly at rest, and move it exactly under any
//! affine change of its surroundings.

use glam::{Mat3, Vec3};

/// Vertices that decide where a joint is.
const NEAREST: usize = 48;

/// The sparse row of a joint at `joint_m` inside the surface.
pub(super) fn regressor_row(vertices_m: &[Vec3], joint_m: Vec3) -> Vec<(u32, f32)> {
    let mut nearest: Vec<(u32, Vec3)> = vertices_m
        .iter()
        .enumerate()
        .map(|(i, &vertex_m)| (i as u32, vertex_m - joint_m))
        .collect();
    nearest
        .sort_by(|a, b| a.1.length_squared().total_cmp(&b.1.length_squared()).then(a.0.cmp(&b.0)));
    nearest.truncate(NEAREST);

    // Weights linear in the offset that sum to 1 and have their mean at the joint.
    let sum: Vec3 = nearest.iter().map(|&(_, offset)| offset).sum();
    let moments = nearest.iter().fold(Mat3::ZERO, |m, &(_, offset)| {
        m + Mat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z)
    });
    let slope = -(moments.inverse() * sum);
    let constant = 1.0 / (nearest.len() as f32 + slope.dot(sum));
    nearest.into_iter().map(|(i, offset)| (i, constant * (1.0 + slope.dot(offset)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_returns_the_joint_and_follows_an_affine_map() {
        let vertices: Vec<Vec3> = (0..60)
            .map(|i| {
                let (a, b) = (i as f32 * 0.7, (i as f32 * 0.37).sin());
                Vec3::new(a.cos(), a.sin(), b) * 0.01 + Vec3::new(0.3, 0.002, 0.0)
            })
            .collect();
        let joint = Vec3::new(0.301, 0.0, 0.002);
        let row = regressor_row(&vertices, joint);
        let map = |p: Vec3| Vec3::new(1.1 * p.x + 0.2 * p.y, p.y - 0.1 * p.z, p.z + 0.03);
        let moved: Vec3 = row.iter().map(|&(i, w)| map(vertices[i as usize]) * w).sum();
        assert!((row.iter().map(|&(_, w)| w).sum::<f32>() - 1.0).abs() < 1e-5);
        assert!((moved - map(joint)).length() < 1e-5, "{moved}");
    }
}

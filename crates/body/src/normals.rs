//! Smooth normals of a triangle mesh.

use glam::Vec3;

/// The unit normal of every vertex: the sum of `(b − a) × (c − a)` over its faces, which weights
/// each by its area. Zero where no face has any.
pub(crate) fn area_weighted_normals(vertices_m: &[Vec3], faces: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; vertices_m.len()];
    for face in faces {
        let [a, b, c] = face.map(|i| vertices_m[i as usize]);
        let twice_area = (b - a).cross(c - a);
        for &i in face {
            normals[i as usize] += twice_area;
        }
    }
    for normal in &mut normals {
        *normal = normal.normalize_or_zero();
    }
    normals
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_of_a_cube_points_along_its_diagonal() {
        let vertices = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1]];
        let corner = area_weighted_normals(&vertices, &faces)[0];
        assert!((corner - Vec3::ONE.normalize()).length() < 1e-6);
    }
}

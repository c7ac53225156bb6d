//! Smooth normals of a triangle mesh.

use evpose_cpu::{Kernel8, LANES_8, Lanes8, dispatch};
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
    dispatch(Normalise(&mut normals));
    normals
}

/// [`normalise`] on its own.
struct Normalise<'a>(&'a mut [Vec3]);

impl Kernel8 for Normalise<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes8>(self, l: L) {
        normalise(l, self.0);
    }
}

/// Makes every vector unit; zero stays zero.
#[inline(always)]
pub(crate) fn normalise<L: Lanes8>(l: L, vectors: &mut [Vec3]) {
    for batch in vectors.chunks_mut(LANES_8) {
        let mut axes = [[0.0; LANES_8]; 3];
        for (k, vector) in batch.iter().enumerate() {
            [axes[0][k], axes[1][k], axes[2][k]] = vector.to_array();
        }
        let (x, y, z) = (l.load(axes[0]), l.load(axes[1]), l.load(axes[2]));
        let square = l.add(l.add(l.mul(x, x), l.mul(y, y)), l.mul(z, z));
        // The smallest normal number: nothing is divided by zero.
        let length = l.sqrt(l.max(square, l.splat(f32::MIN_POSITIVE)));
        let per_length = l.store(l.div(l.splat(1.0), length));
        for (vector, scale) in batch.iter_mut().zip(per_length) {
            *vector *= scale;
        }
    }
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

    #[test]
    fn vectors_become_unit_and_zero_stays_zero() {
        let mut vectors: Vec<Vec3> =
            (0..37).map(|k| Vec3::new(k as f32, 2.0 - k as f32, 0.3)).collect();
        vectors[20] = Vec3::ZERO;
        let want: Vec<Vec3> = vectors.iter().map(|v| v.normalize_or_zero()).collect();
        dispatch(Normalise(&mut vectors));
        assert!(vectors.iter().zip(&want).all(|(got, want)| got.distance(*want) < 1e-6));
        assert_eq!(vectors[20], Vec3::ZERO);
    }
}

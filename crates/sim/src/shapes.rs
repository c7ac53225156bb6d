//! Small meshes for tests.

use glam::{Vec2, Vec3};

use crate::raster::Mesh;

/// A mesh that owns its slices.
#[derive(Debug, Clone, Default)]
pub(crate) struct Shape {
    pub vertices_m: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub faces: Vec<[u32; 3]>,
}

impl Shape {
    pub(crate) fn mesh(&self) -> Mesh<'_> {
        Mesh {
            vertices_m: &self.vertices_m,
            normals: &self.normals,
            uvs: &self.uvs,
            faces: &self.faces,
        }
    }

    /// A sphere of `bands` bands from pole to pole, twice as many around, closed.
    pub(crate) fn sphere(centre_m: Vec3, radius_m: f32, bands: usize) -> Self {
        let around = 2 * bands;
        let mut shape = Self::default();
        for band in 0..=bands {
            let polar = std::f32::consts::PI * band as f32 / bands as f32;
            for step in 0..around {
                let azimuth = std::f32::consts::TAU * step as f32 / around as f32;
                let normal = Vec3::new(
                    polar.sin() * azimuth.sin(),
                    polar.cos(),
                    polar.sin() * azimuth.cos(),
                );
                shape.vertices_m.push(centre_m + radius_m * normal);
                shape.normals.push(normal);
                shape.uvs.push(Vec2::new(step as f32 / around as f32, band as f32 / bands as f32));
            }
        }
        let at = |band: usize, step: usize| {
            // The poles are one vertex each.
            let step = if band == 0 || band == bands { 0 } else { step % around };
            (band * around + step) as u32
        };
        for band in 0..bands {
            for step in 0..around {
                let (a, b) = (at(band, step), at(band + 1, step));
                let (c, d) = (at(band + 1, step + 1), at(band, step + 1));
                for face in [[a, b, c], [a, c, d]] {
                    // At the poles one of the two has no area.
                    if face[0] != face[1] && face[1] != face[2] && face[2] != face[0] {
                        shape.faces.push(face);
                    }
                }
            }
        }
        shape
    }

    /// A rectangle spanned by `across` and `up` from `corner_m`, facing `across × up`.
    pub(crate) fn quad(corner_m: Vec3, across_m: Vec3, up_m: Vec3) -> Self {
        let normal = across_m.cross(up_m).normalize_or_zero();
        Self {
            vertices_m: vec![
                corner_m,
                corner_m + across_m,
                corner_m + across_m + up_m,
                corner_m + up_m,
            ],
            normals: vec![normal; 4],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
            faces: vec![[0, 1, 2], [0, 2, 3]],
        }
    }
}

//! What varies over the surface, where pixels see it.
//!
//! # Model
//! A quantity that is linear on a face is, divided by the depth, linear in the image, and so is
//! 1/depth: both are interpolated with a pixel's affine coordinates, and their quotient is the
//! quantity. Normals are not divided: only their direction counts.

use evpose_core::{LANES, Lanes};
use glam::{Vec2, Vec3};

use super::visible::Cut;
use super::{Mesh, Raster, SeenPixel};

/// Normal, texture coordinates and one, divided by the depth, and nothing: one vector.
type Varying = [f32; LANES];

/// Those of all corners of a drawn mesh.
#[derive(Debug, Clone, Default)]
pub(crate) struct Varyings(Vec<Varying>);

impl Varyings {
    /// Of the vertices of `mesh`, and of those that clipping made.
    pub(crate) fn gather(&mut self, raster: &Raster, mesh: &Mesh<'_>) {
        let attributes = mesh.normals.iter().zip(mesh.uvs);
        self.0.clear();
        self.0.extend(
            attributes
                .zip(&raster.screen)
                .map(|((&normal, &uv), vertex)| divided(normal, uv, vertex.inverse_depth)),
        );
        let cut_corners = raster.screen.get(mesh.vertices_m.len()..).unwrap_or_default();
        for (&Cut { face, in_face }, vertex) in raster.cuts.iter().zip(cut_corners) {
            let [a, b, c] = mesh.faces[face as usize].map(|v| v as usize);
            let normal = mesh.normals[a] * in_face.x
                + mesh.normals[b] * in_face.y
                + mesh.normals[c] * in_face.z;
            let uv = mesh.uvs[a] * in_face.x + mesh.uvs[b] * in_face.y + mesh.uvs[c] * in_face.z;
            self.0.push(divided(normal, uv, vertex.inverse_depth));
        }
    }

    /// At a pixel.
    #[inline(always)]
    pub(crate) fn at<L: Lanes>(&self, l: L, raster: &Raster, pixel: SeenPixel) -> L::F {
        let triangle = &raster.triangles[pixel.triangle as usize];
        let [second, third] = triangle.affine(usize::from(pixel.x), usize::from(pixel.y));
        let first = 1.0 - second - third;
        let [a, b, c] = triangle.corners;
        let (a, b, c) = (self.0[a as usize], self.0[b as usize], self.0[c as usize]);
        let sum = l.add(l.mul(l.load(a), l.splat(first)), l.mul(l.load(b), l.splat(second)));
        l.add(sum, l.mul(l.load(c), l.splat(third)))
    }
}

#[inline(always)]
fn divided(normal: Vec3, uv: Vec2, inverse_depth: f32) -> Varying {
    let [x, y, z] = normal.to_array().map(|n| n * inverse_depth);
    [x, y, z, uv.x * inverse_depth, uv.y * inverse_depth, inverse_depth, 0.0, 0.0]
}

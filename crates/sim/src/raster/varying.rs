//! Varyings: quantities interpolated over the faces at covered pixels.
//!
//! # Model
//! A quantity that is linear on a face is, divided by the depth, linear in the image, and so is
//! 1/depth: both are interpolated with a pixel's affine coordinates, and their quotient is the
//! quantity. Normals are not divided: only their direction counts.

use evpose_cpu::{Kernel8, LANES_8, Lanes8, dispatch};
use glam::{Vec2, Vec3};

use super::project::ScreenVertex;
use super::rows::eight_rows;
use super::triangle::Triangle;
use super::visible::Cut;
use super::{Mesh, Raster};

/// Normal, texture coordinates and one, divided by the depth, and two zeros: one vector.
type Varying = [f32; LANES_8];

/// Varyings of all vertices of a drawn mesh.
#[derive(Debug, Clone, Default)]
pub(crate) struct Varyings(Vec<Varying>);

impl Varyings {
    /// Computes the varyings of the vertices of `mesh`, and of those that clipping made.
    pub(crate) fn gather(&mut self, raster: &Raster, mesh: &Mesh<'_>) {
        dispatch(Gather { screen: &raster.screen, mesh, out: &mut self.0 });
        let cut_corners = raster.screen.get(mesh.vertices_m.len()..).unwrap_or_default();
        for (&Cut { face, in_face }, vertex) in raster.cuts.iter().zip(cut_corners) {
            let [a, b, c] = mesh.faces[face as usize].map(|v| v as usize);
            let normal = mesh.normals[a] * in_face.x
                + mesh.normals[b] * in_face.y
                + mesh.normals[c] * in_face.z;
            let uv = mesh.uvs[a] * in_face.x + mesh.uvs[b] * in_face.y + mesh.uvs[c] * in_face.z;
            self.0.push(divided(normal, uv, vertex.inverse_depth()));
        }
    }

    /// Interpolates at eight pixels, given by packed positions and triangle indices: the components
    /// of a [`Varying`], each for all pixels.
    #[inline(always)]
    pub(crate) fn at<L: Lanes8>(
        &self,
        l: L,
        raster: &Raster,
        positions: &[i32; LANES_8],
        triangles: &[i32; LANES_8],
    ) -> [L::F; LANES_8] {
        let triangle = |k: usize| &raster.triangles[triangles[k] as usize];
        let (a, b, c, d) = (triangle(0), triangle(1), triangle(2), triangle(3));
        let (e, f, g, h) = (triangle(4), triangle(5), triangle(6), triangle(7));
        let triangles = [a, b, c, d, e, f, g, h];
        let [second, third] = Triangle::affine_lanes(l, triangles, l.load_i(*positions));
        // Weights sum to one, so that the first needs no plane of its own.
        let first = l.sub(l.sub(l.splat(1.0), second), third);
        let (first, second, third) = (l.store(first), l.store(second), l.store(third));
        let mut seen = [l.splat(0.0); LANES_8];
        // One by one: the corners of each pixel's face lie apart in memory.
        for (k, seen) in seen.iter_mut().enumerate() {
            let [a, b, c] = triangles[k].corners;
            let (a, b, c) = (self.0[a as usize], self.0[b as usize], self.0[c as usize]);
            let of_a = l.mul(l.load(a), l.splat(first[k]));
            let of_b = l.mul(l.load(b), l.splat(second[k]));
            *seen = l.add(l.add(of_a, of_b), l.mul(l.load(c), l.splat(third[k])));
        }
        l.transpose(seen)
    }
}

/// Varyings of the vertices of a mesh, eight at a time.
struct Gather<'a> {
    screen: &'a [ScreenVertex],
    mesh: &'a Mesh<'a>,
    out: &'a mut Vec<Varying>,
}

impl Kernel8 for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes8>(self, l: L) {
        let Self { screen, mesh, out } = self;
        let vertices = mesh.vertices_m.len();
        let normals = bytemuck::must_cast_slice(mesh.normals);
        let uvs = bytemuck::must_cast_slice(mesh.uvs);
        let screen = bytemuck::must_cast_slice(&screen[..vertices]);
        out.resize(vertices.next_multiple_of(LANES_8), Varying::default());
        let mut padding = [0; 4 * LANES_8];
        for (batch, out) in out.as_chunks_mut::<LANES_8>().0.iter_mut().enumerate() {
            let first = batch * LANES_8;
            let [x, y, z, _] = l.gather_columns(eight_rows::<3>(normals, first, &mut padding));
            let [u, v, _, _] = l.gather_columns(eight_rows::<2>(uvs, first, &mut padding));
            let [_, _, inverse_depth, _] =
                l.gather_columns(eight_rows::<4>(screen, first, &mut padding));
            // Divided by depth, components are linear over the image; the shader multiplies it
            // back.
            let inverse_depth = l.from_bits(inverse_depth);
            let [a, b, c, d, e, f, g, h] = l.transpose([
                l.mul(l.from_bits(x), inverse_depth),
                l.mul(l.from_bits(y), inverse_depth),
                l.mul(l.from_bits(z), inverse_depth),
                l.mul(l.from_bits(u), inverse_depth),
                l.mul(l.from_bits(v), inverse_depth),
                inverse_depth,
                l.splat(0.0),
                l.splat(0.0),
            ]);
            (out[0], out[1], out[2], out[3]) = (l.store(a), l.store(b), l.store(c), l.store(d));
            (out[4], out[5], out[6], out[7]) = (l.store(e), l.store(f), l.store(g), l.store(h));
        }
        out.truncate(vertices);
    }
}

#[inline(always)]
fn divided(normal: Vec3, uv: Vec2, inverse_depth: f32) -> Varying {
    let [x, y, z] = normal.to_array().map(|n| n * inverse_depth);
    [x, y, z, uv.x * inverse_depth, uv.y * inverse_depth, inverse_depth, 0.0, 0.0]
}

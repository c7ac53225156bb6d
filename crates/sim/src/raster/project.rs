//! Projection of vertices to fixed-point image positions.

use bytemuck::{Pod, Zeroable};
use evpose_cpu::{Kernel8, LANES_8, Lanes8, dispatch};
use glam::{Vec3, Vec4};

use super::rows::eight_rows;
use super::{Camera, PixelRect};

/// Fixed-point units per pixel.
pub(super) const SUBPIXEL: i32 = 1 << SUBPIXEL_BITS;

/// Fractional bits of a fixed-point coordinate, as in GPU rasterisers (Direct3D 11 requires 8).
pub(super) const SUBPIXEL_BITS: u32 = 8;

/// Clamp of positions, a million pixels: products of differences fit in 64 bits.
const MAX_POSITION: i32 = SUBPIXEL << 20;

/// A vertex on the image: column and row in 1/256 pixel, rows downwards, and the bits of 1/depth in
/// 1/m, zero where the near plane hides it. One vector of four, as eight corners are read at a
/// time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct ScreenVertex([i32; 4]);

impl ScreenVertex {
    #[inline(always)]
    pub(super) fn new(x: i32, y: i32, inverse_depth: f32) -> Self {
        Self([x, y, inverse_depth.to_bits() as i32, 0])
    }

    /// From homogeneous image coordinates `(x·d, y·d, _, d)` with `d > 0`.
    pub(super) fn from_homogeneous(position: Vec4) -> Self {
        let inverse_depth = 1.0 / position.w;
        // To the nearest, halves upwards.
        let snap = |numerator: f32| {
            let subpixels = (numerator * inverse_depth * SUBPIXEL as f32 + 0.5).floor();
            (subpixels as i32).clamp(-MAX_POSITION, MAX_POSITION)
        };
        Self::new(snap(position.x), snap(position.y), inverse_depth)
    }

    #[inline(always)]
    pub(super) fn x(self) -> i32 {
        self.0[0]
    }

    #[inline(always)]
    pub(super) fn y(self) -> i32 {
        self.0[1]
    }

    #[inline(always)]
    pub(super) fn inverse_depth(self) -> f32 {
        f32::from_bits(self.0[2] as u32)
    }

    /// Column, row, bits of 1/depth, zero.
    #[inline(always)]
    pub(super) fn row(&self) -> &[i32; 4] {
        &self.0
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    /// Pixels whose centres the mesh can cover.
    pub rect: PixelRect,
    /// Whether no vertex is hidden by the near plane.
    pub wholly_in_front: bool,
}

/// Projects `vertices_m` into `out`.
pub(super) fn project(camera: &Camera, vertices_m: &[Vec3], out: &mut Vec<ScreenVertex>) -> Extent {
    let matrix = camera.homogeneous_image_from_world().to_cols_array_2d();
    let near_m = camera.near_m();
    let limits = dispatch(Project { matrix, near_m, vertices_m, out });
    let whole = PixelRect::whole(camera.sensor());
    let Limits { left, top, right, bottom, wholly_in_front } = limits;
    let rect = if wholly_in_front {
        PixelRect::of_centres(left, top, right, bottom, whole)
    } else {
        whole
    };
    // Beside the image the limits cross: there is nothing to clear or to restore.
    let rect = if rect.is_empty() { PixelRect::EMPTY } else { rect };
    Extent { rect, wholly_in_front }
}

/// Eight vertices at a time.
struct Project<'a> {
    /// Column by column.
    matrix: [[f32; 4]; 4],
    near_m: f32,
    vertices_m: &'a [Vec3],
    out: &'a mut Vec<ScreenVertex>,
}

impl Kernel8 for Project<'_> {
    type Output = Limits;

    #[inline(always)]
    fn run<L: Lanes8>(self, l: L) -> Limits {
        let Self { matrix, near_m, vertices_m, out } = self;
        let (vertices, coordinates) = (vertices_m.len(), bytemuck::must_cast_slice(vertices_m));
        // Rounded up to whole batches; the rest is cut off below.
        out.resize(vertices.next_multiple_of(LANES_8), ScreenVertex::default());
        let (farthest, nearest) = (l.splat_i(MAX_POSITION), l.splat_i(-MAX_POSITION));
        let (mut left, mut top) = (farthest, farthest);
        let (mut right, mut bottom) = (nearest, nearest);
        let mut min_bits = l.splat_i(i32::MAX);
        // For the last batch alone, which may reach beyond the vertices.
        let mut padding = [0; 4 * LANES_8];
        for (batch, out) in out.as_chunks_mut::<LANES_8>().0.iter_mut().enumerate() {
            let rows = eight_rows::<3>(coordinates, batch * LANES_8, &mut padding);
            let [x_m, y_m, z_m, _] = l.gather_columns(rows);
            let world_m = [l.from_bits(x_m), l.from_bits(y_m), l.from_bits(z_m)];
            let [x, y, inverse_depth] = project_lanes(l, &matrix, near_m, world_m);
            (left, right) = (l.min_i(left, x), l.max_i(right, x));
            (top, bottom) = (l.min_i(top, y), l.max_i(bottom, y));
            // Non-negative floats compare as their bits do.
            min_bits = l.min_i(min_bits, inverse_depth);
            l.scatter_columns([x, y, inverse_depth, l.splat_i(0)], bytemuck::must_cast_mut(out));
        }
        out.truncate(vertices);
        let smallest = |of| l.store_i(of).into_iter().min().unwrap_or(MAX_POSITION);
        let largest = |of| l.store_i(of).into_iter().max().unwrap_or(-MAX_POSITION);
        Limits {
            left: smallest(left),
            top: smallest(top),
            right: largest(right),
            bottom: largest(bottom),
            wholly_in_front: smallest(min_bits) > 0,
        }
    }
}

/// Column, row and bits of 1/depth.
#[inline(always)]
fn project_lanes<L: Lanes8>(
    l: L,
    matrix: &[[f32; 4]; 4],
    near_m: f32,
    world_m: [L::F; 3],
) -> [L::I; 3] {
    let [from_x, from_y, from_z, from_one] = matrix;
    let (x, y, depth_m) = (
        row(l, world_m, [from_x[0], from_y[0], from_z[0], from_one[0]]),
        row(l, world_m, [from_x[1], from_y[1], from_z[1], from_one[1]]),
        row(l, world_m, [from_x[3], from_y[3], from_z[3], from_one[3]]),
    );
    // A NaN depth counts as hidden.
    let is_seen = l.lt(l.splat(near_m.next_down()), depth_m);
    let inverse_depth = l.div(l.splat(1.0), depth_m);
    let bits = l.and(l.to_bits(inverse_depth), is_seen);
    let inverse_depth = l.from_bits(bits);
    [snap(l, x, inverse_depth), snap(l, y, inverse_depth), bits]
}

/// One row of the matrix times eight points.
#[inline(always)]
fn row<L: Lanes8>(l: L, [x, y, z]: [L::F; 3], [a, b, c, d]: [f32; 4]) -> L::F {
    let xy = l.add(l.mul(l.splat(a), x), l.mul(l.splat(b), y));
    l.add(l.add(xy, l.mul(l.splat(c), z)), l.splat(d))
}

/// Homogeneous coordinates as snapped positions: to the nearest, halves upwards.
#[inline(always)]
fn snap<L: Lanes8>(l: L, numerator: L::F, inverse_depth: L::F) -> L::I {
    let subpixels = l.mul(l.mul(numerator, inverse_depth), l.splat(SUBPIXEL as f32));
    let nearest = l.floor(l.add(subpixels, l.splat(0.5)));
    let farthest = MAX_POSITION as f32;
    l.to_i(l.min(l.max(nearest, l.splat(-farthest)), l.splat(farthest)))
}

/// Bounding box of the vertices in fixed point.
struct Limits {
    left: i32,
    top: i32,
    right: i32,
    bottom: i32,
    wholly_in_front: bool,
}

#[cfg(test)]
mod tests {
    use evpose_core::{LookAt, Pinhole, SensorSize};

    use super::*;

    #[test]
    fn vertices_lie_where_the_camera_sees_them_however_near() {
        let sensor = SensorSize::DAVIS240C;
        let placement = LookAt { eye_m: Vec3::ZERO, centre_m: Vec3::NEG_Z, up: Vec3::Y };
        let pinhole = Pinhole::from_vertical_fov(sensor, 45.0);
        let camera = Camera::new(sensor, pinhole, &placement, 1e-4);
        let vertices_m: Vec<Vec3> =
            (0..37).map(|k| Vec3::new(0.01 * k as f32, -0.2, -1e-5 * 1.5f32.powi(k))).collect();
        let mut projected = Vec::new();
        let extent = project(&camera, &vertices_m, &mut projected);
        assert!(!extent.wholly_in_front);
        for (vertex_m, vertex) in vertices_m.iter().zip(&projected) {
            let position = camera.homogeneous_image_from_world() * vertex_m.extend(1.0);
            if position.w < 1e-4 {
                assert_eq!(vertex.inverse_depth(), 0.0);
            } else {
                assert_eq!(*vertex, ScreenVertex::from_homogeneous(position), "{vertex_m}");
            }
        }
    }
}

//! Vertices from the world to snapped image positions.

use evpose_core::{LANES, LaneWork, Lanes, in_lanes};
use glam::{Vec3, Vec4};

use super::{Camera, PixelRect};

/// Steps per pixel of the snapped coordinates.
pub(super) const SUBPIXEL: i32 = 1 << SUBPIXEL_BITS;

/// Bits of a snapped coordinate behind the point.
pub(super) const SUBPIXEL_BITS: u32 = 8;

/// A million pixels: beyond it positions are clamped, so that products of differences fit in 64
/// bits.
const FARTHEST: i32 = SUBPIXEL << 20;

/// A vertex on the image.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ScreenVertex {
    /// Column in 1/256 pixel.
    pub x: i32,
    /// Row in 1/256 pixel, downwards.
    pub y: i32,
    /// 1 / depth in 1/m; zero marks a vertex that the near plane hides.
    pub inverse_depth: f32,
}

impl ScreenVertex {
    /// From homogeneous image coordinates `(x·d, y·d, _, d)` with `d > 0`.
    pub(super) fn from_homogeneous(position: Vec4) -> Self {
        let inverse_depth = 1.0 / position.w;
        // To the nearest, halves upwards.
        let snap = |numerator: f32| {
            let subpixels = (numerator * inverse_depth * SUBPIXEL as f32 + 0.5).floor();
            (subpixels as i32).clamp(-FARTHEST, FARTHEST)
        };
        Self { x: snap(position.x), y: snap(position.y), inverse_depth }
    }
}

/// What the projection of all vertices says about the mesh as a whole.
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
    out.clear();
    let limits = in_lanes(Project { matrix, near_m, vertices_m, out });
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

impl LaneWork for Project<'_> {
    type Output = Limits;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Limits {
        let mut limits = Limits::NONE;
        for vertices_m in self.vertices_m.chunks(LANES) {
            let mut world_m = [[0.0; LANES]; 3];
            for (k, vertex_m) in vertices_m.iter().enumerate() {
                [world_m[0][k], world_m[1][k], world_m[2][k]] = vertex_m.to_array();
            }
            let vertices = project_lanes(l, &self.matrix, self.near_m, world_m);
            let vertices = &vertices[..vertices_m.len()];
            limits.include(vertices);
            self.out.extend_from_slice(vertices);
        }
        limits
    }
}

#[inline(always)]
fn project_lanes<L: Lanes>(
    l: L,
    matrix: &[[f32; 4]; 4],
    near_m: f32,
    [x_m, y_m, z_m]: [[f32; LANES]; 3],
) -> [ScreenVertex; LANES] {
    let (x_m, y_m, z_m) = (l.load(x_m), l.load(y_m), l.load(z_m));
    let [from_x, from_y, from_z, from_one] = matrix;
    let (x, y, depth_m) = (
        row(l, [x_m, y_m, z_m], [from_x[0], from_y[0], from_z[0], from_one[0]]),
        row(l, [x_m, y_m, z_m], [from_x[1], from_y[1], from_z[1], from_one[1]]),
        row(l, [x_m, y_m, z_m], [from_x[3], from_y[3], from_z[3], from_one[3]]),
    );
    // A depth that is not a number counts as hidden.
    let is_seen = l.less(l.splat(near_m.next_down()), depth_m);
    let inverse_depth = l.div(l.splat(1.0), depth_m);
    let inverse_depth = l.numbers(l.and(l.bits(inverse_depth), is_seen));
    let (x, y) = (snap(l, x, inverse_depth), snap(l, y, inverse_depth));
    let inverse_depth = l.store(inverse_depth);
    std::array::from_fn(|k| ScreenVertex { x: x[k], y: y[k], inverse_depth: inverse_depth[k] })
}

/// One row of the matrix times eight points.
#[inline(always)]
fn row<L: Lanes>(l: L, [x, y, z]: [L::F; 3], [a, b, c, d]: [f32; 4]) -> L::F {
    let xy = l.add(l.mul(l.splat(a), x), l.mul(l.splat(b), y));
    l.add(l.add(xy, l.mul(l.splat(c), z)), l.splat(d))
}

/// Homogeneous coordinates as snapped positions: to the nearest, halves upwards.
#[inline(always)]
fn snap<L: Lanes>(l: L, numerator: L::F, inverse_depth: L::F) -> [i32; LANES] {
    let subpixels = l.mul(l.mul(numerator, inverse_depth), l.splat(SUBPIXEL as f32));
    let nearest = l.floor(l.add(subpixels, l.splat(0.5)));
    let farthest = FARTHEST as f32;
    l.store_i(l.to_i(l.min(l.max(nearest, l.splat(-farthest)), l.splat(farthest))))
}

/// The snapped positions that vertices span.
struct Limits {
    left: i32,
    top: i32,
    right: i32,
    bottom: i32,
    wholly_in_front: bool,
}

impl Limits {
    const NONE: Self = Self {
        left: FARTHEST,
        top: FARTHEST,
        right: -FARTHEST,
        bottom: -FARTHEST,
        wholly_in_front: true,
    };

    #[inline(always)]
    fn include(&mut self, vertices: &[ScreenVertex]) {
        for vertex in vertices {
            self.left = self.left.min(vertex.x);
            self.right = self.right.max(vertex.x);
            self.top = self.top.min(vertex.y);
            self.bottom = self.bottom.max(vertex.y);
            self.wholly_in_front &= vertex.inverse_depth > 0.0;
        }
    }
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
                assert_eq!(vertex.inverse_depth, 0.0);
            } else {
                assert_eq!(*vertex, ScreenVertex::from_homogeneous(position), "{vertex_m}");
            }
        }
    }
}

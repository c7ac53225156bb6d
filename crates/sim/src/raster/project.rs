//! Vertices from the world to snapped image positions.

use glam::{Mat4, Vec3};

use super::{Camera, PixelRect};

/// Steps per pixel of the snapped coordinates.
pub(super) const SUBPIXEL: i32 = 256;

/// A million pixels: beyond it positions are clamped, so that products of differences fit in 64
/// bits.
const FARTHEST: i32 = SUBPIXEL << 20;

/// A vertex on the image.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ScreenVertex {
    /// Column in 1/256 pixel.
    pub x: i32,
    /// Row in 1/256 pixel, downwards.
    pub y: i32,
    /// 1 / depth in 1/m; zero marks a vertex that the near plane hides.
    pub inverse_depth: f32,
}

/// Nearest integer, halves upwards, without a call into the mathematics library.
#[inline]
fn nearest(value: f32) -> i32 {
    let shifted = value + 0.5;
    let truncated = shifted as i32;
    truncated - i32::from(truncated as f32 > shifted)
}

impl ScreenVertex {
    /// From homogeneous image coordinates `(x·d, y·d, _, d)` with `d > 0`.
    #[inline]
    pub(super) fn from_homogeneous(position: glam::Vec4) -> Self {
        let inverse_depth = 1.0 / position.w;
        let snap = |numerator: f32| {
            nearest(numerator * inverse_depth * SUBPIXEL as f32).clamp(-FARTHEST, FARTHEST)
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
    let homogeneous_image_from_world: Mat4 = camera.homogeneous_image_from_world();
    let near_m = camera.near_m();
    let (mut left, mut top, mut right, mut bottom) = (FARTHEST, FARTHEST, -FARTHEST, -FARTHEST);
    let mut wholly_in_front = true;
    out.clear();
    out.extend(vertices_m.iter().map(|&vertex_m| {
        let position = homogeneous_image_from_world * vertex_m.extend(1.0);
        // A depth that is not a number counts as hidden.
        if position.w >= near_m {
            let vertex = ScreenVertex::from_homogeneous(position);
            left = left.min(vertex.x);
            right = right.max(vertex.x);
            top = top.min(vertex.y);
            bottom = bottom.max(vertex.y);
            vertex
        } else {
            wholly_in_front = false;
            ScreenVertex::default()
        }
    }));
    let whole = PixelRect::whole(camera.sensor());
    let rect = if wholly_in_front {
        PixelRect::of_centres(left, top, right, bottom, whole)
    } else {
        whole
    };
    // Beside the image the limits cross: there is nothing to clear or to restore.
    let rect = if rect.is_empty() { PixelRect::EMPTY } else { rect };
    Extent { rect, wholly_in_front }
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn rounding_is_to_the_nearest_with_halves_upwards() {
        for (value, want) in [(0.4, 0), (0.5, 1), (-0.5, 0), (-0.6, -1), (-1.5, -1), (7.0, 7)] {
            assert_eq!(nearest(value), want, "{value}");
        }
    }
}

//! Faces that the near plane cuts.

use glam::{Vec3, Vec4};

use super::Camera;
use super::project::ScreenVertex;

/// A corner of a clipped face, on the image and in barycentric coordinates of the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corner {
    pub(super) on_screen: ScreenVertex,
    pub(super) in_face: Vec3,
}

/// Cuts a face at the near plane and hands the one or two triangles in front of it to `emit`.
///
/// # Model
/// Sutherland and Hodgman's clipping against one plane, in homogeneous image coordinates, where the
/// face is still flat.
pub(super) fn clip_to_near_plane(
    camera: &Camera,
    corners_m: [Vec3; 3],
    mut emit: impl FnMut([Corner; 3]),
) {
    let homogeneous_image_from_world = camera.homogeneous_image_from_world();
    let near_m = camera.near_m();
    let face: [(Vec4, Vec3); 3] = [(0, Vec3::X), (1, Vec3::Y), (2, Vec3::Z)]
        .map(|(i, b)| (homogeneous_image_from_world * corners_m[i].extend(1.0), b));
    // A triangle that one plane cuts has four corners at most.
    let mut polygon = [(Vec4::ZERO, Vec3::ZERO); 4];
    let mut count = 0;
    let mut push = |corner: (Vec4, Vec3)| {
        polygon[count] = corner;
        count += 1;
    };
    for i in 0..3 {
        let (from, to) = (face[i], face[(i + 1) % 3]);
        let (from_in, to_in) = (from.0.w >= near_m, to.0.w >= near_m);
        if from_in {
            push(from);
        }
        if from_in != to_in {
            // Always cut from the inner to the outer end, so that two faces cut a shared edge at
            // the very same point.
            let (inner, outer) = if from_in { (from, to) } else { (to, from) };
            let s = (inner.0.w - near_m) / (inner.0.w - outer.0.w);
            push((inner.0.lerp(outer.0, s), inner.1.lerp(outer.1, s)));
        }
    }
    let corner = |(position, in_face)| Corner {
        on_screen: ScreenVertex::from_homogeneous(position),
        in_face,
    };
    // A fan: the polygon is as convex as the face was.
    for part in 1..count.saturating_sub(1) {
        emit([polygon[0], polygon[part], polygon[part + 1]].map(corner));
    }
}

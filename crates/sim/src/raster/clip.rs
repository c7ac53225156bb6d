//! Faces that the near plane cuts.

use glam::{Vec3, Vec4};

use super::Camera;
use super::project::ScreenVertex;

/// A corner of a clipped face: homogeneous image position and barycentric coordinates in the face.
type Corner = (Vec4, Vec3);

/// Cuts a face at the near plane and hands the one or two triangles in front of it to `emit`,
/// together with the map from barycentric coordinates of the part to those of the face.
///
/// # Model
/// Sutherland and Hodgman's clipping against one plane, in homogeneous image coordinates, where the
/// face is still flat.
pub(super) fn clip_to_near_plane(
    camera: &Camera,
    corners_m: [Vec3; 3],
    mut emit: impl FnMut([ScreenVertex; 3], &dyn Fn([f32; 2]) -> [f32; 2]),
) {
    let homogeneous_image_from_world = camera.homogeneous_image_from_world();
    let near_m = camera.near_m();
    let face: [Corner; 3] = [(0, Vec3::X), (1, Vec3::Y), (2, Vec3::Z)]
        .map(|(i, b)| (homogeneous_image_from_world * corners_m[i].extend(1.0), b));
    let mut polygon: [Corner; 4] = [(Vec4::ZERO, Vec3::ZERO); 4];
    let mut count = 0;
    let mut push = |corner: Corner| {
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
    for part in 1..count.saturating_sub(1) {
        let corners = [polygon[0], polygon[part], polygon[part + 1]];
        let face_from_part = |[second, third]: [f32; 2]| {
            let b = corners[0].1 * (1.0 - second - third)
                + corners[1].1 * second
                + corners[2].1 * third;
            [b.y, b.z]
        };
        emit(
            corners.map(|(position, _)| ScreenVertex::from_homogeneous(position)),
            &face_from_part,
        );
    }
}

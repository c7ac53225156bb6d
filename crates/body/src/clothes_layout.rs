//! Texture layout of the procedural human.
//!
//! The layout has no seams: v runs around the body, from its front over either side to its back, so
//! that left and right share texels; u runs along it. In the first half of v (0 to 0.5, front to
//! back) u goes from the soles over legs, trunk and neck to the top of the head; in the second half
//! (0.5 to 1, palm and front to back) from the shoulders to the tips of the hands, beginning at
//! [`U_SHOULDER`]. Around the shoulders, where one half goes over into the other, all of v should
//! look alike.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

/// Upper end of the shoes.
pub const U_ANKLE: f32 = 0.05;
/// The middle of the knees.
pub const U_KNEE: f32 = 0.22;
/// Border between trousers and shirt.
pub const U_WAIST: f32 = 0.44;
/// The shoulders, from which arms go on.
pub const U_SHOULDER: f32 = 0.62;
/// Lower end of the neck, in the half of the trunk.
pub const U_NECK: f32 = 0.64;
/// The chin, in the half of the trunk.
pub const U_CHIN: f32 = 0.70;
/// The eyes, in the half of the trunk.
pub const U_EYES: f32 = 0.82;
/// The elbows, in the half of the arms.
pub const U_ELBOW: f32 = 0.76;
/// The wrists, in the half of the arms.
pub const U_WRIST: f32 = 0.90;
/// Upper end of the texels of other objects of the scene, in the half of the arms.
pub const U_OBJECTS: f32 = 0.50;

/// Heights of the rest pose and their u.
const ALONG_BODY: [(f32, f32); 8] = [
    (-1.20, 0.0),
    (-1.08, U_ANKLE),
    (-0.69, U_KNEE),
    (-0.20, U_WAIST),
    (0.24, U_SHOULDER),
    (0.29, U_NECK),
    (0.36, U_CHIN),
    (0.57, 1.0),
];
/// Distances from the middle of the rest pose and their u, along the arms.
const ALONG_ARMS: [(f32, f32); 4] =
    [(0.19, U_SHOULDER), (0.43, U_ELBOW), (0.68, U_WRIST), (0.88, 1.0)];

/// Texture coordinates of a point of the rest pose with a unit normal.
pub(crate) fn coordinates(point_m: Vec3, normal: Vec3) -> Vec2 {
    let around = normal.z.clamp(-1.0, 1.0).acos() / PI;
    let is_arm = point_m.x.abs() > ALONG_ARMS[0].0 && point_m.y > 0.1;
    let (u, first) = if is_arm {
        (between(&ALONG_ARMS, point_m.x.abs()), 0.5)
    } else {
        (between(&ALONG_BODY, point_m.y), 0.0)
    };
    // Not up to the end, where the texture begins again.
    Vec2::new(u.clamp(0.004, 0.996), first + 0.01 + 0.48 * around)
}

/// Linear between the rows of a table.
fn between(table: &[(f32, f32)], x: f32) -> f32 {
    let next = table.partition_point(|row| row.0 <= x).clamp(1, table.len() - 1);
    let [(x0, u0), (x1, u1)] = [table[next - 1], table[next]];
    u0 + (u1 - u0) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0)
}

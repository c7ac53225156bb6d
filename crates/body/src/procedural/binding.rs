//! Skin weights of each point of the surface, and its position along the limb.
//!
//! # Model
//! A vertex is shared out in two steps. Along a chain of bones, each joint hands over from the bone
//! before to the bone after across the plane that halves the angle between them, smoothly over a
//! stretch about as long as the limb is thick there. Among the digits, shares follow the distance
//! to each: beyond the webs only one is near, so that no finger pulls at another. The shares are
//! then evened out over the mesh, and the four largest kept.

use glam::Vec3;

use crate::SkinWeights;
use crate::skeleton::{JOINTS, RIGHT_COLLAR, RIGHT_ELBOW, RIGHT_HAND, RIGHT_SHOULDER, RIGHT_WRIST};
use crate::texture_layout as layout;

use super::anatomy::Anatomy;
use super::digits::{DIGITS, Digit, THUMB};
use super::frame::{COLLAR_M, ELBOW_M, SHOULDER_M, WRIST_M};
use crate::implicit::cone::smooth_step;

/// Blend zones of the trunk at shoulder, elbow and wrist: metres before and after the joint. The
/// forearm turns with the elbow and the wrist, so both stretches are long.
const TRUNK_HANDOVER_M: [[f32; 2]; 3] = [[0.040, 0.040], [0.060, 0.050], [0.032, 0.012]];
/// The same for the first joints of the fingers and of the thumb.
const KNUCKLE_HANDOVER_M: [f32; 2] = [0.010, 0.012];
const THUMB_HANDOVER_M: [f32; 2] = [0.012, 0.022];
/// Beyond this distance from the thumb, the palm does not follow it.
const THUMB_REACH_M: f32 = 0.019;
/// Difference of the distances to two digits above which the nearer one has the whole weight.
const DIGIT_HANDOVER_M: f32 = 0.004;
/// Joints on the second and third knuckles hand over within this many radii.
const KNUCKLE_RADII: f32 = 0.65;
/// How often shares are averaged with those of the neighbours.
const SMOOTHING_ROUNDS: usize = 2;

/// Skin weights of a vertex.
pub(super) struct Binding {
    /// Share of every joint, with sum one.
    pub(super) shares: [f32; JOINTS],
    /// The texture's u.
    pub(super) along: f32,
}

/// The binding of every vertex.
pub(super) fn bind(
    vertices_m: &[Vec3],
    faces: &[[u32; 3]],
    anatomy: &Anatomy,
    digits: &[Digit; DIGITS],
) -> Vec<Binding> {
    let mut bindings: Vec<Binding> =
        vertices_m.iter().map(|&vertex_m| bind_point(vertex_m, anatomy, digits)).collect();
    for _ in 0..SMOOTHING_ROUNDS {
        bindings = smoothed(&bindings, faces);
    }
    bindings
}

/// The four strongest shares.
pub(super) fn skin_weights(binding: &Binding) -> SkinWeights {
    SkinWeights::strongest(binding.shares.iter().copied().enumerate())
}

fn bind_point(point_m: Vec3, anatomy: &Anatomy, digits: &[Digit; DIGITS]) -> Binding {
    let digit_shares = digit_shares(point_m, anatomy);
    let trunk = [COLLAR_M, SHOULDER_M, ELBOW_M, WRIST_M];
    let trunk_joints = [RIGHT_COLLAR, RIGHT_SHOULDER, RIGHT_ELBOW, RIGHT_WRIST];

    let mut shares = [0.0; JOINTS];
    // What has passed each joint so far; the bone before keeps the rest.
    let mut passed = 1.0;
    for k in 1..trunk.len() {
        let before = (trunk[k] - trunk[k - 1]).normalize();
        let after =
            if k + 1 < trunk.len() { (trunk[k + 1] - trunk[k]).normalize() } else { Vec3::NEG_X };
        let beyond = handover(point_m, trunk[k], before + after, TRUNK_HANDOVER_M[k - 1]);
        shares[trunk_joints[k - 1]] = passed * (1.0 - beyond);
        passed *= beyond;
    }

    let mut along = layout::U_SHOULDER
        + (layout::U_ELBOW - layout::U_SHOULDER) * fraction(point_m, SHOULDER_M, ELBOW_M)
        + (layout::U_WRIST - layout::U_ELBOW) * fraction(point_m, ELBOW_M, WRIST_M);
    // The palm holds what no finger takes.
    let mut in_palm = passed;
    for (k, digit) in digits.iter().enumerate() {
        along += digit_shares[k] * digit_length_u(point_m, k, digit);
        let mut held = passed * digit_shares[k];
        for joint in 0..3 {
            let (axis, stretch_m) = match joint {
                0 if k == THUMB => (digit.axes[0], THUMB_HANDOVER_M),
                0 => (digit.axes[0], KNUCKLE_HANDOVER_M),
                _ => {
                    let half_m = KNUCKLE_RADII * digit.radii_m[joint];
                    (digit.axes[joint - 1] + digit.axes[joint], [half_m; 2])
                }
            };
            let beyond = held * handover(point_m, digit.points_m[joint], axis, stretch_m);
            if joint == 0 {
                in_palm -= beyond;
            } else {
                shares[RIGHT_HAND + 3 * k + joint - 1] = held - beyond;
            }
            held = beyond;
        }
        shares[RIGHT_HAND + 3 * k + 2] = held;
    }
    shares[RIGHT_WRIST] = in_palm.max(0.0);
    Binding { shares, along }
}

/// How much of a point each digit may have; the shares have sum one.
fn digit_shares(point_m: Vec3, anatomy: &Anatomy) -> [f32; DIGITS] {
    let distances_m: [f32; DIGITS] = std::array::from_fn(|k| anatomy.digit_distance(k, point_m));
    let nearest_m = distances_m[..THUMB].iter().copied().fold(f32::INFINITY, f32::min);
    // In the palm, far from all fingers, the transition is wide.
    let band_m = DIGIT_HANDOVER_M + 0.6 * nearest_m.max(0.0);
    let mut fingers = [0.0; THUMB];
    for (share, distance_m) in fingers.iter_mut().zip(distances_m) {
        let closeness = (1.0 - (distance_m - nearest_m) / band_m).max(0.0);
        *share = closeness * closeness;
    }
    let total: f32 = fingers.iter().sum();
    let thumb = 1.0 - smooth_step(0.0, THUMB_REACH_M, distances_m[THUMB]);
    std::array::from_fn(|k| if k == THUMB { thumb } else { (1.0 - thumb) * fingers[k] / total })
}

/// How far `point_m` has passed the joint at `joint_m` along `axis`: 0 before, 1 beyond.
fn handover(point_m: Vec3, joint_m: Vec3, axis: Vec3, [before_m, after_m]: [f32; 2]) -> f32 {
    smooth_step(-before_m, after_m, (point_m - joint_m).dot(axis.normalize()))
}

/// How far a point lies from `start_m` to `end_m`, in [0, 1].
fn fraction(point_m: Vec3, start_m: Vec3, end_m: Vec3) -> f32 {
    let axis = end_m - start_m;
    ((point_m - start_m).dot(axis) / axis.length_squared()).clamp(0.0, 1.0)
}

/// How much of the texture's length lies between the wrist and a point, along one digit.
fn digit_length_u(point_m: Vec3, number: usize, digit: &Digit) -> f32 {
    let [first, second, third, tip] = digit.points_m;
    let palm = layout::U_KNUCKLE - layout::U_WRIST;
    // The thumb's first bone lies in the palm.
    let (to_first, to_second) = if number == THUMB {
        (0.3 * palm, 0.7 * palm)
    } else {
        (palm, layout::U_MIDDLE_JOINT - layout::U_KNUCKLE)
    };
    let to_third = layout::U_END_JOINT - layout::U_WRIST - to_first - to_second;
    to_first * fraction(point_m, WRIST_M, first)
        + to_second * fraction(point_m, first, second)
        + to_third * fraction(point_m, second, third)
        + (layout::U_TIP - layout::U_END_JOINT) * fraction(point_m, third, tip)
}

/// Every vertex half-way to the mean over its faces' corners.
fn smoothed(bindings: &[Binding], faces: &[[u32; 3]]) -> Vec<Binding> {
    let mut sums: Vec<([f32; JOINTS], f32)> = vec![([0.0; JOINTS], 0.0); bindings.len()];
    for face in faces {
        // Each corner adds the next one: over all faces, that is every neighbour once.
        for (&to, &from) in face.iter().zip(face.iter().cycle().skip(1)) {
            let (sum, count) = &mut sums[to as usize];
            for (total, share) in sum.iter_mut().zip(&bindings[from as usize].shares) {
                *total += share;
            }
            *count += 1.0;
        }
    }
    bindings
        .iter()
        .zip(&sums)
        .map(|(binding, (sum, count))| Binding {
            shares: std::array::from_fn(|j| 0.5 * (binding.shares[j] + sum[j] / count)),
            along: binding.along,
        })
        .collect()
}

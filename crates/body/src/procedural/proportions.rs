//! Ten ways in which arms and hands differ.
//!
//! # Model
//! Every bone carries the flesh around it. A shape direction stretches each bone's surroundings
//! along the bone, through the thickness and across the width; joints move as their chain grows,
//! and a vertex moves with the bones that hold it, by the same shares that skin it. All of it is
//! linear in the coefficient, in metres per unit, a few millimetres at a hand's end.

use glam::Vec3;

use crate::skeleton::{
    JOINTS, RIGHT_COLLAR, RIGHT_ELBOW, RIGHT_HAND, RIGHT_SHOULDER, RIGHT_WRIST, parents,
};

use super::binding::Binding;
use super::digits::{DIGITS, Digit, THUMB};

/// Number of shape directions.
pub(super) const SHAPES: usize = 10;

/// A bone with the flesh around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Bone {
    UpperArm,
    Forearm,
    Palm,
    /// Segment `.1` of digit `.0`.
    Segment(usize, usize),
}

/// Relative growth per unit along the bone, through the thickness, across the width.
type Growth = [f32; 3];

/// Index, middle, pinky, ring, thumb: how much longer in a hand whose ring finger is long.
const LONG_RING_FINGER: [f32; DIGITS] = [-0.035, 0.005, 0.025, 0.035, 0.0];

/// Growth of one bone per unit of coefficient number `shape`.
fn growth(shape: usize, bone: Bone) -> Growth {
    use Bone::{Forearm, Palm, Segment, UpperArm};
    match (shape, bone) {
        // 0: overall size.
        (0, UpperArm | Forearm) => [0.012, 0.02, 0.02],
        (0, _) => [0.025, 0.025, 0.025],
        // 1: a long hand.
        (1, Palm | Segment(..)) => [0.03, -0.005, -0.005],
        // 2: a broad hand.
        (2, Palm) => [0.0, 0.005, 0.035],
        (2, Segment(..)) => [0.0, 0.01, 0.025],
        (2, Forearm) => [0.0, 0.0, 0.015],
        // 3: long fingers on a short palm.
        (3, Palm) => [-0.02, 0.0, 0.0],
        (3, Segment(digit, _)) if digit != THUMB => [0.035, -0.005, -0.005],
        // 4: thick fingers.
        (4, Segment(..)) => [0.0, 0.045, 0.045],
        // 5: a thick palm.
        (5, Palm) => [0.0, 0.05, 0.005],
        (5, Segment(THUMB, 0)) => [0.0, 0.05, 0.03],
        // 6: a strong forearm.
        (6, Forearm | UpperArm) => [0.0, 0.05, 0.05],
        // 7: a long thumb.
        (7, Segment(THUMB, segment)) => [[0.03, 0.045, 0.05][segment], 0.02, 0.02],
        // 8: tapering fingers.
        (8, Segment(_, segment)) => {
            let thinner = [-0.02, 0.02, 0.05][segment];
            [0.0, -thinner, -thinner]
        }
        // 9: ring finger longer than index.
        (9, Segment(digit, _)) => [LONG_RING_FINGER[digit], 0.0, 0.0],
        _ => [0.0; 3],
    }
}

/// The joint a bone hangs on, with its directions: along, through, across.
fn bone_of_joint(
    joint: usize,
    joints_m: &[Vec3; JOINTS],
    digits: &[Digit; DIGITS],
) -> Option<(Bone, [Vec3; 3])> {
    let frame = |along: Vec3, dorsal: Vec3| {
        let across = along.cross(dorsal).normalize();
        [along, across.cross(along), across]
    };
    let towards = |next: usize| (joints_m[next] - joints_m[joint]).normalize();
    match joint {
        RIGHT_SHOULDER => Some((Bone::UpperArm, frame(towards(RIGHT_ELBOW), Vec3::Y))),
        RIGHT_ELBOW => Some((Bone::Forearm, frame(towards(RIGHT_WRIST), Vec3::Y))),
        RIGHT_WRIST => Some((Bone::Palm, frame(Vec3::NEG_X, Vec3::Y))),
        RIGHT_HAND.. => {
            let (digit, segment) = ((joint - RIGHT_HAND) / 3, (joint - RIGHT_HAND) % 3);
            let axes = frame(digits[digit].axes[segment], digits[digit].dorsal[segment]);
            Some((Bone::Segment(digit, segment), axes))
        }
        _ => None,
    }
}

/// Displacement of every vertex per unit of every shape coefficient, in metres.
pub(super) fn shape_directions(
    vertices_m: &[Vec3],
    bindings: &[Binding],
    joints_m: &[Vec3; JOINTS],
    digits: &[Digit; DIGITS],
) -> Vec<Vec<Vec3>> {
    let bones: Vec<_> = (0..JOINTS).map(|joint| bone_of_joint(joint, joints_m, digits)).collect();
    let parents = parents();
    (0..SHAPES)
        .map(|shape| {
            // Displacement of what the bone at `joint` holds.
            let grown = |joint: usize, from_joint_m: Vec3| {
                bones[joint].map_or(Vec3::ZERO, |(bone, axes)| {
                    let growth = growth(shape, bone);
                    axes.iter()
                        .zip(growth)
                        .map(|(&axis, g)| axis * (g * from_joint_m.dot(axis)))
                        .sum()
                })
            };
            let mut moved_m = [Vec3::ZERO; JOINTS];
            // From the trunk outwards: a parent has moved before its children.
            for joint in RIGHT_COLLAR + 1..JOINTS {
                if let Some(parent) = parents[joint] {
                    moved_m[joint] =
                        moved_m[parent] + grown(parent, joints_m[joint] - joints_m[parent]);
                }
            }
            vertices_m
                .iter()
                .zip(bindings)
                .map(|(&vertex_m, binding)| {
                    // Most shares are zero.
                    let held = binding.shares.iter().enumerate().filter(|(_, share)| **share > 0.0);
                    held.map(|(joint, &share)| {
                        (moved_m[joint] + grown(joint, vertex_m - joints_m[joint])) * share
                    })
                    .sum()
                })
                .collect()
        })
        .collect()
}

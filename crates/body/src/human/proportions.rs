//! Twelve ways in which people and their clothes differ.
//!
//! # Model
//! Every bone carries the flesh around it. A shape direction stretches each bone's surroundings
//! along the bone, from front to back and from side to side; joints move as their chain grows, and
//! a vertex moves with the bones that hold it, by the same shares that skin it. All of it is linear
//! in the coefficient, in metres per unit.

use glam::Vec3;

use crate::skeleton::{BODY_JOINTS, JOINTS, parents};

/// Number of shape directions.
pub(super) const SHAPES: usize = 12;

/// Relative growth per unit: sideways, upwards, forwards, in the T-pose.
type Growth = [f32; 3];

/// Parts that grow alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Hips,
    Waist,
    Chest,
    Neck,
    Head,
    Thigh,
    Shank,
    Foot,
    Collar,
    UpperArm,
    Forearm,
    Hand,
}

fn part(joint: usize) -> Option<Part> {
    Some(match joint {
        0 => Part::Hips,
        3 | 6 => Part::Waist,
        9 => Part::Chest,
        12 => Part::Neck,
        15 => Part::Head,
        1 | 2 => Part::Thigh,
        4 | 5 => Part::Shank,
        7 | 8 | 10 | 11 => Part::Foot,
        13 | 14 => Part::Collar,
        16 | 17 => Part::UpperArm,
        18 | 19 => Part::Forearm,
        20 | 21 => Part::Hand,
        _ => return None,
    })
}

/// Growth of a part per unit of coefficient number `shape`. Arms lie along x, all else along y.
fn growth(shape: usize, part: Part) -> Growth {
    use Part::{
        Chest, Collar, Foot, Forearm, Hand, Head, Hips, Neck, Shank, Thigh, UpperArm, Waist,
    };
    match (shape, part) {
        // 0: stature.
        (0, Head | Neck) => [0.008; 3],
        (0, UpperArm | Forearm | Hand) => [0.04, 0.015, 0.015],
        (0, Thigh | Shank) => [0.015, 0.045, 0.015],
        (0, _) => [0.02, 0.035, 0.02],
        // 1: weight.
        (1, Hips | Waist | Chest) => [0.07, 0.0, 0.10],
        (1, Thigh) => [0.09, 0.0, 0.09],
        (1, Shank) => [0.05, 0.0, 0.05],
        (1, UpperArm) => [0.0, 0.09, 0.09],
        (1, Forearm) => [0.0, 0.05, 0.05],
        (1, Neck) => [0.06, 0.0, 0.06],
        // 2: long legs under a short trunk.
        (2, Thigh | Shank) => [0.0, 0.03, 0.0],
        (2, Waist | Chest) => [0.0, -0.03, 0.0],
        // 3: broad shoulders.
        (3, Chest) => [0.05, 0.0, 0.01],
        (3, Collar) => [0.09, 0.0, 0.0],
        // 4: broad hips.
        (4, Hips) => [0.06, 0.0, 0.03],
        (4, Thigh) => [0.04, 0.0, 0.03],
        // 5: a belly.
        (5, Waist) => [0.04, 0.0, 0.14],
        (5, Hips) => [0.02, 0.0, 0.05],
        // 6: long arms.
        (6, UpperArm | Forearm) => [0.03, 0.0, 0.0],
        // 7: strong arms and chest.
        (7, UpperArm | Forearm) => [0.0, 0.08, 0.08],
        (7, Chest) => [0.03, 0.0, 0.05],
        // 8: head and hair.
        (8, Head) => [0.04, 0.05, 0.04],
        // 9: large hands and feet.
        (9, Foot) => [0.03, 0.0, 0.05],
        (9, Hand) => [0.05, 0.05, 0.05],
        // 10: wide trousers.
        (10, Shank) => [0.13, 0.0, 0.13],
        (10, Thigh) => [0.05, 0.0, 0.05],
        // 11: a wide top.
        (11, Waist) => [0.06, 0.0, 0.06],
        (11, UpperArm) => [0.0, 0.09, 0.09],
        _ => [0.0; 3],
    }
}

/// Displacements per unit of every shape coefficient, of vertices and of joints, in metres.
pub(super) struct Directions {
    pub(super) vertices_m: Vec<Vec<Vec3>>,
    pub(super) joints_m: Vec<Vec<Vec3>>,
}

/// The shape directions of a surface that is held by joints in the given shares.
pub(super) fn directions(
    vertices_m: &[Vec3],
    shares: &[[f32; JOINTS]],
    joints_m: &[Vec3; JOINTS],
) -> Directions {
    let parents = parents();
    let grown = |shape: usize, joint: usize, from_joint_m: Vec3| {
        part(joint).map_or(Vec3::ZERO, |part| from_joint_m * Vec3::from(growth(shape, part)))
    };
    let moved = |shape: usize| {
        let mut moved_m = vec![Vec3::ZERO; JOINTS];
        for joint in 1..JOINTS {
            if let Some(parent) = parents[joint] {
                moved_m[joint] =
                    moved_m[parent] + grown(shape, parent, joints_m[joint] - joints_m[parent]);
            }
        }
        moved_m
    };
    let joints: Vec<Vec<Vec3>> = (0..SHAPES).map(moved).collect();
    let vertex = |shape: usize, vertex_m: Vec3, shares: &[f32; JOINTS]| {
        let held = shares[..BODY_JOINTS].iter().enumerate().filter(|(_, share)| **share > 0.0);
        held.map(|(joint, &share)| {
            (joints[shape][joint] + grown(shape, joint, vertex_m - joints_m[joint])) * share
        })
        .sum()
    };
    let vertices = (0..SHAPES)
        .map(|shape| {
            vertices_m
                .iter()
                .zip(shares)
                .map(|(&at_m, shares)| vertex(shape, at_m, shares))
                .collect()
        })
        .collect();
    Directions { vertices_m: vertices, joints_m: joints }
}

//! The articulation basis of the procedural hand: six grasp synergies and what is left.
//!
//! # Model
//! 45 orthogonal rows over the axis-angles of the hand's joints. The first six are synergies, made
//! orthogonal in their order and scaled to the lengths in [`SYNERGIES`] (radians per unit), so that
//! coefficients in [-2, 2] give hands a person can make. The others complete the basis, each as
//! short as the shortest synergy: they are never drawn, but a hand's angles can always be written
//! in it. Rows divided by their lengths are orthonormal.
//!
//! # Source
//! The first synergies, closing the whole hand and closing it at the knuckles against the other
//! joints, are those of Santello, Flanders, Soechting: *Postural hand synergies for tool use*
//! (J. Neurosci. 18(23), 1998); the rest make the thumb, the spread and single fingers visible.

use glam::Vec3;

use crate::HandBasis;
use crate::skeleton::{LEFT_HAND, RIGHT_HAND};

use super::digits::{DIGITS, Digit, THUMB};

const ANGLES: usize = 45;

/// Flexion and spread of five digits: index, middle, pinky, ring, thumb.
struct Synergy {
    /// Length of the row: radians of all 45 angles together per unit.
    length_rad: f32,
    /// Flexion of the three joints of each digit; the thumb's first closes it against the palm.
    flexion: [[f32; 3]; DIGITS],
    /// Towards the thumb's side at the first joint.
    spread: [f32; DIGITS],
}

const SYNERGIES: [Synergy; 6] = [
    // The whole hand closes.
    Synergy {
        length_rad: 1.1,
        flexion: [
            [0.75, 1.0, 0.6],
            [0.8, 1.0, 0.6],
            [0.8, 0.9, 0.6],
            [0.8, 1.0, 0.6],
            [0.15, 0.25, 0.35],
        ],
        spread: [0.0; DIGITS],
    },
    // Knuckles open while the other joints close: flat hand to hook.
    Synergy {
        length_rad: 0.65,
        flexion: [
            [-1.0, 0.6, 0.35],
            [-1.0, 0.6, 0.35],
            [-1.0, 0.6, 0.35],
            [-1.0, 0.6, 0.35],
            [0.0, 0.1, 0.1],
        ],
        spread: [0.0; DIGITS],
    },
    // The thumb comes in front of the palm.
    Synergy {
        length_rad: 0.36,
        flexion: [[0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [1.0, 0.45, 0.3]],
        spread: [0.0, 0.0, 0.0, 0.0, -0.2],
    },
    // Fingers spread, the thumb with them.
    Synergy {
        length_rad: 0.2,
        flexion: [[0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [-0.4, 0.0, 0.0]],
        spread: [0.7, 0.15, -0.9, -0.4, 0.7],
    },
    // Index and middle close while ring and pinky open.
    Synergy {
        length_rad: 0.6,
        flexion: [
            [0.7, 0.8, 0.4],
            [0.35, 0.4, 0.2],
            [-0.7, -0.8, -0.4],
            [-0.45, -0.5, -0.25],
            [0.0; 3],
        ],
        spread: [0.0; DIGITS],
    },
    // Thumb and index meet at their tips.
    Synergy {
        length_rad: 0.5,
        flexion: [
            [0.9, 0.3, -0.2],
            [0.3, 0.0, 0.0],
            [-0.4, 0.0, 0.0],
            [-0.2, 0.0, 0.0],
            [0.3, 0.7, 0.5],
        ],
        spread: [0.0; DIGITS],
    },
];

/// A hand at rest: fingers half open, the more the farther from the index.
const REST_FLEXION_RAD: [[f32; 3]; DIGITS] = [
    [0.28, 0.48, 0.26],
    [0.34, 0.54, 0.30],
    [0.38, 0.50, 0.32],
    [0.38, 0.56, 0.32],
    [0.26, 0.16, 0.22],
];
/// A hand at rest holds its fingers closer than the T-pose does.
const REST_SPREAD_RAD: [f32; DIGITS] = [-0.05, 0.0, 0.09, 0.04, -0.10];

/// The basis and mean pose of the right hand.
pub(super) fn right_hand(digits: &[Digit; DIGITS]) -> HandBasis {
    let mut components = Box::new([[0.0; ANGLES]; ANGLES]);
    let mut count = 0;
    let synergies = SYNERGIES.iter().map(|s| (angles(digits, &s.flexion, &s.spread), s.length_rad));
    // What is left of the basis has the length of the weakest synergy.
    let shortest = SYNERGIES.iter().map(|s| s.length_rad).fold(f32::INFINITY, f32::min);
    // Synergies are few: unit vectors fill the basis up.
    let completion = (0..ANGLES).map(|k| {
        let mut unit = [0.0; ANGLES];
        unit[k] = 1.0;
        (unit, shortest)
    });
    for (candidate, length_rad) in synergies.chain(completion) {
        if count < ANGLES
            && let Some(row) = orthogonal_part(&candidate, &components[..count], length_rad)
        {
            components[count] = row;
            count += 1;
        }
    }
    let mean = angles(digits, &REST_FLEXION_RAD, &REST_SPREAD_RAD);
    HandBasis { first_joint: RIGHT_HAND, mean, components }
}

/// The mirror image of a right hand: rotations about x stay, those about y and z turn round.
pub(super) fn mirrored(right: &HandBasis) -> HandBasis {
    let mirror =
        |row: &[f32; ANGLES]| std::array::from_fn(|k| if k % 3 == 0 { row[k] } else { -row[k] });
    let mut components = right.components.clone();
    for row in components.iter_mut() {
        *row = mirror(row);
    }
    HandBasis { first_joint: LEFT_HAND, mean: mirror(&right.mean), components }
}

/// The 45 angles of a hand with these flexions and spreads.
fn angles(
    digits: &[Digit; DIGITS],
    flexion: &[[f32; 3]; DIGITS],
    spread: &[f32; DIGITS],
) -> [f32; ANGLES] {
    let mut angles = [0.0; ANGLES];
    for (k, digit) in digits.iter().enumerate() {
        for joint in 0..3 {
            let mut rotation = flexion_axis(k, joint, digit) * flexion[k][joint];
            // Fingers spread at the knuckles alone.
            if joint == 0 {
                rotation += digit.dorsal[0] * spread[k];
            }
            angles[9 * k + 3 * joint..][..3].copy_from_slice(&rotation.to_array());
        }
    }
    angles
}

/// The axis a joint closes about. The thumb's first joint is a saddle: it closes downwards in front
/// of the palm, not across its own nail.
fn flexion_axis(number: usize, joint: usize, digit: &Digit) -> Vec3 {
    if number == THUMB && joint == 0 {
        let opposed = Vec3::new(0.0, -0.75, -0.66);
        digit.axes[0].cross(opposed).normalize()
    } else {
        digit.flexion_axis(joint)
    }
}

/// The part of `candidate` orthogonal to `rows`, scaled to `length_rad`; `None` if it is almost
/// zero (Gram-Schmidt).
fn orthogonal_part(
    candidate: &[f32; ANGLES],
    rows: &[[f32; ANGLES]],
    length_rad: f32,
) -> Option<[f32; ANGLES]> {
    let dot =
        |a: &[f64; ANGLES], b: &[f64; ANGLES]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut part = candidate.map(f64::from);
    // Twice: once leaves rounding behind.
    for row in rows.iter().chain(rows) {
        let row = row.map(f64::from);
        let share = dot(&part, &row) / dot(&row, &row);
        for (value, along) in part.iter_mut().zip(row) {
            *value -= share * along;
        }
    }
    let length = dot(&part, &part).sqrt();
    (length > 1e-3).then(|| part.map(|value| (value / length * f64::from(length_rad)) as f32))
}

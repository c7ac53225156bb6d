//! The right arm at rest as smoothly united round cones: what the surface is drawn around.
//!
//! Everything belongs to one of six parts: the trunk (upper arm, forearm, palm) and five digits.
//! Digits blend into the trunk over several millimetres but hardly into each other, so that fingers
//! stay separate. Offsets are millimetres in the frame of the hand: distal, dorsal, radial.

use glam::Vec3;

use super::digits::{DIGITS, Digit, THUMB};
use super::frame::{ELBOW_M, SHOULDER_M, WRIST_M, hand_point};
use crate::implicit::cone::{Blend, Cone, Strand, smooth_min, strand};

/// Over how much fingers blend into each other: they stay apart from half of it on.
const BETWEEN_FINGERS_M: f32 = 0.004;
/// Over how much a finger blends into the palm.
const FINGER_INTO_PALM_M: f32 = 0.007;
/// Over how much the thumb blends into the palm.
const THUMB_INTO_PALM_M: f32 = 0.014;
/// Over how much the forearm blends into the palm.
const FOREARM_INTO_PALM_M: f32 = 0.015;

/// The parts of the arm as distance fields.
pub(super) struct Anatomy {
    arm: Blend,
    palm: Blend,
    digits: [Blend; DIGITS],
}

impl Anatomy {
    /// The arm around the bones of `digits`.
    pub(super) fn new(digits: &[Digit; DIGITS]) -> Self {
        Self {
            arm: Blend { strands: arm(), blend_m: 0.020 },
            palm: Blend { strands: palm(), blend_m: 0.009 },
            digits: std::array::from_fn(|k| Blend {
                strands: if k == THUMB { thumb(&digits[k]) } else { finger(&digits[k]) },
                blend_m: 0.004,
            }),
        }
    }

    /// Signed distance to the surface in metres, negative inside.
    pub(super) fn distance(&self, point_m: Vec3) -> f32 {
        let fingers = self.digits[..THUMB].iter().fold(f32::INFINITY, |union, finger| {
            smooth_min(union, finger.distance(point_m), BETWEEN_FINGERS_M)
        });
        let palm = smooth_min(self.trunk_distance(point_m), fingers, FINGER_INTO_PALM_M);
        let thumb = self.digit_distance(THUMB, point_m);
        smooth_min(palm, thumb, THUMB_INTO_PALM_M)
    }

    /// Signed distance to upper arm, forearm and palm.
    pub(super) fn trunk_distance(&self, point_m: Vec3) -> f32 {
        smooth_min(self.arm.distance(point_m), self.palm.distance(point_m), FOREARM_INTO_PALM_M)
    }

    pub(super) fn digit_distance(&self, digit: usize, point_m: Vec3) -> f32 {
        self.digits[digit].distance(point_m)
    }
}

/// A strand through points of the hand's frame, radii in millimetres.
fn hand_strand<const N: usize>(points_mm: [[f32; 3]; N], radii_mm: [f32; N]) -> Strand {
    strand(points_mm.map(hand_point), radii_mm.map(|r| r * 1e-3))
}

/// A ball in the hand's frame, radius in millimetres.
fn hand_ball(centre_mm: [f32; 3], radius_mm: f32) -> Strand {
    vec![Cone::ball(hand_point(centre_mm), radius_mm * 1e-3)]
}

/// From beyond the shoulder to the carpus.
fn arm() -> Vec<Strand> {
    // A point of the forearm, with its distance in millimetres above and before the bones.
    let forearm = |t: f32, offset_mm: [f32; 2]| {
        ELBOW_M.lerp(WRIST_M, t) + Vec3::new(0.0, offset_mm[0], offset_mm[1]) * 1e-3
    };
    let upper_arm = |t: f32, up_mm: f32| SHOULDER_M.lerp(ELBOW_M, t) + Vec3::Y * (up_mm * 1e-3);
    vec![
        strand(
            [upper_arm(-0.02, 0.0), upper_arm(0.45, -1.0), upper_arm(0.8, 0.0), ELBOW_M],
            [0.049, 0.046, 0.038, 0.034],
        ),
        // The point of the elbow.
        vec![Cone::ball(ELBOW_M + Vec3::new(-0.002, -0.002, -0.021), 0.0155)],
        // The radius with the extensors, and the ulna with the flexors, down to the carpus.
        strand(
            [
                forearm(0.02, [3.0, 4.0]),
                forearm(0.24, [4.0, 6.0]),
                forearm(0.60, [2.0, 8.0]),
                forearm(0.92, [0.5, 10.0]),
                hand_point([34.0, 0.5, 12.0]),
            ],
            [0.031, 0.0335, 0.0225, 0.0158, 0.0142],
        ),
        strand(
            [
                forearm(0.02, [-2.0, -5.0]),
                forearm(0.22, [-4.0, -7.0]),
                forearm(0.60, [-2.0, -9.0]),
                forearm(0.92, [0.0, -9.0]),
                hand_point([34.0, 0.0, -14.0]),
            ],
            [0.031, 0.0335, 0.0220, 0.0150, 0.0137],
        ),
        // Head of the ulna, the bump on the back of the wrist.
        vec![Cone::ball(forearm(0.925, [5.5, -14.5]), 0.0080)],
    ]
}

/// The metacarpals, the mounds and the webs between the fingers.
fn palm() -> Vec<Strand> {
    vec![
        // Metacarpals, index to pinky; the knuckles form an arch.
        hand_strand([[30.0, 0.5, 11.0], [85.0, 0.5, 24.0]], [12.5, 11.0]),
        hand_strand([[30.0, 1.5, 3.0], [87.0, 1.5, 2.5]], [12.5, 11.5]),
        hand_strand([[30.0, 0.5, -7.0], [81.0, 0.0, -18.0]], [12.5, 10.8]),
        hand_strand([[30.0, -0.5, -14.0], [71.0, -2.5, -35.5]], [12.5, 9.8]),
        // Knuckles.
        hand_ball([86.0, 5.5, 25.0], 7.8),
        hand_ball([88.0, 6.5, 2.5], 8.0),
        hand_ball([82.0, 5.0, -18.5], 7.4),
        hand_ball([72.5, 1.5, -37.0], 6.8),
        // Pads under the knuckles.
        hand_strand(
            [[76.0, -7.0, 20.0], [72.0, -7.5, -10.0], [64.0, -8.5, -31.0]],
            [8.5, 8.5, 8.0],
        ),
        // Ball of the thumb and the mound opposite.
        hand_strand([[20.0, -9.0, 15.0], [48.0, -13.0, 28.0]], [14.5, 11.0]),
        hand_strand([[12.0, -8.0, -14.0], [50.0, -8.5, -30.0]], [11.5, 10.0]),
        // Web between thumb and index.
        hand_strand([[46.0, -11.0, 33.0], [68.0, -3.0, 25.0]], [8.0, 8.0]),
        // Webs between the fingers, half-way along the first phalanges.
        hand_strand(
            [[100.0, -3.5, 26.0], [102.0, -2.5, 3.0], [96.5, -3.0, -20.0], [84.0, -5.0, -40.0]],
            [6.5, 6.5, 6.5, 6.0],
        ),
    ]
}

/// A finger: three tapered segments, thicker at the joints, with pads on the palm side.
fn finger(digit: &Digit) -> Vec<Strand> {
    let [base, middle, end, tip] = digit.radii_m;
    let [knuckle, second, third, _] = digit.points_m;
    let pad = |k: usize, along: f32, depth: f32, radius_m: f32| {
        let centre_m = digit.points_m[k].lerp(digit.points_m[k + 1], along);
        vec![Cone::ball(centre_m - digit.dorsal[k] * (depth * radius_m), radius_m)]
    };
    let joint = |centre_m: Vec3, dorsal: Vec3, height: f32, radius_m: f32| {
        vec![Cone::ball(centre_m + dorsal * (height * radius_m), radius_m)]
    };
    vec![
        segments(
            [knuckle, second, third, tip_centre(digit)],
            [base * 0.97, middle * 0.97, end * 0.97, tip],
            digit.dorsal[2],
            0.90,
        ),
        joint(second, digit.dorsal[0], 0.14, middle * 0.90),
        joint(third, digit.dorsal[1], 0.06, end * 0.93),
        pad(0, 0.60, 0.30, middle * 0.87),
        pad(1, 0.50, 0.24, end * 0.93),
        pad(2, 0.55, 0.20, tip * 1.0),
    ]
}

/// The thumb: the metacarpal inside the ball of the thumb, two segments, a broad flat tip.
fn thumb(digit: &Digit) -> Vec<Strand> {
    let [base, middle, end, tip] = digit.radii_m;
    let [root, second, third, _] = digit.points_m;
    let centre = tip_centre(digit);
    let pad = third.lerp(centre, 0.65) - digit.dorsal[2] * (0.22 * tip);
    vec![
        segments(
            [root, second, third, centre],
            [base * 0.90, middle * 0.97, end * 0.97, tip],
            digit.dorsal[2],
            0.82,
        ),
        vec![Cone::ball(second + digit.dorsal[0] * (0.08 * middle), middle * 0.95)],
        vec![Cone::ball(third + digit.dorsal[1] * (0.06 * end), end * 0.94)],
        vec![Cone::ball(pad, tip * 1.02)],
    ]
}

/// Three segments of a digit, the last flattened towards its nail.
fn segments(points_m: [Vec3; 4], radii_m: [f32; 4], nail: Vec3, flatness: f32) -> Strand {
    let mut segments = strand(points_m, radii_m);
    if let Some(last) = segments.last_mut() {
        *last = last.flattened(nail, flatness);
    }
    segments
}

/// Centre of the ball that ends the last segment.
fn tip_centre(digit: &Digit) -> Vec3 {
    digit.points_m[3] - digit.axes[2] * digit.radii_m[3]
}

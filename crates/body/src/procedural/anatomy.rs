//! The right arm at rest as smoothly united round cones: what the surface is drawn around.
//!
//! Everything belongs to one of six parts: the trunk (upper arm, forearm, palm) and five digits. A
//! digit blends into the trunk but never into another digit, so that fingers stay separate however
//! close they lie. Offsets are millimetres in the frame of the hand: distal, dorsal, radial.

use glam::Vec3;

use super::cone::{Blend, Cone, smooth_min};
use super::digits::{DIGITS, Digit, THUMB};
use super::frame::{ELBOW_M, SHOULDER_M, WRIST_M, hand_point};

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
            arm: Blend { cones: arm(), blend_m: 0.025 },
            palm: Blend { cones: palm(), blend_m: 0.009 },
            digits: std::array::from_fn(|k| Blend {
                cones: if k == THUMB { thumb(&digits[k]) } else { finger(&digits[k]) },
                blend_m: 0.004,
            }),
        }
    }

    /// Signed distance to the surface in metres, negative inside.
    pub(super) fn distance(&self, point_m: Vec3) -> f32 {
        let trunk = self.trunk_distance(point_m);
        self.digits.iter().enumerate().fold(trunk, |union, (k, digit)| {
            let into_palm = if k == THUMB { THUMB_INTO_PALM_M } else { FINGER_INTO_PALM_M };
            union.min(smooth_min(trunk, digit.distance(point_m), into_palm))
        })
    }

    /// Signed distance to upper arm, forearm and palm.
    pub(super) fn trunk_distance(&self, point_m: Vec3) -> f32 {
        smooth_min(self.arm.distance(point_m), self.palm.distance(point_m), FOREARM_INTO_PALM_M)
    }

    /// Signed distance to one digit.
    pub(super) fn digit_distance(&self, digit: usize, point_m: Vec3) -> f32 {
        self.digits[digit].distance(point_m)
    }
}

/// A cone between two points of the hand's frame, radii in millimetres.
fn hand_cone(start_mm: [f32; 3], end_mm: [f32; 3], radii_mm: [f32; 2]) -> Cone {
    Cone::new(hand_point(start_mm), hand_point(end_mm), radii_mm.map(|r| r * 1e-3))
}

/// Upper arm and forearm, from beyond the shoulder to the wrist.
fn arm() -> Vec<Cone> {
    let forearm = |t: f32, offset_mm: [f32; 2]| {
        ELBOW_M.lerp(WRIST_M, t) + Vec3::new(0.0, offset_mm[0], offset_mm[1]) * 1e-3
    };
    let inner_end = SHOULDER_M + Vec3::new(0.005, 0.0, 0.0);
    vec![
        Cone::new(inner_end, SHOULDER_M.lerp(ELBOW_M, 0.45), [0.046, 0.044]),
        Cone::new(SHOULDER_M.lerp(ELBOW_M, 0.45), ELBOW_M, [0.044, 0.036]),
        // The point of the elbow.
        Cone::ball(ELBOW_M + Vec3::new(0.0, -0.002, -0.022), 0.018),
        // Extensors on the thumb's side, flexors on the other; both taper into tendons.
        Cone::new(forearm(0.0, [4.0, 6.0]), forearm(0.27, [4.0, 6.0]), [0.034, 0.034]),
        Cone::new(forearm(0.27, [4.0, 6.0]), forearm(0.72, [1.0, 9.0]), [0.034, 0.020]),
        Cone::new(forearm(0.0, [-2.0, -6.0]), forearm(0.25, [-4.0, -7.0]), [0.034, 0.034]),
        Cone::new(forearm(0.25, [-4.0, -7.0]), forearm(0.72, [-1.0, -9.0]), [0.034, 0.020]),
        // Radius and ulna under the skin.
        Cone::new(forearm(0.72, [1.0, 9.0]), forearm(0.97, [0.0, 10.0]), [0.020, 0.0165]),
        Cone::new(forearm(0.72, [-1.0, -9.0]), forearm(0.97, [0.0, -9.0]), [0.020, 0.0160]),
        // Head of the ulna, the bump on the back of the wrist.
        Cone::ball(forearm(0.94, [8.0, -15.0]), 0.0095),
    ]
}

/// The palm: carpus, metacarpals, mounds and the webs between the fingers.
fn palm() -> Vec<Cone> {
    vec![
        // Carpus.
        hand_cone([-6.0, 0.0, -9.0], [34.0, 0.0, -14.0], [15.5, 13.5]),
        hand_cone([-6.0, 0.0, 9.0], [34.0, 0.5, 12.0], [16.0, 14.0]),
        // Metacarpals, index to pinky; the knuckles form an arch.
        hand_cone([32.0, 1.0, 12.0], [85.0, 0.5, 23.5], [13.0, 11.0]),
        hand_cone([32.0, 2.0, 3.0], [87.0, 1.5, 2.5], [13.0, 11.5]),
        hand_cone([32.0, 1.0, -7.0], [81.0, 0.0, -17.0], [13.0, 10.8]),
        hand_cone([32.0, -0.5, -15.0], [71.0, -2.5, -34.0], [12.5, 9.8]),
        // Knuckles.
        Cone::ball(hand_point([86.0, 5.5, 24.0]), 0.0078),
        Cone::ball(hand_point([88.0, 6.5, 2.5]), 0.0080),
        Cone::ball(hand_point([82.0, 5.0, -17.5]), 0.0074),
        Cone::ball(hand_point([72.5, 1.5, -35.0]), 0.0068),
        // Pads under the knuckles.
        hand_cone([76.0, -7.0, 20.0], [72.0, -7.5, -10.0], [8.5, 8.5]),
        hand_cone([72.0, -7.5, -10.0], [64.0, -8.5, -30.0], [8.5, 8.0]),
        // Ball of the thumb and the mound opposite.
        hand_cone([20.0, -9.0, 15.0], [48.0, -13.0, 28.0], [14.5, 11.0]),
        hand_cone([14.0, -8.0, -15.0], [50.0, -8.5, -29.0], [12.0, 10.0]),
        // Web between thumb and index.
        hand_cone([46.0, -11.0, 33.0], [68.0, -3.0, 25.0], [8.0, 8.0]),
        // Webs between the fingers, half-way along the first phalanges.
        hand_cone([97.0, -3.5, 24.0], [99.0, -3.0, 3.0], [6.2, 6.2]),
        hand_cone([99.0, -3.0, 3.0], [93.0, -3.5, -18.0], [6.2, 6.2]),
        hand_cone([93.0, -3.5, -18.0], [80.0, -5.5, -36.0], [6.2, 5.8]),
    ]
}

/// A finger: three tapered segments, thicker at the joints, with pads on the palm side.
fn finger(digit: &Digit) -> Vec<Cone> {
    let [base, middle, end, tip] = digit.radii_m;
    let centre = tip_centre(digit);
    let [knuckle, second, third, _] = digit.points_m;
    let pad = |k: usize, along: f32, depth: f32, radius_m: f32| {
        let centre_m = digit.points_m[k].lerp(digit.points_m[k + 1], along);
        Cone::ball(centre_m - digit.dorsal[k] * (depth * radius_m), radius_m)
    };
    vec![
        Cone::new(knuckle, second, [base * 0.93, middle * 0.93]),
        Cone::new(second, third, [middle * 0.93, end * 0.94]),
        Cone::new(third, centre, [end * 0.95, tip]).flattened(digit.dorsal[2], 0.92),
        Cone::ball(second + digit.dorsal[0] * (0.12 * middle), middle * 0.93),
        Cone::ball(third + digit.dorsal[1] * (0.08 * end), end * 0.94),
        pad(0, 0.60, 0.30, middle * 0.86),
        pad(1, 0.50, 0.28, end * 0.92),
        pad(2, 0.52, 0.22, tip * 1.02),
    ]
}

/// The thumb: the metacarpal inside the ball of the thumb, two segments, a broad flat tip.
fn thumb(digit: &Digit) -> Vec<Cone> {
    let [base, middle, end, tip] = digit.radii_m;
    let [root, second, third, _] = digit.points_m;
    let centre = tip_centre(digit);
    let pad = third.lerp(centre, 0.65) - digit.dorsal[2] * (0.22 * tip);
    vec![
        Cone::new(root, second, [base * 0.9, middle * 0.96]),
        Cone::new(second, third, [middle * 0.94, end * 0.92]),
        Cone::new(third, centre, [end * 0.98, tip]).flattened(digit.dorsal[2], 0.82),
        Cone::ball(second + digit.dorsal[0] * (0.10 * middle), middle * 0.96),
        Cone::ball(third + digit.dorsal[1] * (0.06 * end), end * 0.96),
        Cone::ball(pad, tip * 1.02),
    ]
}

/// Centre of the ball that ends the last segment.
fn tip_centre(digit: &Digit) -> Vec3 {
    digit.points_m[3] - digit.axes[2] * digit.radii_m[3]
}

//! The human at rest as smoothly united round cones: what the surface is drawn around.
//!
//! Lengths are those of an adult of about 1.75 m in the T-pose of SMPL+H, on the joints that the
//! procedural arm hangs on. Limbs are given for the left side; the right one is its mirror image.

use glam::Vec3;

use crate::implicit::cone::{Blend, Cone, Strand, smooth_min, strand};

/// Over how much the parts of the trunk blend into each other.
const WITHIN_TRUNK_M: f32 = 0.05;
/// Over how much limbs blend into the trunk.
const LIMB_INTO_TRUNK_M: f32 = 0.045;
/// Over how much the parts of a limb blend into each other.
const WITHIN_LIMB_M: f32 = 0.02;
/// Over how much the legs blend into each other: they stay apart from half of it on.
const BETWEEN_LEGS_M: f32 = 0.012;

/// The parts of the body as distance fields.
pub(super) struct Anatomy {
    trunk: Blend,
    head: Blend,
    arm: Blend,
    leg: Blend,
}

impl Anatomy {
    /// The mean body.
    pub(super) fn new() -> Self {
        Self {
            trunk: Blend { strands: trunk(), blend_m: WITHIN_TRUNK_M },
            head: Blend { strands: head(), blend_m: 0.02 },
            arm: Blend { strands: arm(), blend_m: WITHIN_LIMB_M },
            leg: Blend { strands: leg(), blend_m: WITHIN_LIMB_M },
        }
    }

    /// Signed distance to the surface in metres, negative inside.
    pub(super) fn distance(&self, point_m: Vec3) -> f32 {
        // Both sides are the same: the point is looked at from the left.
        let left_m = point_m.with_x(point_m.x.abs());
        let trunk = smooth_min(self.trunk.distance(left_m), self.head.distance(left_m), 0.03);
        let with_arm = smooth_min(trunk, self.arm.distance(left_m), LIMB_INTO_TRUNK_M);
        let other_m = left_m.with_x(-left_m.x);
        let legs =
            smooth_min(self.leg.distance(left_m), self.leg.distance(other_m), BETWEEN_LEGS_M);
        smooth_min(with_arm, legs, LIMB_INTO_TRUNK_M)
    }
}

fn at(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A cone that is thinner from front to back.
fn flat(start_m: Vec3, end_m: Vec3, radii_m: [f32; 2], ratio: f32) -> Strand {
    vec![Cone::new(start_m, end_m, radii_m).flattened(Vec3::Z, ratio)]
}

fn trunk() -> Vec<Strand> {
    vec![
        // Pelvis, waist, chest.
        flat(at(0.0, -0.285, 0.005), at(0.0, -0.17, 0.005), [0.152, 0.138], 0.70),
        flat(at(0.0, -0.17, 0.008), at(0.0, -0.02, 0.010), [0.134, 0.132], 0.68),
        flat(at(0.0, -0.02, 0.008), at(0.0, 0.13, 0.0), [0.138, 0.150], 0.70),
        // Shoulder girdle, and the slope of the shoulders towards the neck.
        vec![Cone::new(at(0.0, 0.195, -0.02), at(0.155, 0.205, -0.02), [0.075, 0.058])],
        vec![Cone::new(at(0.0, 0.25, -0.02), at(0.12, 0.225, -0.02), [0.058, 0.045])],
        // Chest muscles and shoulder blades.
        vec![Cone::ball(at(0.07, 0.11, 0.045), 0.068)],
        vec![Cone::ball(at(0.075, 0.12, -0.055), 0.062)],
        // Buttocks.
        vec![Cone::ball(at(0.07, -0.315, -0.055), 0.088)],
    ]
}

fn head() -> Vec<Strand> {
    vec![
        strand(
            [at(0.0, 0.22, -0.02), at(0.0, 0.31, -0.005), at(0.0, 0.37, 0.012)],
            [0.062, 0.055, 0.055],
        ),
        // Skull, face, chin, nose, ears.
        vec![
            Cone::new(at(0.0, 0.468, 0.012), at(0.0, 0.462, 0.042), [0.098, 0.090])
                .flattened(Vec3::X, 0.84),
        ],
        vec![
            Cone::new(at(0.0, 0.44, 0.052), at(0.0, 0.375, 0.070), [0.072, 0.046])
                .flattened(Vec3::X, 0.92),
        ],
        vec![Cone::new(at(0.0, 0.445, 0.125), at(0.0, 0.415, 0.140), [0.010, 0.016])],
        vec![Cone::ball(at(0.085, 0.435, 0.015), 0.024).flattened(Vec3::X, 0.5)],
    ]
}

fn arm() -> Vec<Strand> {
    vec![
        // Shoulder and upper arm, forearm.
        strand(
            [
                at(0.165, 0.215, -0.02),
                at(0.24, 0.217, -0.024),
                at(0.34, 0.213, -0.032),
                at(0.43, 0.21, -0.04),
            ],
            [0.060, 0.056, 0.049, 0.041],
        ),
        strand(
            [
                at(0.43, 0.21, -0.04),
                at(0.49, 0.212, -0.038),
                at(0.58, 0.217, -0.042),
                at(0.68, 0.22, -0.045),
            ],
            [0.042, 0.045, 0.038, 0.029],
        ),
        // Palm, fingers, thumb.
        vec![
            Cone::new(at(0.68, 0.22, -0.045), at(0.765, 0.217, -0.042), [0.032, 0.045])
                .flattened(Vec3::Y, 0.5),
        ],
        vec![
            Cone::new(at(0.765, 0.217, -0.042), at(0.850, 0.212, -0.040), [0.045, 0.028])
                .flattened(Vec3::Y, 0.42),
        ],
        vec![Cone::new(at(0.715, 0.216, -0.020), at(0.775, 0.208, 0.025), [0.020, 0.014])],
    ]
}

fn leg() -> Vec<Strand> {
    vec![
        // Thigh; shank with its calf.
        strand(
            [
                at(0.085, -0.33, 0.0),
                at(0.092, -0.47, 0.008),
                at(0.099, -0.62, 0.012),
                at(0.10, -0.69, 0.012),
            ],
            [0.098, 0.086, 0.064, 0.060],
        ),
        strand(
            [
                at(0.10, -0.69, 0.010),
                at(0.098, -0.80, -0.012),
                at(0.094, -0.96, -0.024),
                at(0.09, -1.10, -0.03),
            ],
            [0.059, 0.060, 0.045, 0.039],
        ),
        // Heel, foot, toes.
        strand(
            [at(0.09, -1.135, -0.045), at(0.105, -1.155, 0.05), at(0.120, -1.168, 0.135)],
            [0.044, 0.042, 0.030],
        ),
        vec![
            Cone::new(at(0.098, -1.165, 0.06), at(0.118, -1.172, 0.150), [0.040, 0.026])
                .flattened(Vec3::Y, 0.6),
        ],
    ]
}

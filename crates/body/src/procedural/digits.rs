//! Rest positions and radii of the bones of the five digits.
//!
//! Lengths are rounded means of an adult: bones after Buryanov and Kotiuk,
//! *Proportions of hand segments* (Int. J. Morphol. 28(3), 2010), tips with their soft tissue.

use glam::Vec3;

use super::frame::{direction, hand_point};

/// Digits of a hand, in the order of SMPL+H.
pub(super) const DIGITS: usize = 5;
/// Index of the thumb.
pub(super) const THUMB: usize = 4;

/// One digit. Vectors are (distal, dorsal, radial), lengths millimetres.
struct Plan {
    /// First joint, from the wrist.
    base_mm: [f32; 3],
    /// Directions of the three segments, of any length.
    directions: [[f32; 3]; 3],
    /// Lengths of the three segments, the last to the surface of the tip.
    lengths_mm: [f32; 3],
    /// Radii at the three joints and of the tip.
    radii_mm: [f32; 4],
    /// Approximate direction of the nail's normal.
    dorsal: [f32; 3],
}

const PLANS: [Plan; DIGITS] = [
    // Index.
    Plan {
        base_mm: [86.0, 1.0, 25.0],
        directions: [[1.0, -0.02, 0.13], [1.0, -0.06, 0.11], [1.0, -0.10, 0.09]],
        lengths_mm: [42.5, 25.0, 22.5],
        radii_mm: [10.6, 9.4, 8.3, 6.9],
        dorsal: [0.0, 1.0, 0.0],
    },
    // Middle.
    Plan {
        base_mm: [88.0, 2.0, 2.5],
        directions: [[1.0, -0.02, 0.02], [1.0, -0.06, 0.015], [1.0, -0.10, 0.01]],
        lengths_mm: [46.5, 28.5, 23.5],
        radii_mm: [10.8, 9.6, 8.4, 7.0],
        dorsal: [0.0, 1.0, 0.0],
    },
    // Pinky.
    Plan {
        base_mm: [73.0, -2.0, -37.0],
        directions: [[1.0, -0.04, -0.25], [1.0, -0.08, -0.21], [1.0, -0.12, -0.18]],
        lengths_mm: [34.0, 20.5, 20.5],
        radii_mm: [9.4, 8.1, 7.2, 6.1],
        dorsal: [0.0, 1.0, 0.0],
    },
    // Ring.
    Plan {
        base_mm: [82.5, 1.0, -18.5],
        directions: [[1.0, -0.03, -0.09], [1.0, -0.07, -0.08], [1.0, -0.11, -0.07]],
        lengths_mm: [43.0, 27.0, 23.0],
        radii_mm: [10.2, 9.1, 8.0, 6.7],
        dorsal: [0.0, 1.0, 0.0],
    },
    // Thumb: its first bone is the metacarpal.
    Plan {
        base_mm: [20.0, -9.0, 21.0],
        directions: [[0.74, -0.26, 0.62], [0.84, -0.18, 0.50], [0.90, -0.14, 0.40]],
        lengths_mm: [45.0, 33.0, 29.0],
        radii_mm: [14.0, 11.4, 10.4, 8.4],
        dorsal: [-0.35, 0.62, 0.70],
    },
];

/// One digit at rest, in model coordinates.
#[derive(Debug, Clone)]
pub(super) struct Digit {
    /// The three joints and the end of the last segment, on the surface.
    pub(super) points_m: [Vec3; 4],
    /// Directions of the three segments.
    pub(super) axes: [Vec3; 3],
    /// Unit vectors out of the back of each segment, perpendicular to it.
    pub(super) dorsal: [Vec3; 3],
    /// Radii at the three joints and of the tip.
    pub(super) radii_m: [f32; 4],
}

impl Digit {
    /// The axis about which a positive angle flexes segment `k`.
    pub(super) fn flexion_axis(&self, k: usize) -> Vec3 {
        self.dorsal[k].cross(self.axes[k])
    }
}

/// The five digits at rest.
pub(super) fn digits() -> [Digit; DIGITS] {
    PLANS.map(|plan| {
        let axes = plan.directions.map(direction);
        let mut points_m = [hand_point(plan.base_mm); 4];
        for k in 0..3 {
            points_m[k + 1] = points_m[k] + axes[k] * (plan.lengths_mm[k] * 1e-3);
        }
        let back = direction(plan.dorsal);
        let dorsal = axes.map(|axis| (back - axis * back.dot(axis)).normalize());
        Digit { points_m, axes, dorsal, radii_m: plan.radii_mm.map(|r| r * 1e-3) }
    })
}

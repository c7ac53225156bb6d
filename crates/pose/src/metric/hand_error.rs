//! Errors of the 12 parameters of a hand, in millimetres and degrees.
//!
//! # Model
//! * Translation: distance between the wrists, in millimetres.
//! * Rotation: the angle of the rotation from one wrist to the other, in degrees.
//! * Articulation: root mean square over the six coefficients, dimensionless. For an orthonormal
//!   basis, as MANO's is, this is a distance between hand shapes whichever axes span them.
//!
//! Over frames, each is averaged as it is, never squared first.

use serde::{Deserialize, Serialize};

use crate::HandParams;
use crate::rotation::geodesic_rad;

/// Errors of a predicted hand.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct HandError {
    /// Distance between the wrists, in millimetres.
    pub translation_mm: f64,
    /// Angle between the wrists' rotations, in degrees, 0 to 180.
    pub rotation_deg: f64,
    /// Root mean square of the six coefficients' differences.
    pub articulation: f64,
}

impl HandError {
    /// The error of `predicted` where `truth` is right; symmetric.
    pub fn between(predicted: &HandParams, truth: &HandParams) -> Self {
        let squares = predicted.articulation.iter().zip(&truth.articulation).map(|(p, t)| {
            let difference = f64::from(p - t);
            difference * difference
        });
        Self {
            translation_mm: 1e3 * f64::from(predicted.translation_m.distance(truth.translation_m)),
            rotation_deg: f64::from(geodesic_rad(predicted.rotation, truth.rotation)).to_degrees(),
            articulation: (squares.sum::<f64>() / truth.articulation.len() as f64).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use glam::Vec3;

    use super::*;

    #[test]
    fn each_error_is_in_its_unit() {
        let truth = HandParams::default();
        let predicted = HandParams {
            articulation: [0.5; 6],
            translation_m: Vec3::new(0.03, 0.0, -0.04),
            rotation: Vec3::new(0.0, PI / 6.0, 0.0),
        };
        let error = HandError::between(&predicted, &truth);
        assert!((error.translation_mm - 50.0).abs() < 1e-4, "{error:?}");
        assert!((error.rotation_deg - 30.0).abs() < 1e-4, "{error:?}");
        assert!((error.articulation - 0.5).abs() < 1e-9, "{error:?}");
        assert_eq!(HandError::between(&truth, &truth), HandError::default());
    }

    #[test]
    fn a_sign_jump_at_a_half_turn_is_no_error() {
        let at = |angle: f32| HandParams { rotation: Vec3::X * angle, ..HandParams::default() };
        let error = HandError::between(&at(PI - 0.005), &at(-(PI - 0.005)));
        assert!((error.rotation_deg - 0.573).abs() < 1e-3, "{error:?}");
    }
}

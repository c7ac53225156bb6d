//! The Kalman filter on the 12 parameters of a hand.
//!
//! The rotation is filtered as an axis-angle vector. The canonical vector (angle in [0, π]) jumps
//! by 2π where the hand turns through π, and a filter would sweep through all angles between. So
//! each measured vector is replaced by its equivalent nearest to the filter's estimate, which may
//! then grow past π; outputs are canonical again.
//!
//! # Model
//! Axis-angle vectors degenerate again at 2π. An estimate beyond 3π/2 is therefore rewritten as the
//! same rotation `v' = v·(θ − 2π)/θ`, with `θ = |v|`. Its velocity follows exactly: the part along
//! the axis stays, the part across it is scaled by `(θ − 2π)/θ`. The covariance is left alone.
//!
//! # Source
//! EventHands filters the canonical vectors as they are: [`HandFilterConfig::parity`].

use std::f64::consts::{PI, TAU};

use evpose_core::Micros;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{ConstantVelocityKalman, KalmanConfig, NoiseSetting};
use crate::rotation::{canonical_axis_angle, nearest_axis_angle};
use crate::{HandParams, PARAMETERS, PoseError};

/// Index of the rotation among the 12 parameters.
const ROTATION: usize = 9;

/// Settings of a [`HandFilter`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HandFilterConfig {
    /// The filter of each parameter.
    pub kalman: KalmanConfig,
    /// Whether the rotation is followed through π.
    pub unwrap_rotation: bool,
}

impl HandFilterConfig {
    /// The settings of the published programs.
    pub fn parity(setting: NoiseSetting) -> Self {
        Self { kalman: KalmanConfig::parity(setting), unwrap_rotation: false }
    }
}

impl Default for HandFilterConfig {
    fn default() -> Self {
        Self { kalman: KalmanConfig::default(), unwrap_rotation: true }
    }
}

/// A temporal filter of hand poses.
#[derive(Debug, Clone)]
pub struct HandFilter {
    kalman: ConstantVelocityKalman,
    unwrap_rotation: bool,
}

impl HandFilter {
    /// A filter without measurements yet.
    ///
    /// # Errors
    /// If a variance is not positive and finite.
    pub fn new(config: &HandFilterConfig) -> Result<Self, PoseError> {
        Ok(Self {
            kalman: ConstantVelocityKalman::new(config.kalman, PARAMETERS)?,
            unwrap_rotation: config.unwrap_rotation,
        })
    }

    /// The estimate for time `t` from the measurement of time `t` and all before.
    pub fn update(&mut self, t: Micros, measured: &HandParams) -> HandParams {
        let mut z = *measured;
        if self.unwrap_rotation {
            z.rotation = nearest_axis_angle(z.rotation, self.rotation().as_vec3());
        }
        let mut out = [0.0; PARAMETERS];
        self.kalman.update(t, &z.to_array(), &mut out);
        let mut estimate = HandParams::from_array(out);
        if self.unwrap_rotation {
            self.rewrite_rotation();
            estimate.rotation = canonical_axis_angle(estimate.rotation);
        }
        estimate
    }

    /// Forgets every measurement.
    pub fn reset(&mut self) {
        self.kalman.reset();
    }

    /// As [`ConstantVelocityKalman::largest_innovation`]; a rotation that is followed through π is
    /// no surprise.
    pub fn largest_innovation(&self) -> f64 {
        self.kalman.largest_innovation()
    }

    /// Goes on with other settings, which must be valid.
    pub(super) fn retune(&mut self, kalman: KalmanConfig) {
        self.kalman.retune(kalman);
    }

    /// The estimated rotation as the filter holds it, zero before the first measurement.
    fn rotation(&self) -> DVec3 {
        let mut values = self.kalman.positions().skip(ROTATION);
        DVec3::from_array(std::array::from_fn(|_| values.next().unwrap_or(0.0)))
    }

    /// Brings the held rotation back well inside 2π, and its velocity with it.
    fn rewrite_rotation(&mut self) {
        let vector = self.rotation();
        let angle_rad = vector.length();
        // Not at half a turn, where noise would flip it to and fro.
        if angle_rad <= 1.5 * PI {
            return;
        }
        let axis = vector / angle_rad;
        let scale = (angle_rad - TAU) / angle_rad;
        let tracks = &mut self.kalman.tracks_mut()[ROTATION..];
        let velocity: DVec3 = DVec3::from_array(std::array::from_fn(|i| tracks[i].velocity));
        // Along the axis the angle is only shifted, across it lengths scale with it.
        let along = axis * velocity.dot(axis);
        let rewritten = along + (velocity - along) * scale;
        for (i, track) in tracks.iter_mut().enumerate() {
            track.position = vector[i] * scale;
            track.velocity = rewritten[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::rotation::{axis_angle_from_matrix, geodesic_rad, matrix_from_axis_angle};

    fn with_rotation(rotation: Vec3) -> HandParams {
        HandParams { rotation, ..HandParams::default() }
    }

    /// The largest error, from the second second on, of turning at 4 rad/s about a fixed axis.
    fn worst_error_rad(config: &HandFilterConfig, from_rad: f32) -> f32 {
        let axis = Vec3::new(0.36, -0.48, 0.8);
        let mut filter = HandFilter::new(config).expect("valid settings");
        (0..4_000)
            .map(|k| {
                let truth = axis * (from_rad + 0.004 * k as f32);
                let measured = with_rotation(canonical_axis_angle(truth));
                let estimate = filter.update(Micros(k * 1_000), &measured);
                assert!(estimate.rotation.length() < 3.2 || !config.unwrap_rotation);
                if k < 1_000 { 0.0 } else { geodesic_rad(truth, estimate.rotation) }
            })
            .fold(0.0, f32::max)
    }

    #[test]
    fn a_steady_turn_is_followed_through_many_half_turns() {
        assert!(worst_error_rad(&HandFilterConfig::default(), -1.0) < 1e-3);
    }

    #[test]
    fn without_unwrapping_the_filter_tears_at_a_half_turn() {
        let torn = HandFilterConfig { unwrap_rotation: false, ..HandFilterConfig::default() };
        assert!(worst_error_rad(&torn, -1.0) > 1.0);
    }

    /// The error in radians at every step of one millisecond.
    fn errors_rad(truth: impl Fn(f32) -> Vec3) -> Vec<f32> {
        let mut filter = HandFilter::new(&HandFilterConfig::default()).expect("valid settings");
        let error_rad = |k: i64| {
            let truth = canonical_axis_angle(truth(k as f32 * 1e-3));
            let estimate = filter.update(Micros(k * 1_000), &with_rotation(truth));
            geodesic_rad(truth, estimate.rotation)
        };
        (0..2_000).map(error_rad).collect()
    }

    /// The axis moves too, so that the vector has a velocity across itself where it is rewritten:
    /// 4.8 rad at 1.4 s.
    #[test]
    fn rewriting_the_rotation_leaves_no_trace() {
        let errors = errors_rad(|s| {
            Vec3::new((0.8 * s).cos(), (0.8 * s).sin(), 0.3).normalize() * (2.0 + 2.0 * s)
        });
        let worst = |steps: &[f32]| steps.iter().copied().fold(0.0, f32::max);
        let (before, after) = (worst(&errors[800..1_300]), worst(&errors[1_300..]));
        assert!(after < 1.5 * before && before < 0.03, "{before} {after}");
    }

    /// A full turn that misses the identity by 0.2 rad: vectors near 2π long would whirl around.
    #[test]
    fn a_full_turn_is_as_smooth_as_any() {
        let tilt = matrix_from_axis_angle(Vec3::X * 0.2);
        let errors = errors_rad(|s| {
            axis_angle_from_matrix(matrix_from_axis_angle(Vec3::Z * (1.0 + 4.0 * s)) * tilt)
        });
        let worst = errors[800..].iter().copied().fold(0.0, f32::max);
        assert!(worst < 0.05, "{worst}");
    }

    #[test]
    fn parity_keeps_the_12_parameters_apart_and_uncanonical() {
        let setting = NoiseSetting::Regular;
        let mut hand = HandFilter::new(&HandFilterConfig::parity(setting)).expect("valid settings");
        let mut plain = ConstantVelocityKalman::new(KalmanConfig::parity(setting), PARAMETERS)
            .expect("valid settings");
        for k in 0..20 {
            let z: [f32; PARAMETERS] = std::array::from_fn(|i| ((k * 5 + i * 3) % 11) as f32 - 5.0);
            let mut out = [0.0; PARAMETERS];
            plain.update(Micros(0), &z, &mut out);
            let estimate = hand.update(Micros(0), &HandParams::from_array(z));
            assert_eq!(estimate.to_array(), out);
        }
    }
}

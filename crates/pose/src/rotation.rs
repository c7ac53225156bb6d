//! Rotations as axis-angle vectors (radians) and as matrices, and distances between them.
//!
//! A rotation has many axis-angle vectors: `axis·(angle + 2πk)` for every integer `k`. The
//! *canonical* one has its angle in [0, π]. It jumps in sign where the angle passes π, so
//! whatever follows a rotation over time wants [`nearest_axis_angle`] instead.
//!
//! Everything is computed in `f64`; the functions on [`Vec3`] and [`Mat3`] convert at their ends.
//!
//! # Model
//! Rodrigues: `R = I + sin θ/θ · K + (1 − cos θ)/θ² · K²`, with `K` the cross-product matrix of the
//! vector and `θ` its length. The way back and the distances go through the unit quaternion
//! `(v, w)`, `θ = 2·atan2(|v|, |w|)`, which keeps its precision near 0 and near π.
//!
//! # Source
//! Markley, *Unit quaternion from rotation matrix*, J. Guidance 31(2), 2008. EventHands instead
//! takes the axis from `R − Rᵀ` and the nearer of `asin` and `π − asin`: the same vector, except
//! at exactly π, where its axis vanishes and ours is one of the two correct ones.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3, Mat3, Vec3};

/// The matrix of an axis-angle vector.
pub fn matrix_from_axis_angle(rotation: Vec3) -> Mat3 {
    matrix_from_axis_angle_f64(rotation.as_dvec3()).as_mat3()
}

/// The canonical axis-angle vector (angle in [0, π]) of a rotation matrix.
pub fn axis_angle_from_matrix(matrix: Mat3) -> Vec3 {
    axis_angle_from_matrix_f64(matrix.as_dmat3()).as_vec3()
}

/// As [`matrix_from_axis_angle`], in double precision.
pub fn matrix_from_axis_angle_f64(rotation: DVec3) -> DMat3 {
    let angle_rad = rotation.length();
    let k = DMat3::from_cols(
        DVec3::new(0.0, rotation.z, -rotation.y),
        DVec3::new(-rotation.z, 0.0, rotation.x),
        DVec3::new(rotation.y, -rotation.x, 0.0),
    );
    let half_sinc = sin_over(0.5 * angle_rad);
    // (1 − cos θ)/θ² = 2 sin²(θ/2)/θ², which does not cancel at small angles.
    DMat3::IDENTITY + k * sin_over(angle_rad) + k * k * (0.5 * half_sinc * half_sinc)
}

/// As [`axis_angle_from_matrix`], in double precision.
pub fn axis_angle_from_matrix_f64(matrix: DMat3) -> DVec3 {
    axis_angle_from_quaternion(DQuat::from_mat3(&matrix))
}

/// The angle between two rotations in radians, in [0, π].
pub fn geodesic_rad(a: Vec3, b: Vec3) -> f32 {
    let difference = quaternion(a).conjugate() * quaternion(b);
    // q and -q are the same rotation; the absolute value takes the shorter way.
    (2.0 * difference.xyz().length().atan2(difference.w.abs())) as f32
}

/// The vector of the same rotation whose angle lies in [0, π].
pub fn canonical_axis_angle(rotation: Vec3) -> Vec3 {
    axis_angle_from_quaternion(quaternion(rotation)).as_vec3()
}

/// The vector of the same rotation that lies nearest to `reference`.
///
/// The identity has no axis of its own and takes that of the reference.
pub fn nearest_axis_angle(rotation: Vec3, reference: Vec3) -> Vec3 {
    let (vector, reference) = (rotation.as_dvec3(), reference.as_dvec3());
    let Some(axis) = vector.try_normalize().or_else(|| reference.try_normalize()) else {
        return rotation;
    };
    // Only whole turns about its own axis leave the rotation as it is.
    let turns = ((reference.dot(axis) - vector.dot(axis)) / TAU).round();
    (vector + axis * (TAU * turns)).as_vec3()
}

/// The unit quaternion of an axis-angle vector.
pub(crate) fn quaternion(rotation: Vec3) -> DQuat {
    let half = 0.5 * rotation.as_dvec3();
    let half_angle_rad = half.length();
    DQuat::from_vec4((half * sin_over(half_angle_rad)).extend(half_angle_rad.cos()))
}

/// The canonical axis-angle vector of a quaternion, of either sign and any length but zero.
pub(crate) fn axis_angle_from_quaternion(q: DQuat) -> DVec3 {
    // q and −q are the same rotation; w ≥ 0 is the one whose angle is at most π.
    let q = if q.w < 0.0 { -q } else { q };
    let (vector, sine) = (q.xyz(), q.xyz().length());
    if sine == 0.0 { DVec3::ZERO } else { vector * (2.0 * sine.atan2(q.w) / sine) }
}

/// `sin x / x`, 1 at 0.
fn sin_over(x: f64) -> f64 {
    // The next term of the series, x⁴/120, is below the rounding of 1.
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_PI_2, PI};

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_sine_over_its_angle_is_smooth_at_its_series() {
        assert_eq!(sin_over(0.0), 1.0);
        // 1 - x²/6 is exact to 1e-18 there; doubles next to 1 are 1.1e-16 apart.
        assert!((sin_over(0.99e-4) - (1.0 - 0.99e-4_f64.powi(2) / 6.0)).abs() < 2e-16);
        assert!(sin_over(0.99e-4) < 1.0 && sin_over(1.01e-4) < sin_over(0.99e-4));
    }

    /// Any axis, angles up to `max`.
    fn rotations(max: f32) -> impl Strategy<Value = Vec3> {
        (-1.0f32..1.0, -PI..PI, 0.0..max).prop_map(|(z, around, angle)| {
            let r = (1.0 - z * z).max(0.0).sqrt();
            Vec3::new(r * around.cos(), r * around.sin(), z) * angle
        })
    }

    /// The extraction of the EventHands program.
    fn published(r: DMat3) -> DVec3 {
        let skew = (r - r.transpose()) * 0.5;
        let vee = DVec3::new(skew.y_axis.z, skew.z_axis.x, skew.x_axis.y);
        let Some(axis) = vee.try_normalize() else { return DVec3::ZERO };
        // Rounding may leave a sine above 1, whose arcsine would be NaN.
        let theta = vee.length().min(1.0).asin();
        let frobenius = |m: DMat3| m.to_cols_array().iter().map(|v| v * v).sum::<f64>();
        [theta, std::f64::consts::PI - theta]
            .map(|angle| axis * angle)
            .into_iter()
            .min_by(|a, b| {
                frobenius(matrix_from_axis_angle_f64(*a) - r)
                    .total_cmp(&frobenius(matrix_from_axis_angle_f64(*b) - r))
            })
            .unwrap_or(DVec3::ZERO)
    }

    #[test]
    fn a_quarter_turn_about_z_sends_x_to_y() {
        let r = matrix_from_axis_angle(Vec3::Z * FRAC_PI_2);
        assert!((r * Vec3::X - Vec3::Y).length() < 1e-6);
        assert!((r * Vec3::Y + Vec3::X).length() < 1e-6);
        assert!((r * Vec3::Z - Vec3::Z).length() < 1e-6);
    }

    #[test]
    fn the_zero_vector_is_the_identity() {
        assert_eq!(matrix_from_axis_angle(Vec3::ZERO), Mat3::IDENTITY);
        assert_eq!(axis_angle_from_matrix(Mat3::IDENTITY), Vec3::ZERO);
    }

    #[test]
    fn a_half_turn_keeps_its_axis_up_to_sign() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.6, -0.8, 0.0)] {
            let back = axis_angle_from_matrix(matrix_from_axis_angle(axis * PI));
            assert!((back.length() - PI).abs() < 1e-5, "{back}");
            assert!(back.normalize().dot(axis).abs() > 1.0 - 1e-6, "{back}");
        }
    }

    #[test]
    fn tiny_rotations_keep_their_relative_precision() {
        let tiny = DVec3::new(3e-9, -2e-9, 1e-9);
        let back = axis_angle_from_matrix_f64(matrix_from_axis_angle_f64(tiny));
        assert!((back - tiny).length() < 1e-15, "{back}");
        let (a, b) = (Vec3::new(1e-6, 0.0, 0.0), Vec3::new(0.0, 0.0, 0.0));
        assert!((geodesic_rad(a, b) - 1e-6).abs() < 1e-12);
    }

    #[test]
    fn the_distance_across_a_half_turn_is_the_short_way() {
        let (a, b) = (Vec3::Z * (PI - 0.1), -Vec3::Z * (PI - 0.1));
        assert!((geodesic_rad(a, b) - 0.2).abs() < 1e-6);
    }

    #[test]
    fn the_nearest_vector_continues_past_a_half_turn() {
        let next = nearest_axis_angle(-Vec3::Z * (PI - 0.1), Vec3::Z * (PI - 0.1));
        assert!((next - Vec3::Z * (PI + 0.1)).length() < 1e-6, "{next}");
        let identity = nearest_axis_angle(Vec3::ZERO, Vec3::Y * 6.0);
        assert!((identity - Vec3::Y * TAU as f32).length() < 1e-6, "{identity}");
    }

    proptest! {
        #[test]
        fn matrices_are_rotations(v in rotations(10.0)) {
            let r = matrix_from_axis_angle_f64(v.as_dvec3());
            prop_assert!((r * r.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
            prop_assert!((r.determinant() - 1.0).abs() < 1e-12);
        }

        #[test]
        fn the_extraction_is_the_published_one_short_of_a_half_turn(v in rotations(3.1)) {
            let r = matrix_from_axis_angle_f64(v.as_dvec3());
            let ours = axis_angle_from_matrix_f64(r);
            prop_assert!((ours - v.as_dvec3()).length() < 1e-9);
            prop_assert!((ours - published(r)).length() < 1e-6, "{ours} {}", published(r));
        }

        #[test]
        fn the_distance_is_that_of_the_relative_matrix(a in rotations(PI), b in rotations(PI)) {
            let relative = matrix_from_axis_angle(a).transpose() * matrix_from_axis_angle(b);
            let angle = axis_angle_from_matrix(relative).length();
            prop_assert!((geodesic_rad(a, b) - angle).abs() < 1e-3);
            prop_assert!((geodesic_rad(a, b) - geodesic_rad(b, a)).abs() < 1e-6);
        }

        #[test]
        fn equivalent_vectors_are_the_same_rotation(v in rotations(9.0), near in rotations(9.0)) {
            prop_assert!(geodesic_rad(v, canonical_axis_angle(v)) < 1e-5);
            prop_assert!(canonical_axis_angle(v).length() <= PI + 1e-5);
            let moved = nearest_axis_angle(v, near);
            prop_assert!(geodesic_rad(v, moved) < 1e-5);
            prop_assert!(moved.distance(near) <= v.distance(near) + 1e-5);
            prop_assert!(moved.distance(near) <= canonical_axis_angle(v).distance(near) + 1e-5);
        }
    }
}

//! Fisheye lenses: the equidistant model of Kannala and Brandt, as OpenCV's `fisheye` and kalibr have
//! it.
//!
//! A ray at the angle `θ` to the axis is seen at the distance `θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸)`
//! from the principal point, in focal lengths. Rays at a right angle to the axis and beyond have no
//! direction in the plane at distance one.
//!
//! # Source
//! Kannala and Brandt, *A generic camera model and calibration method for conventional, wide-angle,
//! and fish-eye lenses*, 2006; OpenCV's manual, "Fisheye camera model".

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

/// Step of the angle, in radians, below which the inverse has converged.
const MIN_STEP: f64 = 1e-12;

/// Distorts a direction.
pub(super) fn distort(k: [f64; 4], direction: DVec2) -> DVec2 {
    let r = direction.length();
    // The limit on the axis is 1.
    if r == 0.0 { direction } else { direction * (seen(k, r.atan()) / r) }
}

/// Inverse of [`distort`] by Newton's method, after at most `steps` of it; not finite where no
/// direction is seen so far out.
pub(super) fn undistort(k: [f64; 4], distorted: DVec2, steps: u32) -> DVec2 {
    let wanted = distorted.length();
    if wanted == 0.0 {
        return distorted;
    }
    // Without distortion the distance is the angle, which is near enough for Newton.
    let mut angle = wanted.min(FRAC_PI_2);
    for _ in 0..steps {
        let step = (seen(k, angle) - wanted) / slope(k, angle);
        angle -= step;
        if step.abs() <= MIN_STEP || step.is_nan() {
            break;
        }
    }
    // Beyond a right angle the tangent changes its sign, and the ray misses the plane.
    match (0.0..FRAC_PI_2).contains(&angle) {
        true => distorted * (angle.tan() / wanted),
        false => DVec2::NAN,
    }
}

/// Distance from the principal point.
fn seen([k1, k2, k3, k4]: [f64; 4], angle: f64) -> f64 {
    let a2 = angle * angle;
    angle * (1.0 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))))
}

/// Derivative of [`seen`] by the angle.
fn slope([k1, k2, k3, k4]: [f64; 4], angle: f64) -> f64 {
    let a2 = angle * angle;
    1.0 + a2 * (3.0 * k1 + a2 * (5.0 * k2 + a2 * (7.0 * k3 + a2 * 9.0 * k4)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Distortion, LensCamera};

    /// Directions, and where `fisheye.projectPoints` of OpenCV 5.0.0 sees them, whose
    /// `fisheye.undistortPoints` gives the directions back.
    const OPENCV: [([f64; 4], [[f64; 4]; 6]); 2] = [
        (
            [-0.15, 0.05, 0.02, 0.01],
            [
                [0.0, 0.0, 119.5, 89.5],
                [0.1, -0.2, 134.151_878_652_527, 59.805_525_930_879],
                [0.5, 0.3, 184.858_987_897_846, 129.238_264_641_891],
                [-0.9, 0.4, 19.996_427_441_104, 134.313_460_826_525],
                [1.5, -1.2, 240.374_930_858_718, -8.489_277_282_801],
                [3.0, 2.0, 292.760_519_766_524, 206.547_106_686_718],
            ],
        ),
        (
            [0.03, -0.01, 0.004, -0.0007],
            [
                [0.0, 0.0, 119.5, 89.5],
                [0.1, -0.2, 134.278_328_336_536, 59.549_254_571_288],
                [0.5, 0.3, 187.920_681_425_007, 131.099_774_306_404],
                [-0.9, 0.4, 11.258_748_330_727, 138.248_652_603_643],
                [1.5, -1.2, 250.701_868_732_398, -16.860_981_585_731],
                [3.0, 2.0, 287.581_623_121_332, 203.048_474_286_411],
            ],
        ),
    ];

    #[test]
    fn directions_project_to_the_points_of_opencv_and_back() {
        for (k, points) in OPENCV {
            let (focal_px, centre_px) = (DVec2::new(150.0, 152.0), DVec2::new(119.5, 89.5));
            let camera = LensCamera::from_opencv(focal_px, centre_px, Distortion::fisheye(k));
            for [x, y, image_x, image_y] in points {
                let (direction, image_px) = (DVec2::new(x, y), DVec2::new(image_x, image_y) + 0.5);
                let got = camera.image_from_direction(direction);
                assert!((got - image_px).length() < 1e-8, "{got} of {image_px}");
                let ray = camera.direction_from_image(image_px, 50);
                assert!((ray.direction - direction).length() < 1e-8, "{ray:?} of {direction}");
                assert!(ray.error_px < 1e-8, "{ray:?}");
            }
        }
    }

    #[test]
    fn what_no_direction_is_seen_at_has_no_error_in_pixels() {
        let camera = LensCamera::from_opencv(
            DVec2::splat(100.0),
            DVec2::ZERO,
            Distortion::fisheye([0.0; 4]),
        );
        // A right angle is 157 pixels from the axis.
        assert!(camera.direction_from_image(DVec2::new(156.0, 0.5), 50).error_px < 1e-6);
        assert!(camera.direction_from_image(DVec2::new(159.0, 0.5), 50).error_px.is_nan());
    }
}

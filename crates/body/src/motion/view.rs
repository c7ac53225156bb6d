//! Whether the wrist is where the camera sees the hand.
//!
//! # Model
//! Normalised device coordinates: the image spans -1 to 1 along x (right) and y (up). The fingers
//! reach about 0.7 of a half-width beyond the wrist, mostly to the left, so the wrist is kept away
//! from the left edge more than from the right.
//!
//! The released program compares clip coordinates with its bounds without dividing them by w, the
//! distance along the optical axis. Its bounds are then a box in metres, -0.17..0.22 by
//! -0.10..0.12, whatever the distance: near the camera the wrist may lie outside the image, far
//! away it is called back from well inside. Divided by the mean distance of the published motion,
//! 0.48 m, the published bounds are those used here, rounded inwards.
//!
//! # Source
//! EventHands, released simulator; the division is ours.

use evpose_core::{LookAt, Pinhole, SensorSize};
use glam::{Mat4, Vec2, Vec3};

/// Bounds of the published program, in undivided clip coordinates.
const CLIP_LOW: Vec2 = Vec2::new(-0.3, -0.25);
const CLIP_HIGH: Vec2 = Vec2::new(0.4, 0.3);
/// Smallest clip z of the published program, whose planes lie at 0.1 and 10 m.
const CLIP_NEAREST: f32 = 0.1;
const NEAR_M: f32 = 0.1;
const FAR_M: f32 = 10.0;

/// The same as parts of the image.
const VIEW_LOW: Vec2 = Vec2::new(-0.6, -0.5);
const VIEW_HIGH: Vec2 = Vec2::new(0.8, 0.6);
/// Smallest distance along the optical axis: that of [`CLIP_NEAREST`].
const NEAREST_M: f32 = 0.296;

/// The test that calls the arm back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewTest {
    camera_from_world: Mat4,
    /// Clip x and y of a camera-space point, by its x and y.
    clip_scale: Vec2,
    parity: bool,
}

impl ViewTest {
    /// The test for a camera. `parity` leaves clip coordinates undivided, as published.
    pub fn new(look_at: &LookAt, camera: &Pinhole, sensor: SensorSize, parity: bool) -> Self {
        let size = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
        Self {
            camera_from_world: look_at.camera_from_world(),
            clip_scale: 2.0 * camera.focal_px / size,
            parity,
        }
    }

    /// Whether a wrist may be at `wrist_m`, in world coordinates.
    pub fn keeps(&self, wrist_m: Vec3) -> bool {
        self.excess(wrist_m) <= 0.0
    }

    /// By how much a wrist at `wrist_m` breaks the bound it breaks most; negative inside.
    pub fn excess(&self, wrist_m: Vec3) -> f32 {
        let in_camera_m = self.camera_from_world.transform_point3(wrist_m);
        let distance_m = -in_camera_m.z;
        let clip = in_camera_m.truncate() * self.clip_scale;
        let beyond =
            |point: Vec2, low: Vec2, high: Vec2| (low - point).max(point - high).max_element();
        if self.parity {
            let clip_z = (distance_m * (FAR_M + NEAR_M) - 2.0 * FAR_M * NEAR_M) / (FAR_M - NEAR_M);
            beyond(clip, CLIP_LOW, CLIP_HIGH).max(CLIP_NEAREST - clip_z)
        } else {
            // Nearer than allowed, the image says nothing: behind the camera it is upside down.
            let too_near = NEAREST_M - distance_m;
            if too_near > 0.0 {
                return 1.0 + too_near;
            }
            beyond(clip / distance_m, VIEW_LOW, VIEW_HIGH)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(parity: bool) -> ViewTest {
        let look_at = LookAt {
            eye_m: Vec3::new(-0.45, -0.05, 0.4),
            centre_m: Vec3::new(-0.65, -0.05, 0.0),
            up: Vec3::Y,
        };
        let sensor = SensorSize::DAVIS240C;
        ViewTest::new(&look_at, &Pinhole::from_vertical_fov(sensor, 45.0), sensor, parity)
    }

    /// A world point by its place in camera space.
    fn seen_at(x_m: f32, y_m: f32, distance_m: f32) -> Vec3 {
        test(false).camera_from_world.inverse().transform_point3(Vec3::new(x_m, y_m, -distance_m))
    }

    #[test]
    fn both_rules_keep_what_the_camera_looks_at() {
        for parity in [true, false] {
            assert!(test(parity).keeps(Vec3::new(-0.65, -0.05, 0.0)));
        }
    }

    #[test]
    fn both_rules_agree_at_the_mean_distance() {
        let (w, scale) = (0.48, test(true).clip_scale);
        let kept = |parity: bool, clip: Vec2| {
            let in_camera_m = clip / scale;
            test(parity).keeps(seen_at(in_camera_m.x, in_camera_m.y, w))
        };
        for parity in [true, false] {
            for x in [-0.28, 0.0, 0.37] {
                assert!(kept(parity, Vec2::new(x, 0.0)), "{x}");
            }
            for y in [-0.23, 0.28] {
                assert!(kept(parity, Vec2::new(0.0, y)), "{y}");
            }
            for outside in [[-0.31, 0.0], [0.41, 0.0], [0.0, -0.26], [0.0, 0.31]] {
                assert!(!kept(parity, Vec2::from(outside)), "{outside:?}");
            }
        }
    }

    #[test]
    fn the_published_rule_lets_a_near_wrist_leave_the_image() {
        let outside = seen_at(0.21, 0.0, 0.32);
        assert!(test(true).keeps(outside));
        assert!(!test(false).keeps(outside));
    }

    #[test]
    fn neither_rule_keeps_a_wrist_at_the_lens_or_behind() {
        for parity in [true, false] {
            assert!(!test(parity).keeps(seen_at(0.0, 0.0, 0.25)));
            assert!(!test(parity).keeps(seen_at(0.0, 0.0, -0.5)));
        }
    }
}

//! The pinhole camera, the camera with lens distortion, and their pose in the world.

use glam::{Mat4, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::SensorSize;

mod lens;
mod placed;

pub use lens::{Distortion, LensCamera, LensError, ViewingRay};
pub use placed::PlacedCamera;

/// A pinhole camera without distortion. Camera space is OpenGL's: x right, y up, looking along -z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pinhole {
    /// Focal length in pixels, the same along both axes.
    pub focal_px: f32,
    /// Principal point, the intersection of the optical axis with the image, in pixels from the
    /// top-left corner.
    pub principal_px: Vec2,
}

impl Pinhole {
    /// A camera centred on `sensor` with a vertical field of view in degrees.
    ///
    /// Pixel centres lie at half-integers: the image spans `0..width` by `0..height`.
    pub fn from_vertical_fov(sensor: SensorSize, fov_deg: f32) -> Self {
        let (width, height) = (f32::from(sensor.width), f32::from(sensor.height));
        Self {
            focal_px: 0.5 * height / (0.5 * fov_deg.to_radians()).tan(),
            principal_px: Vec2::new(0.5 * width, 0.5 * height),
        }
    }

    /// Image position in pixels (y down) of a point in camera space, in metres.
    ///
    /// Only points in front of the camera (`z < 0`) have one.
    pub fn image_from_camera(&self, point_m: Vec3) -> Option<Vec2> {
        let depth_m = -point_m.z;
        (depth_m > 0.0).then(|| {
            self.principal_px + Vec2::new(point_m.x, -point_m.y) * (self.focal_px / depth_m)
        })
    }
}

/// Pose of a camera by its position and a target, in world metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LookAt {
    /// Position of the camera.
    pub eye_m: Vec3,
    /// Target: a point on the optical axis.
    pub centre_m: Vec3,
    /// Direction that is up in the image.
    pub up: Vec3,
}

impl LookAt {
    /// The rigid transform from world to camera space.
    pub fn camera_from_world(&self) -> Mat4 {
        glam::camera::rh::view::look_at_mat4(self.eye_m, self.centre_m, self.up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// EventHands' view matrix and focal length, as published in its facts.
    #[test]
    fn the_published_camera_has_the_published_matrices() {
        let camera = Pinhole::from_vertical_fov(SensorSize::DAVIS240C, 45.0);
        assert!((camera.focal_px - 217.279).abs() < 1e-3);
        let view = LookAt {
            eye_m: Vec3::new(-0.45, -0.05, 0.4),
            centre_m: Vec3::new(-0.65, -0.05, 0.0),
            up: Vec3::Y,
        }
        .camera_from_world();
        let rows = [
            [0.894_427_2, 0.0, -0.447_213_6, 0.581_377_7],
            [0.0, 1.0, 0.0, 0.05],
            [0.447_213_6, 0.0, 0.894_427_2, -0.156_524_8],
            [0.0, 0.0, 0.0, 1.0],
        ];
        for (i, row) in rows.iter().enumerate() {
            for (j, want) in row.iter().enumerate() {
                assert!((view.col(j)[i] - want).abs() < 1e-6, "({i}, {j})");
            }
        }
    }

    #[test]
    fn the_field_of_view_reaches_from_border_to_border() {
        let sensor = SensorSize { width: 240, height: 180 };
        for degrees in [20.0, 90.0, 120.0f32] {
            let camera = Pinhole::from_vertical_fov(sensor, degrees);
            let half_m = 2.0 * (0.5 * degrees.to_radians()).tan();
            for (x, y) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)] {
                // Four thirds as wide as high; up in the world is a small row.
                let corner_m = Vec3::new(4.0 / 3.0 * x * half_m, y * half_m, -2.0);
                let at = camera.image_from_camera(corner_m).expect("in front");
                let wanted = Vec2::new(120.0 * (1.0 + x), 90.0 * (1.0 - y));
                assert!(at.distance(wanted) < 1e-3, "{at} {wanted}");
            }
        }
        let camera = Pinhole::from_vertical_fov(sensor, 45.0);
        assert_eq!(camera.image_from_camera(Vec3::X), None, "beside the camera");
    }

    #[test]
    fn a_point_on_the_axis_lands_on_the_principal_point() {
        let camera = Pinhole::from_vertical_fov(SensorSize::DAVIS240C, 45.0);
        assert_eq!(
            camera.image_from_camera(Vec3::new(0.0, 0.0, -1.0)),
            Some(Vec2::new(120.0, 90.0))
        );
        assert_eq!(camera.image_from_camera(Vec3::new(0.0, 0.0, 1.0)), None);
    }
}

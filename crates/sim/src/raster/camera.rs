//! The camera as the rasteriser needs it: a projection in pixels and a near plane.

use evpose_core::{LookAt, Pinhole, SensorSize};
use glam::{Mat4, Vec3, Vec4};

/// A pinhole camera somewhere in the world.
///
/// World and camera space are in metres; camera space is OpenGL's (x right, y up, looking along
/// -z); image positions are in pixels from the top-left corner, y down, pixel centres at
/// half-integers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    sensor: SensorSize,
    pinhole: Pinhole,
    camera_from_world: Mat4,
    near_m: f32,
    is_mirrored: bool,
}

impl Camera {
    /// A camera that stands at `placement` and sees nothing nearer than `near_m`.
    pub fn new(sensor: SensorSize, pinhole: Pinhole, placement: &LookAt, near_m: f32) -> Self {
        let camera_from_world = placement.camera_from_world();
        Self { sensor, pinhole, camera_from_world, near_m, is_mirrored: false }
    }

    /// The same camera with left and right exchanged in its image. It sees the faces of a mesh
    /// turned over.
    pub fn mirrored(self) -> Self {
        Self { is_mirrored: !self.is_mirrored, ..self }
    }

    /// The same camera with an image of other rows, and columns in proportion.
    pub fn with_image(self, sensor: SensorSize) -> Self {
        let scale = f32::from(sensor.height) / f32::from(self.sensor.height);
        let Pinhole { focal_px, principal_px } = self.pinhole;
        let pinhole = Pinhole { focal_px: scale * focal_px, principal_px: scale * principal_px };
        Self { sensor, pinhole, ..self }
    }

    /// Size of the image.
    pub fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// The rigid transform from world to camera space.
    pub fn camera_from_world(&self) -> Mat4 {
        self.camera_from_world
    }

    /// Focal length and principal point.
    pub fn pinhole(&self) -> Pinhole {
        self.pinhole
    }

    /// Distance of the near plane in metres.
    pub fn near_m(&self) -> f32 {
        self.near_m
    }

    /// Image position in pixels of a point in the world, if it lies in front of the camera.
    pub fn image_from_world(&self, point_m: Vec3) -> Option<glam::Vec2> {
        let mut in_camera_m = self.camera_from_world.transform_point3(point_m);
        if self.is_mirrored {
            in_camera_m.x = -in_camera_m.x;
        }
        self.pinhole.image_from_camera(in_camera_m)
    }

    /// The homogeneous projection of the world: `(x·d, y·d, unused, d)` with the image position
    /// `(x, y)` in pixels and the depth `d` in metres along the optical axis.
    pub(super) fn homogeneous_image_from_world(&self) -> Mat4 {
        let (focal, principal) = (self.pinhole.focal_px, self.pinhole.principal_px);
        let homogeneous_image_from_camera = Mat4::from_cols(
            Vec4::new(if self.is_mirrored { -focal } else { focal }, 0.0, 0.0, 0.0),
            Vec4::new(0.0, -focal, 0.0, 0.0),
            Vec4::new(-principal.x, -principal.y, 0.0, -1.0),
            Vec4::ZERO,
        );
        homogeneous_image_from_camera * self.camera_from_world
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn published() -> Camera {
        let sensor = SensorSize::DAVIS240C;
        let placement = LookAt {
            eye_m: Vec3::new(-0.45, -0.05, 0.4),
            centre_m: Vec3::new(-0.65, -0.05, 0.0),
            up: Vec3::Y,
        };
        Camera::new(sensor, Pinhole::from_vertical_fov(sensor, 45.0), &placement, 0.1)
    }

    #[test]
    fn the_homogeneous_projection_agrees_with_the_pinhole() {
        let camera = published();
        for point in [Vec3::new(-0.6, 0.02, 0.01), Vec3::new(-0.8, -0.2, -0.1)] {
            let image = camera.image_from_world(point).unwrap();
            let h = camera.homogeneous_image_from_world() * point.extend(1.0);
            assert!((h.truncate().truncate() / h.w - image).length() < 1e-3);
            let mirrored = camera.mirrored().image_from_world(point).unwrap();
            assert!((mirrored.x - (240.0 - image.x)).abs() < 1e-3 && mirrored.y == image.y);
        }
    }
}

//! The view that a network was trained on.

use evpose_core::{Pinhole, SensorSize};
use glam::Vec2;

use crate::Calibration;
use crate::calibration::size_px;

/// Width to which events of larger sensors are pooled for bodies, about that of a DAVIS346.
const BODY_WIDTH_PX: f64 = 346.0;
/// Aspect ratio of the view of bodies.
const BODY_ASPECT: f64 = 4.0 / 3.0;
/// Relative difference of aspect ratios at which no border is added.
const SAME_ASPECT: f64 = 0.02;

/// An image size and a camera without distortion, the same for every sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CanonicalView {
    /// Size of the image.
    pub sensor: SensorSize,
    /// The camera.
    pub pinhole: Pinhole,
}

impl CanonicalView {
    /// The view of a network that expects `sensor` with a vertical field of view in degrees: of hands,
    /// whose distance follows from the focal length.
    pub fn with_vertical_fov(sensor: SensorSize, degrees: f32) -> Self {
        Self { sensor, pinhole: Pinhole::from_vertical_fov(sensor, degrees) }
    }

    /// The view of networks of bodies, which are indifferent to the focal length: the camera's own
    /// view without distortion, with whole numbers of its pixels pooled to about the width of a
    /// DAVIS346, inside a border that makes it 4 to 3.
    pub fn for_bodies(calibration: &Calibration) -> Self {
        let own = size_px(calibration.sensor);
        // At least one: a narrower sensor is not enlarged.
        let pooled = (own.x / BODY_WIDTH_PX).round().max(1.0);
        let inner = (own / pooled).ceil();
        let aspect = inner.x / inner.y;
        let outer = if (aspect / BODY_ASPECT - 1.0).abs() <= SAME_ASPECT {
            inner
        } else if aspect > BODY_ASPECT {
            inner.with_y((inner.x / BODY_ASPECT).ceil())
        } else {
            inner.with_x((inner.y * BODY_ASPECT).ceil())
        };
        // Whole pixels: pooled ones must not straddle those of the sensor.
        let border = (0.5 * (outer - inner)).floor();
        let camera = &calibration.camera;
        // A pinhole view has square pixels, so both axes share a focal length.
        let focal_px = 0.5 * (camera.focal_px.x + camera.focal_px.y) / pooled;
        let principal_px = camera.principal_px / pooled + border;
        Self {
            sensor: SensorSize { width: outer.x as u16, height: outer.y as u16 },
            pinhole: Pinhole {
                focal_px: focal_px as f32,
                principal_px: Vec2::new(principal_px.x as f32, principal_px.y as f32),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(width: u16, height: u16) -> SensorSize {
        CanonicalView::for_bodies(&Calibration::guessed(SensorSize { width, height })).sensor
    }

    #[test]
    fn bodies_are_seen_at_about_the_same_size_in_four_to_three() {
        let size = |width, height| SensorSize { width, height };
        assert_eq!(body(346, 260), size(346, 260));
        assert_eq!(body(320, 240), size(320, 240));
        assert_eq!(body(240, 180), size(240, 180));
        assert_eq!(body(640, 480), size(320, 240));
        assert_eq!(body(1280, 720), size(320, 240));
        assert_eq!(body(128, 128), size(171, 128));
        assert_eq!(body(304, 240), size(320, 240));
    }

    #[test]
    fn whole_pixels_are_pooled_inside_a_border_of_whole_pixels() {
        for ((width, height), pooled, border) in [
            ((346, 260), 1.0, (0.0, 0.0)),
            ((640, 480), 2.0, (0.0, 0.0)),
            ((1280, 720), 4.0, (0.0, 30.0)),
            ((128, 128), 1.0, (21.0, 0.0)),
            ((304, 240), 1.0, (8.0, 0.0)),
        ] {
            let mut camera = Calibration::guessed(SensorSize { width, height });
            camera.camera.focal_px = [300.0, 500.0].into();
            camera.camera.principal_px = [70.0, 50.0].into();
            let pinhole = CanonicalView::for_bodies(&camera).pinhole;
            assert_eq!(pinhole.focal_px, 400.0 / pooled, "{width}x{height}");
            let principal_px = Vec2::new(70.0, 50.0) / pooled + Vec2::from(border);
            assert_eq!(pinhole.principal_px, principal_px, "{width}x{height}");
        }
    }
}

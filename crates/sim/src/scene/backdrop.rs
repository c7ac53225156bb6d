//! The backdrop: a background image behind the hand.

use evpose_core::{Plane, SensorSize};
use glam::{Vec2, Vec3A};
use serde::{Deserialize, Serialize};

use crate::texture::Texture;

/// Mapping of a background image onto the frame.
///
/// # Model
/// The frame at t in [0, 1]², y downwards, shows the background image at
/// `(t - 0.5) / scale + 0.5 + offset`, tiled; the sampled colour is raised to `gamma`, which makes
/// it linear.
///
/// # Source
/// EventHands simulator: scale 1.3, offset uniform in [-0.1, 0.1]², gamma 2.2.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BackdropPlacement {
    /// Size of the background image relative to the frame.
    pub scale: f32,
    /// Shift in widths and heights of the background image.
    pub offset: Vec2,
    /// Exponent of the gamma encoding.
    pub gamma: f32,
}

/// The background as rendered: linear RGB of every pixel, static and unlit.
#[derive(Debug, Clone)]
pub struct Backdrop {
    rgb: Plane<Vec3A>,
}

impl Backdrop {
    /// Samples `image` once for every pixel of `sensor`.
    pub fn new(sensor: SensorSize, image: &Texture, placement: BackdropPlacement) -> Self {
        let size = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
        let mut rgb = Plane::for_sensor(sensor, Vec3A::ZERO);
        for y in 0..rgb.height() {
            for (x, pixel) in rgb.row_mut(y).iter_mut().enumerate() {
                let t = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / size;
                let uv = (t - 0.5) / placement.scale + 0.5 + placement.offset;
                let encoded = image.sample(uv);
                *pixel = Vec3A::from_array(encoded.to_array().map(|c| c.powf(placement.gamma)));
            }
        }
        Self { rgb }
    }

    /// One colour everywhere.
    pub fn uniform(sensor: SensorSize, rgb: Vec3A) -> Self {
        Self { rgb: Plane::for_sensor(sensor, rgb) }
    }

    /// Linear RGB of every pixel.
    pub fn rgb(&self) -> &Plane<Vec3A> {
        &self.rgb
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_image_is_upright_and_linear() {
        // Two rows: bright above, dark below.
        let image = Texture::from_rgb8(1, 2, &[255, 255, 255, 0, 0, 0]).unwrap();
        let sensor = SensorSize { width: 1, height: 2 };
        let placement = BackdropPlacement { scale: 1.0, offset: Vec2::ZERO, gamma: 2.2 };
        let rgb = Backdrop::new(sensor, &image, placement).rgb;
        assert!((rgb.at(0, 0).x - 1.0).abs() < 1e-6);
        assert!(rgb.at(0, 1).x.abs() < 1e-6);
        let half = BackdropPlacement { offset: Vec2::new(0.0, -0.25), ..placement };
        let rgb = Backdrop::new(sensor, &image, half).rgb;
        assert!((rgb.at(0, 1).x - 0.5_f32.powf(2.2)).abs() < 1e-6);
    }
}

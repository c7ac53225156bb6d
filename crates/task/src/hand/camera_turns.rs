//! How far the camera of training windows is turned.

use evpose_core::CounterRng;
use glam::Mat3;
use serde::{Deserialize, Serialize};

/// Largest turns of the camera about its own centre: every training window is seen by a camera that
/// is turned at random within them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraTurnConfig {
    /// About the optical axis, in degrees: 180 for arms from all sides.
    pub roll_deg: f32,
    /// To the side, and up or down, in degrees each.
    pub tilt_deg: f32,
}

impl CameraTurnConfig {
    /// Whether nothing is turned.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// The turn of a sample, in the frame of the camera: a function of `seed` and its number alone.
    pub fn draw(&self, seed: u64, sample: u64) -> Mat3 {
        let mut rng = CounterRng::new(seed, "camera turns", sample);
        let mut angle = |largest_deg: f32| (largest_deg * rng.uniform(-1.0, 1.0)).to_radians();
        let (roll, pan, tilt) = (angle(self.roll_deg), angle(self.tilt_deg), angle(self.tilt_deg));
        // The roll is applied first, where it leaves the optical axis in its place.
        Mat3::from_rotation_x(tilt) * Mat3::from_rotation_y(pan) * Mat3::from_rotation_z(roll)
    }
}

//! How far the camera of training windows is turned.

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
}

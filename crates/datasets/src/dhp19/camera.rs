//! The four cameras around the person.

use evpose_core::SensorSize;

/// Cameras.
pub const CAMERAS: usize = 4;
/// Each camera's sensor.
pub const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };
/// Files of the projections of cameras 0 to 3, which were calibrated in another order.
pub const PROJECTION_FILES: [&str; CAMERAS] = ["P4.npy", "P1.npy", "P3.npy", "P2.npy"];

/// A choice of cameras.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CameraChoice {
    /// All four.
    All,
    /// Those that see the person from the front, at 45 degrees: 2 and 3, as published results are
    /// of.
    #[default]
    Front,
    /// Those at 90 degrees: 0 and 1.
    Side,
}

impl CameraChoice {
    /// Their indices.
    pub fn indices(self) -> &'static [usize] {
        match self {
            Self::All => &[0, 1, 2, 3],
            Self::Front => &[2, 3],
            Self::Side => &[0, 1],
        }
    }
}

//! Settings of velocities from triplets of pixels.

use serde::{Deserialize, Serialize};

use crate::PoseError;

/// What the published program multiplies the velocities of a whole skeleton with.
///
/// An edge tells its motion across itself alone, so that the mean over edges is shorter than the motion
/// of what has them: half of it for edges that lie all ways.
pub const WHOLE_SKELETON_GAIN: f64 = 1.4;

/// The widest region, pixels: as far as any sensor goes.
const LARGEST_RADIUS_PX: u16 = 4096;

/// What is made of the triplets about a joint.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FlowAverage {
    /// The mean, over pixels, of the motion of the edge across itself, fitted to the triplets of the
    /// pixel: exact for straight edges of any direction.
    #[default]
    NormalFlow,
    /// The mean of the velocities of all triplets, each in its own direction: the published program.
    ///
    /// Exact for straight edges along rows, columns and diagonals. One that is slant by little comes past
    /// the pixels along it at great speed, which the mean takes for motion: an edge 3° off the columns
    /// seems more than five times as fast as it is, and almost twice where times are off by 3 % of a step.
    Triplets,
}

/// Settings of [`super::TripletVelocity`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TripletVelocityConfig {
    /// Half the side of the square about a joint that is looked at, pixels: `2 r + 1` of them a side.
    pub radius_px: u16,
    /// By which part the second of two steps in time may differ from the first.
    pub tolerance: f64,
    /// What velocities are multiplied with: 1 for what is measured, [`WHOLE_SKELETON_GAIN`] as
    /// published for skeletons, which goes with [`FlowAverage::Triplets`].
    pub gain: f64,
    /// What is made of the triplets about a joint.
    pub average: FlowAverage,
}

impl TripletVelocityConfig {
    /// What the published program does with a skeleton.
    pub fn parity() -> Self {
        Self { gain: WHOLE_SKELETON_GAIN, average: FlowAverage::Triplets, ..Self::default() }
    }

    /// Refuses what makes no sense.
    pub(super) fn validate(&self) -> Result<(), PoseError> {
        if !(2..=LARGEST_RADIUS_PX).contains(&self.radius_px) {
            let value = f64::from(self.radius_px);
            return Err(PoseError::OutOfRange {
                field: "radius_px",
                value,
                rule: "from 2, a square of 5 pixels, to 4096",
            });
        }
        if !(0.0..1.0).contains(&self.tolerance) {
            let (field, value) = ("tolerance", self.tolerance);
            return Err(PoseError::OutOfRange { field, value, rule: "from 0 to below 1" });
        }
        if !(self.gain > 0.0 && self.gain.is_finite()) {
            let (field, value) = ("gain", self.gain);
            return Err(PoseError::OutOfRange { field, value, rule: "positive and finite" });
        }
        Ok(())
    }
}

impl Default for TripletVelocityConfig {
    fn default() -> Self {
        Self { radius_px: 20, tolerance: 0.15, gain: 1.0, average: FlowAverage::NormalFlow }
    }
}

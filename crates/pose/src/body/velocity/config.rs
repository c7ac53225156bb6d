//! Settings of velocities from triplets of pixels.

use serde::{Deserialize, Serialize};

use crate::PoseError;

/// Published gain of the velocities of a whole skeleton.
///
/// Events of an edge measure only the motion normal to it (the aperture problem), so that the mean
/// over edges is shorter than the motion: half of it for edges of all directions.
pub const WHOLE_SKELETON_GAIN: f64 = 1.4;

/// The widest region, pixels: as far as any sensor goes.
const LARGEST_RADIUS_PX: u16 = 4096;

/// Average of the triplets around a joint.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FlowAverage {
    /// The mean, over pixels, of the motion of the edge across itself, fitted to the triplets of
    /// the pixel: exact for straight edges of any direction.
    #[default]
    NormalFlow,
    /// The mean of the velocities of all triplets, each in its own direction: the published
    /// program.
    ///
    /// Exact for straight edges along rows, columns and diagonals. A slightly slanted one passes
    /// the pixels along it at great speed, which the mean takes for motion: an edge 3° off the
    /// columns seems more than five times as fast as it is, and almost twice where times are off by
    /// 3 % of a step.
    Triplets,
}

/// Settings of [`super::TripletVelocity`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TripletVelocityConfig {
    /// Radius of the square region around a joint, pixels: `2 r + 1` a side.
    pub radius_px: u16,
    /// Largest relative difference of the two time steps of a triplet.
    pub tolerance: f64,
    /// Factor of velocities: 1 for those measured, [`WHOLE_SKELETON_GAIN`] as
    /// published for skeletons, which goes with [`FlowAverage::Triplets`].
    pub gain: f64,
    /// Average of the triplets around a joint.
    pub average: FlowAverage,
}

impl TripletVelocityConfig {
    /// The published program's settings for a skeleton.
    pub fn parity() -> Self {
        Self { gain: WHOLE_SKELETON_GAIN, average: FlowAverage::Triplets, ..Self::default() }
    }

    /// Checks the ranges of all settings.
    pub(super) fn validate(&self) -> Result<(), PoseError> {
        let Self { radius_px, tolerance, gain, .. } = *self;
        PoseError::unless(
            (2..=LARGEST_RADIUS_PX).contains(&radius_px),
            "radius_px",
            radius_px,
            "from 2, a square of 5 pixels, to 4096",
        )?;
        let is_tolerance = (0.0..1.0).contains(&tolerance);
        PoseError::unless(is_tolerance, "tolerance", tolerance, "from 0 to below 1")?;
        PoseError::unless(gain > 0.0 && gain.is_finite(), "gain", gain, "positive and finite")
    }
}

impl Default for TripletVelocityConfig {
    fn default() -> Self {
        Self { radius_px: 20, tolerance: 0.15, gain: 1.0, average: FlowAverage::NormalFlow }
    }
}

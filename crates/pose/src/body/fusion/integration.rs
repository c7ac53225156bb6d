//! Velocities summed up from one detection to the next.

use glam::DVec2;

use super::FusionConfig;
use super::filter::JointFilter;

/// hpe-core's `stateEstimator`: `x += v dt`, and `x = z` at a detection.
#[derive(Debug, Clone, Copy)]
pub(super) struct Integration {
    position_px: DVec2,
}

impl JointFilter for Integration {
    const ALL_CLOCKS_MOVE: bool = true;

    fn start(position_px: DVec2, _: &FusionConfig) -> Self {
        Self { position_px }
    }

    fn advance(&mut self, _: f64, _: &FusionConfig) {}

    fn detect(&mut self, position_px: DVec2, _: &FusionConfig) {
        self.position_px = position_px;
    }

    fn measure_velocity(&mut self, px_per_s: DVec2, dt_s: f64, _: &FusionConfig) {
        self.position_px += px_per_s * dt_s;
    }

    fn position_px(&self, _: f64) -> DVec2 {
        self.position_px
    }
}

//! A shade that passes slowly over everything but the still strip, weaker than a threshold.
//!
//! After an object has passed, light returns to its former value to the last bit, and the ideal
//! pixel's reference level stands exactly one threshold away from it: whether the last event comes
//! would be left to rounding. Under a passing shade no light returns exactly, as under no real sky.
//! Peak to peak it is .18 in `ln I`, so that still ground stays silent.

use super::shape::wave;
use crate::draw::Sequence;

/// Half of the range in `ln I`.
const HALF_RANGE_LN: f64 = 0.09;

#[derive(Debug, Clone)]
pub(super) struct Cloud {
    waves_per_px: [f64; 2],
    turns_hz: f64,
    phase: f64,
}

impl Cloud {
    pub(super) fn new(draws: &mut Sequence) -> Self {
        let period_px = draws.between(50.0, 80.0);
        let angle = draws.between(0.0, std::f64::consts::TAU);
        Self {
            waves_per_px: [angle.cos() / period_px, angle.sin() / period_px],
            turns_hz: draws.between(0.45, 0.8),
            phase: draws.between(0.0, 1.0),
        }
    }

    /// Contribution to `ln I`: never positive.
    pub(super) fn at(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        let place = x_px * self.waves_per_px[0] + y_px * self.waves_per_px[1];
        HALF_RANGE_LN * (wave(place + self.phase - self.turns_hz * t_s) - 1.0)
    }
}

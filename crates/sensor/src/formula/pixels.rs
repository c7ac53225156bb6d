//! Formulas of thresholds and of refractory periods.

use evpose_core::{SensorSize, StageNoise};

use super::Program;
use super::variable::{Patterns, VARIABLES, Variable};
use crate::Traits;
use crate::detector::Recovery;

/// Quantity of a pixel that a formula gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PixelQuantity {
    Threshold,
    Refractory,
}

/// Gives a factor of thresholds, or a refractory period in microseconds.
#[derive(Debug)]
pub struct PixelFormula {
    pub(crate) program: Program,
    pub(crate) quantity: PixelQuantity,
}

/// Least and largest factor of a threshold.
const FACTORS: (f32, f32) = (1e-3, 1e3);

/// Factor of a threshold: beyond the samples a formula may not be finite after all, and then changes
/// nothing.
pub(crate) fn bounded(factor: f32) -> f32 {
    if factor.is_nan() { 1.0 } else { factor.clamp(FACTORS.0, FACTORS.1) }
}

impl PixelFormula {
    pub(crate) fn new(program: Program, quantity: PixelQuantity) -> Self {
        Self { program, quantity }
    }

    /// Whether thresholds are a fixed pattern: nothing in the formula changes.
    pub(crate) fn is_pattern(&self) -> bool {
        let changes = |variable: &Variable| {
            *variable != Variable::Polarity && !Variable::PATTERNS.contains(variable)
        };
        self.quantity == PixelQuantity::Threshold
            && !Variable::ALL.iter().filter(|v| changes(v)).any(|v| self.program.uses(*v))
    }

    pub(crate) fn traits(&self) -> Traits {
        let mut recovery = Recovery::default();
        if self.quantity == PixelQuantity::Refractory {
            // No time at all, so that the array has room for periods.
            recovery.refractory_s = f64::MIN_POSITIVE;
            recovery.follows_s = f64::MIN_POSITIVE;
        }
        let is_pattern = self.is_pattern();
        Traits { is_static: is_pattern, varies: !is_pattern, recovery, ..Traits::default() }
    }

    /// Factors of the ON and the OFF threshold of every pixel that are a fixed pattern.
    pub(crate) fn pattern(&self, size: SensorSize, noise: StageNoise) -> Vec<[f32; 2]> {
        let patterns = Patterns::new(|variable| self.program.uses(variable), size, noise);
        let of_pixel = |pixel| {
            let mut point = [0.0; VARIABLES];
            patterns.set(pixel, &mut point);
            [1.0, -1.0].map(|sign| {
                point[Variable::Polarity as usize] = sign;
                bounded(self.program.value(&point))
            })
        };
        (0..size.pixels()).map(of_pixel).collect()
    }
}

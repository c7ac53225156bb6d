//! Agreement of both halves of a recording on a parameter, and the interval from it.

use crate::recording_mark::RecordingMark;
use crate::search_spec::Searched;

use super::findings::{SceneFreeEffect, SceneFreeParameter};
use super::train::Train;

/// Two-sided 90 % quantile of Student's t with one degree of freedom, for the mean of two halves.
const T90: f64 = 6.314;
/// Largest difference of two halves that agree.
pub(super) struct Agreement {
    /// Relative to their mean.
    pub(super) tolerance: f64,
    /// Absolute, in units of the parameter.
    pub(super) resolution: f64,
}

impl Agreement {
    /// The parameter with its interval; none if the halves do not agree.
    pub(super) fn parameter(
        &self,
        name: &'static str,
        unit: &'static str,
        value: f64,
        [early, late]: [f64; 2],
    ) -> Option<SceneFreeParameter> {
        let apart = (early - late).abs();
        if apart > self.tolerance * 0.5 * (early + late).abs() + 2.0 * self.resolution {
            return None;
        }
        // Two halves are two measurements: Student's t with one degree of freedom.
        let reach = (T90 * 0.5 * apart).max(self.resolution);
        Some(SceneFreeParameter {
            name,
            unit,
            value,
            lo90: (value - reach).max(0.0),
            hi90: value + reach,
            halves: Some([early, late]),
        })
    }
}

/// A parameter that is counted, without uncertainty.
pub(super) fn exact(name: &'static str, unit: &'static str, value: f64) -> SceneFreeParameter {
    SceneFreeParameter { name, unit, value, lo90: value, hi90: value, halves: None }
}

/// The effect that leaves a mark, with its parameters.
pub(super) fn effect(mark: RecordingMark, parameters: Vec<SceneFreeParameter>) -> SceneFreeEffect {
    let spec = mark.effect();
    SceneFreeEffect {
        name: spec.name,
        variant: None,
        parameters,
        p: None,
        confusable_with: spec.search().resembles.to_vec(),
        pixels: Vec::new(),
        test: None,
    }
}

impl SceneFreeEffect {
    pub(super) fn with_pixels(mut self, train: &Train, pixels: &[u32]) -> Self {
        let width = u32::from(train.size.width);
        self.pixels = pixels.iter().map(|p| ((p % width) as u16, (p / width) as u16)).collect();
        self
    }
}

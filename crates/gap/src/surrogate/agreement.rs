//! Parameters that both halves of a recording agree on, with the interval that they give.

use super::findings::{BareEffect, BareParameter};
use super::train::Train;

/// Quantile of Student's t with one degree of freedom, which two halves have, for 90 %.
const T90: f64 = 6.314;
/// How near two halves must be to each other.
pub(super) struct Agreement {
    /// As a part of their mean.
    pub(super) tolerance: f64,
    /// What cannot be told apart in any case.
    pub(super) resolution: f64,
}

impl Agreement {
    /// None if the halves do not agree.
    pub(super) fn parameter(
        &self,
        name: &'static str,
        unit: &'static str,
        value: f64,
        [early, late]: [f64; 2],
    ) -> Option<BareParameter> {
        let apart = (early - late).abs();
        if apart > self.tolerance * 0.5 * (early + late).abs() + 2.0 * self.resolution {
            return None;
        }
        let reach = (T90 * 0.5 * apart).max(self.resolution);
        Some(BareParameter {
            name,
            unit,
            value,
            lo90: (value - reach).max(0.0),
            hi90: value + reach,
            halves: Some([early, late]),
        })
    }
}

/// A number that is counted.
pub(super) fn exact(name: &'static str, unit: &'static str, value: f64) -> BareParameter {
    BareParameter { name, unit, value, lo90: value, hi90: value, halves: None }
}

pub(super) fn effect(
    name: &'static str,
    parameters: Vec<BareParameter>,
    confusable_with: &[&'static str],
) -> BareEffect {
    let confusable_with = confusable_with.to_vec();
    BareEffect { name, variant: None, parameters, p: None, confusable_with, pixels: Vec::new() }
}

impl BareEffect {
    pub(super) fn with_variant(mut self, variant: &'static str) -> Self {
        self.variant = Some(variant);
        self
    }

    pub(super) fn with_pixels(mut self, train: &Train, pixels: &[u32]) -> Self {
        let width = u32::from(train.size.width);
        self.pixels = pixels.iter().map(|p| ((p % width) as u16, (p / width) as u16)).collect();
        self
    }
}

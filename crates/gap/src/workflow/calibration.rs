//! Calibration of probabilities and intervals.
//!
//! # Model
//! The probability that an identification is right is `logistic(intercept + slopes . features)`;
//! the standard deviation of an estimate is `hypot(factor * raw, floor)`, in steps of its
//! parameter. The floor is the difference of two simulators of one camera, which more data does not
//! reduce.
//!
//! # Source
//! `evpose gap calibrate RESULTS.jsonl --plan SEED` fits the constants to cases of benchmark plans
//! drawn for development, never to a plan that results are reported of. These are from 98 cases of
//! plan 9001, in which 40 of 41 identifications were right: one wrong case determines the scale of
//! the odds, and no other slope.

use serde::{Deserialize, Serialize};

/// The constants in use, as printed by `evpose gap calibrate`.
pub const CALIBRATION: Calibration = Calibration {
    intercept: 2.144,
    slopes: [0.323, 0.0, 0.0, 0.0],
    of_effect: ErrorScale { factor: 3.69, floor: 0.0 },
    of_model: ErrorScale { factor: 1.22, floor: 0.05 },
};

/// Descriptions of the features, in their order.
pub const FEATURES: [&str; 4] = [
    "log-odds against rivals and nothing, -2 to 8",
    "fraction of the discrepancy that it explains",
    "ln of the gap that is left, over .42",
    "ln of events, over 50,000",
];

/// Smallest distance of a probability from zero and one: a few hundred cases resolve no more.
const MIN_PROBABILITY: f64 = 0.002;
/// Range that log-odds are clipped to.
const ODDS: (f64, f64) = (-2.0, 8.0);
/// Gap and number of events at which their features are zero.
const GAP: f64 = 0.42;
const EVENTS: f64 = 5e4;

/// Evidence for an identified effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FindingEvidence {
    /// Tempered log-odds against all other contenders and against no effect.
    pub log_odds: f64,
    /// Fraction of the held-out discrepancy that it explains.
    pub gain_share: f64,
    /// Gap of the corrected model on held-out data.
    pub gap_after: f64,
    /// Number of events of the training data.
    pub events: usize,
}

impl FindingEvidence {
    /// Features of the logistic regression, see [`FEATURES`].
    pub fn features(&self) -> [f64; FEATURES.len()] {
        [
            self.log_odds.clamp(ODDS.0, ODDS.1),
            self.gain_share.clamp(0.0, 1.0),
            (self.gap_after / GAP).ln().clamp(-2.0, 3.0),
            (self.events.max(1) as f64 / EVENTS).ln().clamp(-5.0, 3.0),
        ]
    }
}

/// Whether a parameter belongs to an added effect or to the model as given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ParameterOwner {
    /// Parameter of an added effect.
    OfEffect,
    /// Parameter of the model as given: thresholds, background, clock.
    OfModel,
}

/// Calibration of standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorScale {
    /// Factor on raw standard deviations.
    pub factor: f64,
    /// Lower bound, in steps of a parameter, added in quadrature.
    pub floor: f64,
}

impl ErrorScale {
    /// Calibrated standard deviation, in steps.
    pub fn calibrate(&self, raw: f64) -> f64 {
        (self.factor * raw).hypot(self.floor)
    }
}

/// All constants of the calibration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Log-odds where all features are zero.
    pub intercept: f64,
    /// Slope of the log-odds along each feature.
    pub slopes: [f64; FEATURES.len()],
    /// Errors of parameters of effects.
    pub of_effect: ErrorScale,
    /// Errors of parameters of the model.
    pub of_model: ErrorScale,
}

impl Calibration {
    /// Probability that an identification is right.
    pub fn probability(&self, evidence: &FindingEvidence) -> f64 {
        let features = evidence.features();
        let sum: f64 = self.slopes.iter().zip(features).map(|(slope, x)| slope * x).sum();
        let probability = 1.0 / (1.0 + (-self.intercept - sum).exp());
        probability.clamp(MIN_PROBABILITY, 1.0 - MIN_PROBABILITY)
    }

    /// Calibrated standard deviation of an estimate, in steps.
    pub fn error(&self, kind: ParameterOwner, raw: f64) -> f64 {
        match kind {
            ParameterOwner::OfEffect => self.of_effect.calibrate(raw),
            ParameterOwner::OfModel => self.of_model.calibrate(raw),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEUTRAL: Calibration = Calibration {
        intercept: 0.0,
        slopes: [1.0, 0.0, 0.0, 0.0],
        of_effect: ErrorScale { factor: 1.0, floor: 0.0 },
        of_model: ErrorScale { factor: 1.0, floor: 0.0 },
    };

    fn evidence(log_odds: f64) -> FindingEvidence {
        FindingEvidence { log_odds, gain_share: 0.9, gap_after: 0.3, events: 50_000 }
    }

    #[test]
    fn neutral_constants_leave_odds_unchanged() {
        assert!((NEUTRAL.probability(&evidence(0.0)) - 0.5).abs() < 1e-12);
        let three_to_one = NEUTRAL.probability(&evidence(3.0_f64.ln()));
        assert!((three_to_one - 0.75).abs() < 1e-12);
        assert!((NEUTRAL.error(ParameterOwner::OfEffect, 0.7) - 0.7).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_certain() {
        let certain = evidence(1e9);
        let certain_constants = Calibration { intercept: 50.0, ..NEUTRAL };
        assert!((certain_constants.probability(&certain) - (1.0 - MIN_PROBABILITY)).abs() < 1e-12);
        let denied = Calibration { intercept: -50.0, ..NEUTRAL };
        assert!((denied.probability(&certain) - MIN_PROBABILITY).abs() < 1e-12);
    }

    #[test]
    fn errors_are_scaled_and_never_below_their_floor() {
        let scale = ErrorScale { factor: 2.0, floor: 0.3 };
        assert!((scale.calibrate(0.2) - 0.5).abs() < 1e-12);
        assert!((scale.calibrate(0.0) - 0.3).abs() < 1e-12);
        let one = Calibration { of_model: scale, ..NEUTRAL };
        assert!((one.error(ParameterOwner::OfModel, 0.2) - 0.5).abs() < 1e-12);
        assert!((one.error(ParameterOwner::OfEffect, 0.2) - 0.2).abs() < 1e-12);
    }
}

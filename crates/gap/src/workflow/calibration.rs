//! Probabilities and intervals that were fitted to cases whose truth is known.
//!
//! # Model
//! The probability that an identification is right is `logistic(intercept + slopes . features)`;
//! the standard deviation of an estimate is `hypot(factor * raw, floor)`, in steps of its
//! parameter. The floor is the difference of two simulators of one camera, which more data does not
//! reduce.
//!
//! # Source
//! `gapbench calibrate benches/gap --out crates/gap/src/workflow/calibration.json` fits all of it to
//! the opened cases that are stored there, of every tier and with those outside the catalogue.
//! `benches/gap/calibration.md` says how well it holds of cases that a fit has not seen.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

/// The fit in use.
pub static CALIBRATION: LazyLock<Calibration> = LazyLock::new(|| {
    serde_json::from_str(include_str!("calibration.json")).expect("a test reads the file")
});

/// Descriptions of the features, in their order.
pub const FEATURES: [&str; 2] =
    ["log-odds against rivals and nothing, -2 to 8", "ln of the gap that is left, over .42"];

/// Smallest distance of a probability from zero and one: a few hundred cases resolve no more.
const MIN_PROBABILITY: f64 = 0.002;
/// Range that log-odds are clipped to.
const ODDS: (f64, f64) = (-2.0, 8.0);
/// Gap at which its feature is zero.
const GAP: f64 = 0.42;

/// Evidence for an identified effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FindingEvidence {
    /// Tempered log-odds against all other contenders and against no effect.
    pub log_odds: f64,
    /// Gap of the corrected model on held-out data.
    pub gap_after: f64,
}

impl FindingEvidence {
    /// Features of the logistic regression, see [`FEATURES`].
    pub fn features(&self) -> [f64; FEATURES.len()] {
        [self.log_odds.clamp(ODDS.0, ODDS.1), (self.gap_after / GAP).ln().clamp(-2.0, 3.0)]
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

/// Scale of standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorScale {
    /// Factor on raw standard deviations.
    pub factor: f64,
    /// Lower bound, in steps of a parameter, added in quadrature.
    pub floor: f64,
}

impl ErrorScale {
    /// Scaled standard deviation, in steps.
    pub fn calibrate(&self, raw: f64) -> f64 {
        (self.factor * raw).hypot(self.floor)
    }
}

/// All parameters of the fit.
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

    /// Evidence that a probability was stated of, with log-odds inside their range.
    pub fn evidence(&self, probability: f64, gap_after: f64) -> FindingEvidence {
        let at = FindingEvidence { log_odds: 0.0, gap_after };
        let rest = self.intercept + self.slopes[1] * at.features()[1];
        let log_odds = ((probability / (1.0 - probability)).ln() - rest) / self.slopes[0];
        FindingEvidence { log_odds: log_odds.clamp(ODDS.0, ODDS.1), gap_after }
    }

    /// Scaled standard deviation of an estimate, in steps.
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
        slopes: [1.0, 0.0],
        of_effect: ErrorScale { factor: 1.0, floor: 0.0 },
        of_model: ErrorScale { factor: 1.0, floor: 0.0 },
    };

    fn evidence(log_odds: f64) -> FindingEvidence {
        FindingEvidence { log_odds, gap_after: 0.3 }
    }

    #[test]
    fn the_stored_fit_is_read_and_probabilities_lead_back_to_their_evidence() {
        for log_odds in [-1.5, 0.0, 3.0, 8.0] {
            let probability = CALIBRATION.probability(&evidence(log_odds));
            let back = CALIBRATION.evidence(probability, 0.3);
            assert!((back.log_odds - log_odds).abs() < 1e-9 && back.gap_after == 0.3);
        }
        assert!(CALIBRATION.slopes[0] > 0.0 && CALIBRATION.slopes[1] <= 0.0);
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

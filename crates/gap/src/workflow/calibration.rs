//! What makes probabilities and intervals hold what they say.
//!
//! # Model
//! The probability that a name is right is `logistic(intercept + slopes . features)`; the standard
//! deviation of a number is `hypot(factor * raw, floor)`, in steps of its knob. The floor is what two
//! simulators of one thing differ by, however much data there is.
//!
//! # Source
//! The constants are fitted, by `evpose gap calibrate RESULTS.jsonl --plan SEED`, to cases of
//! benchmark plans that were drawn for development, never to those of a plan that results are
//! reported of. These come from 98 cases of plan 9001, in which 40 of 41 names were right: one wrong
//! name tells how far odds are to be believed, and no more than that.

use serde::{Deserialize, Serialize};

/// The constants in use. Paste what `evpose gap calibrate` prints.
pub const CALIBRATION: Calibration = Calibration {
    intercept: 2.144,
    slopes: [0.323, 0.0, 0.0, 0.0],
    of_effect: ErrorScale { factor: 3.69, floor: 0.0 },
    of_model: ErrorScale { factor: 1.22, floor: 0.05 },
};

/// What features are, in their order.
pub const FEATURES: [&str; 4] = [
    "log-odds against rivals and nothing, -2 to 8",
    "share of the misfit that it takes away",
    "ln of the gap that is left, over .42",
    "ln of events, over 50,000",
];

/// No probability is nearer to none or all than this: a few hundred cases say no more.
const LEAST: f64 = 0.002;
/// Odds beyond these say no more.
const ODDS: (f64, f64) = (-2.0, 8.0);
/// Gap and events that features are counted from.
const GAP: f64 = 0.42;
const EVENTS: f64 = 5e4;

/// What the name of an effect rests on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Log-odds against everything that was judged beside it and against adding nothing, tempered.
    pub log_odds: f64,
    /// The share of the misfit that it takes away, on what was held out.
    pub gain_share: f64,
    /// The gap that the whole answer leaves there.
    pub gap_after: f64,
    /// Events of the recording that was fitted.
    pub events: usize,
}

impl Evidence {
    /// The numbers that a probability is made of, see [`FEATURES`].
    pub fn features(&self) -> [f64; FEATURES.len()] {
        [
            self.log_odds.clamp(ODDS.0, ODDS.1),
            self.gain_share.clamp(0.0, 1.0),
            (self.gap_after / GAP).ln().clamp(-2.0, 3.0),
            (self.events.max(1) as f64 / EVENTS).ln().clamp(-5.0, 3.0),
        ]
    }
}

/// Whether a number belongs to an effect that was added or to the model as given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NumberKind {
    /// Of an effect that was added.
    OfEffect,
    /// Of the model as given: thresholds, background, clock.
    OfModel,
}

/// From a raw standard deviation to one that holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorScale {
    /// What raw ones are multiplied by.
    pub factor: f64,
    /// What they are at least, in steps of a knob.
    pub floor: f64,
}

impl ErrorScale {
    /// The standard deviation that holds, in steps.
    pub fn of(&self, raw: f64) -> f64 {
        (self.factor * raw).hypot(self.floor)
    }
}

/// All constants.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Log-odds of a name where all features are zero.
    pub intercept: f64,
    /// What each feature adds to them.
    pub slopes: [f64; FEATURES.len()],
    /// Errors of numbers of effects.
    pub of_effect: ErrorScale,
    /// Errors of numbers of the model.
    pub of_model: ErrorScale,
}

impl Calibration {
    /// The probability that a name is right.
    pub fn probability(&self, evidence: &Evidence) -> f64 {
        let features = evidence.features();
        let sum: f64 = self.slopes.iter().zip(features).map(|(slope, x)| slope * x).sum();
        let probability = 1.0 / (1.0 + (-self.intercept - sum).exp());
        probability.clamp(LEAST, 1.0 - LEAST)
    }

    /// The standard deviation of a number, in steps, from the raw one.
    pub fn error(&self, kind: NumberKind, raw: f64) -> f64 {
        match kind {
            NumberKind::OfEffect => self.of_effect.of(raw),
            NumberKind::OfModel => self.of_model.of(raw),
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

    fn evidence(log_odds: f64) -> Evidence {
        Evidence { log_odds, gain_share: 0.9, gap_after: 0.3, events: 50_000 }
    }

    #[test]
    fn neutral_constants_take_odds_at_their_word() {
        assert!((NEUTRAL.probability(&evidence(0.0)) - 0.5).abs() < 1e-12);
        let three_to_one = NEUTRAL.probability(&evidence(3.0_f64.ln()));
        assert!((three_to_one - 0.75).abs() < 1e-12);
        assert!((NEUTRAL.error(NumberKind::OfEffect, 0.7) - 0.7).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_certain() {
        let certain = evidence(1e9);
        let told = Calibration { intercept: 50.0, ..NEUTRAL };
        assert!((told.probability(&certain) - (1.0 - LEAST)).abs() < 1e-12);
        let denied = Calibration { intercept: -50.0, ..NEUTRAL };
        assert!((denied.probability(&certain) - LEAST).abs() < 1e-12);
    }

    #[test]
    fn errors_are_scaled_and_never_below_their_floor() {
        let scale = ErrorScale { factor: 2.0, floor: 0.3 };
        assert!((scale.of(0.2) - 0.5).abs() < 1e-12);
        assert!((scale.of(0.0) - 0.3).abs() < 1e-12);
        let one = Calibration { of_model: scale, ..NEUTRAL };
        assert!((one.error(NumberKind::OfModel, 0.2) - 0.5).abs() < 1e-12);
        assert!((one.error(NumberKind::OfEffect, 0.2) - 0.2).abs() < 1e-12);
    }
}

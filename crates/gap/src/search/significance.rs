//! Significance of a difference between two models, from replicates on this very scene.
//!
//! # Method
//! Parametric bootstrap of the difference of held-out discrepancies: the recording's is compared
//! with those of runs of the model that would be rejected, which are what the recording would look
//! like if that model were true (Williams 1970; Cox 1962). A recording that no model explains
//! scatters more than runs of a model do: the scatter is scaled by the unexplained variance of the
//! better model, as in quasi-likelihood (McCullagh and Nelder 1989, section 9.2). The level is
//! divided by the number of candidates that were tried (Bonferroni).
//!
//! # Source
//! Williams: *Discrimination between regression models to determine the pattern of enzyme
//! synthesis in synchronous cell cultures*, Biometrics 26, 1970. Cox: *Further results on tests of
//! separate families of hypotheses*, J. R. Stat. Soc. B 24, 1962. Wallace: *Bounds on normal approximations
//! to Student's and the chi-square distributions*, Ann. Math. Stat. 30, 1959.

use evpose_core::stats::distribution::normal_upper_tail;
use evpose_core::stats::moments::mean_and_deviation;
use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use super::identification::SCORE_RUNS;
use crate::compare::{Expectation, discrepancy, rho, rho_of_chance};
use crate::{GapError, Layout, Objective};

/// Replicates of the model that would be rejected.
const REPLICATES: u64 = 8;
/// Degrees of freedom of their deviation.
const DEGREES: usize = REPLICATES as usize - 1;
/// Smallest standard deviation of a difference: few replicates of a model with hardly any noise
/// underestimate it.
const MIN_DEVIATION: f64 = 4.0;

/// A difference of the discrepancies of two models on held-out data.
#[derive(Debug, Clone, Copy)]
pub(super) struct Difference {
    /// Discrepancy of the first minus that of the second: what the second explains more.
    pub(super) gain: f64,
    /// Probability of such a gain if the first model were true.
    pub(super) p: f64,
    /// Losses of the statistics that the second model explains worse, beyond those by chance if it
    /// were true, as a fraction of the decreases of those that it explains better; zero where that
    /// was not asked for.
    pub(super) worsened: f64,
}

impl Difference {
    /// Whether the first model is rejected at `level`, one of `candidates` having been chosen as
    /// the second.
    pub(super) fn is_significant(&self, level: f64, candidates: usize) -> bool {
        self.gain > 0.0 && self.p * candidates.max(1) as f64 <= level
    }
}

/// Compares two models on the data of an objective.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn difference(
    objective: &Objective<'_>,
    first: &SensorConfig,
    second: &SensorConfig,
) -> Result<Difference, GapError> {
    let expected = [objective.expect(first, SCORE_RUNS)?, objective.expect(second, SCORE_RUNS)?];
    let layout = objective.layout;
    let of = |expected: &Expectation, summary: &[f64]| {
        discrepancy(&expected.deviations(layout, summary))
    };
    let gain_of = |summary: &[f64]| of(&expected[0], summary) - of(&expected[1], summary);
    let (mean, deviation) = of_replicates(objective, first, gain_of)?;
    let deviation = deviation.max(MIN_DEVIATION);
    let gain = gain_of(&objective.measured);
    let compared = expected[1].mean.iter().filter(|mean| mean.is_finite()).count().max(1) as f64;
    let left = of(&expected[1], &objective.measured) / (compared * rho_of_chance());
    // A model that fits badly deviates by more than its own runs do.
    let z = (gain - mean) / (deviation * left.max(1.0));
    // Tails of few replicates are wider than normal ones: Student's t would be exact for them.
    Ok(Difference { gain, p: student_upper_tail(z, DEGREES), worsened: 0.0 })
}

/// As [`difference`], with what the second model explains worse.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn difference_with_losses(
    objective: &Objective<'_>,
    first: &SensorConfig,
    second: &SensorConfig,
) -> Result<Difference, GapError> {
    // Also under the second model some losses rise by chance: its own runs say by how much.
    let difference = difference(objective, first, second)?;
    let expected = [objective.expect(first, SCORE_RUNS)?, objective.expect(second, SCORE_RUNS)?];
    let increase_of = |summary: &[f64]| increase(objective.layout, &expected, summary);
    let (by_chance, _) = of_replicates(objective, second, increase_of)?;
    let increase = increase_of(&objective.measured);
    let decrease = (difference.gain + increase).max(1e-9);
    Ok(Difference { worsened: (increase - by_chance).max(0.0) / decrease, ..difference })
}

/// Mean and deviation of a value over the summaries of runs of a model.
fn of_replicates(
    objective: &Objective<'_>,
    model: &SensorConfig,
    value: impl Fn(&[f64]) -> f64 + Sync,
) -> Result<(f64, f64), GapError> {
    // Further runs: the first ones are those of the expectations.
    let values = (SCORE_RUNS..SCORE_RUNS + REPLICATES)
        .into_par_iter()
        .map(|run| Ok(value(&objective.run(model, run)?)))
        .collect::<Result<Vec<f64>, GapError>>()?;
    Ok(mean_and_deviation(&values))
}

/// Sum of the losses of a summary that are larger by the second expectation than by the first.
fn increase(layout: &Layout, expected: &[Expectation; 2], summary: &[f64]) -> f64 {
    let losses = |expected: &Expectation| -> Vec<f64> {
        expected.deviations(layout, summary).iter().map(|z| rho(z * z)).collect()
    };
    let pairs = losses(&expected[0]).into_iter().zip(losses(&expected[1]));
    pairs.map(|(first, second)| (second - first).max(0.0)).sum()
}

/// Discrepancy that a model leaves beyond that of its own runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unexplained {
    /// Mean discrepancy of runs of the model.
    pub chance: f64,
    /// Probability that a run of the model has a discrepancy as large as the recording's.
    pub p: f64,
}

/// Compares the discrepancy of the recording with that of runs of a model (a posterior predictive
/// check at the fitted parameters).
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn unexplained(
    objective: &Objective<'_>,
    model: &SensorConfig,
) -> Result<Unexplained, GapError> {
    let expected = objective.expect(model, SCORE_RUNS)?;
    let of = |summary: &[f64]| discrepancy(&expected.deviations(objective.layout, summary));
    let (chance, deviation) = of_replicates(objective, model, of)?;
    let z = (of(&objective.measured) - chance) / deviation.max(MIN_DEVIATION);
    Ok(Unexplained { chance, p: student_upper_tail(z, DEGREES) })
}

/// Probability that a variable with Student's t distribution exceeds `t` (Wallace 1959).
pub(crate) fn student_upper_tail(t: f64, degrees: usize) -> f64 {
    let n = degrees as f64;
    let size = (n * (t * t / n).ln_1p()).sqrt() * (8.0 * n + 1.0) / (8.0 * n + 3.0);
    normal_upper_tail(size.copysign(t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_of_few_replicates_are_those_of_students_t() {
        // t = 3.499 is exceeded with a probability of 0.005 at seven degrees of freedom.
        for (t, p) in [(1.895, 0.05), (2.998, 0.01), (3.499, 0.005)] {
            let tail = student_upper_tail(t, 7);
            assert!((tail / p - 1.0).abs() < 0.06, "{t}: {tail}");
        }
    }

    #[test]
    fn the_level_is_divided_by_the_candidates() {
        let found = Difference { gain: 50.0, p: 0.004, worsened: 0.0 };
        assert!(found.is_significant(0.05, 10) && !found.is_significant(0.05, 20));
        assert!(!Difference { gain: -1.0, p: 0.0, worsened: 1.0 }.is_significant(0.05, 1));
    }
}

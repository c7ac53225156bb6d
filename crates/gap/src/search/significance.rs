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
/// Fraction of the distance to the gain of one model within which a gain is that of another.
const NEARER: f64 = 0.5;

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

/// Expectations of two models.
struct Pair<'a> {
    layout: &'a Layout,
    expected: [Expectation; 2],
}

impl<'a> Pair<'a> {
    fn new(
        objective: &Objective<'a>,
        first: &SensorConfig,
        second: &SensorConfig,
    ) -> Result<Self, GapError> {
        let expected =
            [objective.expect(first, SCORE_RUNS)?, objective.expect(second, SCORE_RUNS)?];
        Ok(Self { layout: objective.layout, expected })
    }

    fn discrepancies(&self, summary: &[f64]) -> [f64; 2] {
        let of = |expected: &Expectation| discrepancy(&expected.deviations(self.layout, summary));
        [of(&self.expected[0]), of(&self.expected[1])]
    }

    /// Discrepancy of the first less that of the second.
    fn gain(&self, summary: &[f64]) -> f64 {
        let [first, second] = self.discrepancies(summary);
        first - second
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
    let pair = Pair::new(objective, first, second)?;
    let (mean, deviation) = of_replicates(objective, first, |summary| pair.gain(summary))?;
    let deviation = deviation.max(MIN_DEVIATION);
    let gain = pair.gain(&objective.measured);
    let means = &pair.expected[1].mean;
    let compared = means.iter().filter(|mean| mean.is_finite()).count().max(1) as f64;
    let left = pair.discrepancies(&objective.measured)[1] / (compared * rho_of_chance());
    // A model that fits badly deviates by more than its own runs do.
    let z = (gain - mean) / (deviation * left.max(1.0));
    // Tails of few replicates are wider than normal ones: Student's t would be exact for them.
    Ok(Difference { gain, p: student_upper_tail(z, DEGREES), worsened: 0.0 })
}

/// Whether the data distinguish two models, in favour of the second: the first is rejected at `level`, and the gain
/// is nearer to that of runs of the second model than to that of runs of the first. Beside an incomplete model both
/// may be rejected (Cox 1962), which is no evidence for either.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn is_distinguished(
    objective: &Objective<'_>,
    first: &SensorConfig,
    second: &SensorConfig,
    level: f64,
) -> Result<bool, GapError> {
    let difference = difference(objective, first, second)?;
    if !difference.is_significant(level, 1) {
        return Ok(false);
    }
    let pair = Pair::new(objective, first, second)?;
    let (of_first, _) = of_replicates(objective, first, |summary| pair.gain(summary))?;
    let (of_second, _) = of_replicates(objective, second, |summary| pair.gain(summary))?;
    Ok((of_second - difference.gain).abs() < NEARER * (difference.gain - of_first).abs())
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
    let pair = Pair::new(objective, first, second)?;
    let increase_of = |summary: &[f64]| increase(objective.layout, &pair.expected, summary);
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
    use evpose_core::Plane;
    use evpose_sensor::EffectConfig;

    use super::*;
    use crate::workflow::ComparisonCase;
    use crate::{LightSequence, ReferenceScene};

    fn with_thresholds(value: f64) -> SensorConfig {
        let effects = vec![
            EffectConfig::new("logarithmic").with("dark_offset", 1e-3),
            EffectConfig::new("level_crossing")
                .with("threshold_on", value)
                .with("threshold_off", value),
        ];
        SensorConfig { effects }
    }

    /// Whether thresholds of .2 and .3 are distinguished, either way, in a recording with thresholds of `truth`.
    fn are_distinguished(truth: f64) -> [bool; 2] {
        let light = |k: usize, i: usize| {
            0.3 + 0.2 * (((i % 24) as f32 - 0.05 * k as f32) * 0.8 + (i / 24) as f32).sin()
        };
        let plane = |k| (0..24 * 18).map(|i| light(k, i)).collect();
        let planes = (0..400).map(|k| Plane::from_vec(24, 18, plane(k)).unwrap());
        let scene = LightSequence::new(1_000.0, planes.collect()).unwrap();
        let models = [0.2, 0.3].map(with_thresholds);
        let reference = ReferenceScene::new(scene.clone(), &models[0]).unwrap();
        let events = reference.simulate(&with_thresholds(truth), 7).unwrap();
        let ComparisonCase { measured, window, .. } = ComparisonCase::new(&events, scene).unwrap();
        let layout = Layout::of_all_probes();
        let objective =
            Objective::new(&reference, &layout, &measured, window, &models[0], 1).unwrap();
        let [first, second] = &models;
        [(first, second), (second, first)]
            .map(|(a, b)| is_distinguished(&objective, a, b, 0.05).unwrap())
    }

    #[test]
    fn between_two_wrong_models_nothing_is_distinguished() {
        assert_eq!(are_distinguished(0.3), [true, false]);
        assert_eq!(are_distinguished(0.2), [false, true]);
        assert_eq!(are_distinguished(0.246), [false, false]);
    }

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

//! p-value of the largest deviation over all statistics.
//!
//! # Method
//! Parametric bootstrap of the maximum, so that there is one p-value however many statistics there
//! are: the recording and replicates of the model are compared with the expectation from other
//! runs. Where the largest deviations are equal, as those of statistics that are undefined on one
//! side, the next largest decide: ties would make p-values too large. A model without noise has no
//! replicates: then deviations are taken to be normal, with the scatter under weak noise.

use evpose_core::stats::distribution::normal_upper_tail;
use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use crate::{GapError, Objective};

const EXPECTED_RUNS: u64 = 8;

/// Probability that a run of `model` deviates from it as much in some statistic as the recording of
/// `objective`, from replicates; at least one in `replicates + 1`.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn p_of_largest_deviation(
    objective: &Objective<'_>,
    model: &SensorConfig,
    replicates: u64,
) -> Result<f64, GapError> {
    let expected = objective.expect(model, EXPECTED_RUNS)?;
    let ranked = |summary: &[f64]| largest_first(expected.deviations(objective.layout, summary));
    let measured = ranked(&objective.measured);
    let (first, second) = (objective.run(model, 0)?, objective.run(model, 1)?);
    // A model without noise has one run: replicates would say p = 1 / (n + 1) of anything else.
    if first.iter().zip(&*second).all(|(a, b)| a.to_bits() == b.to_bits()) {
        let statistics = expected.mean.iter().filter(|mean| mean.is_finite()).count();
        return Ok(p_of_normal(measured.first().copied().unwrap_or(0.0), statistics));
    }
    let as_large = (EXPECTED_RUNS..EXPECTED_RUNS + replicates)
        .into_par_iter()
        .map(|run| Ok(usize::from(ranked(&objective.run(model, run)?) >= measured)))
        .collect::<Result<Vec<_>, GapError>>()?;
    Ok((1 + as_large.iter().sum::<usize>()) as f64 / (replicates + 1) as f64)
}

/// Sizes of deviations in descending order, for lexicographic comparison.
fn largest_first(mut deviations: Vec<f64>) -> Vec<f64> {
    deviations.iter_mut().for_each(|z| *z = z.abs());
    deviations.sort_by(|a, b| b.total_cmp(a));
    deviations
}

/// p-value of the largest of `count` independent normal deviations.
fn p_of_normal(largest: f64, count: usize) -> f64 {
    // The approximation of the tail slightly exceeds one half at zero.
    let one = (2.0 * normal_upper_tail(largest)).min(1.0);
    // 1 - (1 - one)^count, without cancellation.
    -(count as f64 * (-one).ln_1p()).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_largest_decides_where_the_largest_are_equal() {
        let far = largest_first(vec![1.0, -3.0, 2.0]);
        assert_eq!(far, [3.0, 2.0, 1.0]);
        assert!(far > largest_first(vec![3.0, -1.0, 1.5]));
        assert!(far < largest_first(vec![0.0, 0.0, 3.1]));
        assert!(far >= largest_first(vec![2.0, 3.0, -1.0]));
    }

    #[test]
    fn one_normal_deviation_has_the_tails_of_the_tables() {
        for (z, p) in [(1.0, 0.317_311), (1.959_964, 0.05), (3.290_527, 0.001)] {
            assert!((p_of_normal(z, 1) / p - 1.0).abs() < 1e-4, "{z}");
        }
        assert!((p_of_normal(1.959_964, 2) - 0.0975).abs() < 1e-5);
        assert!((p_of_normal(0.0, 5) - 1.0).abs() < 1e-6);
    }
}

//! How probable the largest deviation of all is by chance.
//!
//! # Method
//! Maximum over all numbers, so that there is one probability however many there are: the recording
//! and replicates of the model are compared with what other runs of the model give. Where the
//! largest are equal, as those of numbers that only one side has, the next largest decide: replicates
//! that count as being as far off without being so would make probabilities too large. A model
//! without noise has no replicates: then numbers are taken to scatter as they do under a weak noise.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use crate::normal::upper_tail;
use crate::{GapError, Lab};

/// Runs that the recording and its replicates are compared with.
const EXPECTED: u64 = 8;

/// The probability that a run of `model` is as far from it in some number as the recording of `lab`
/// is, from so many replicates: at least one in `replicates + 1`.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn chance_of_largest(
    lab: &Lab<'_>,
    model: &SensorConfig,
    replicates: u64,
) -> Result<f64, GapError> {
    let expected = lab.expect(model, EXPECTED)?;
    let ranked = |summary: &[f64]| largest_first(expected.deviations(lab.layout, summary));
    let found = ranked(&lab.measured);
    let (first, second) = (lab.run(model, 0)?, lab.run(model, 1)?);
    if first.iter().zip(&*second).all(|(a, b)| a.to_bits() == b.to_bits()) {
        let numbers = expected.mean.iter().filter(|mean| mean.is_finite()).count();
        return Ok(of_normal(found.first().copied().unwrap_or(0.0), numbers));
    }
    let as_large = (EXPECTED..EXPECTED + replicates)
        .into_par_iter()
        .map(|run| Ok(usize::from(ranked(&lab.run(model, run)?) >= found)))
        .collect::<Result<Vec<_>, GapError>>()?;
    Ok((1 + as_large.iter().sum::<usize>()) as f64 / (replicates + 1) as f64)
}

/// Sizes of deviations; lists of them are compared from their first on.
fn largest_first(mut deviations: Vec<f64>) -> Vec<f64> {
    deviations.iter_mut().for_each(|z| *z = z.abs());
    deviations.sort_by(|a, b| b.total_cmp(a));
    deviations
}

/// Of the largest of so many independent normal deviations.
fn of_normal(largest: f64, numbers: usize) -> f64 {
    // The approximation is a little off at zero.
    let one = (2.0 * upper_tail(largest)).min(1.0);
    // 1 - (1 - one)^numbers, without loss where it is small.
    -(numbers as f64 * (-one).ln_1p()).exp_m1()
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
            assert!((of_normal(z, 1) / p - 1.0).abs() < 1e-4, "{z}");
        }
        assert!((of_normal(1.959_964, 2) - 0.0975).abs() < 1e-5);
        assert!((of_normal(0.0, 5) - 1.0).abs() < 1e-6);
    }
}

//! Gaps with bootstrap intervals.
//!
//! # Method
//! Percentile bootstrap: the runs by which a model is scored are resampled with replacement, and so
//! are the blocks of statistics that a gap is the mean of.

use evpose_core::CounterRng;
use evpose_core::stats::quantile::nearest_index;
use evpose_sensor::SensorConfig;

use crate::compare::{by_block, rho_of_chance};
use crate::verdict::GapValue;
use crate::{GapError, Objective, gap};

/// Runs by which a model is scored, as many as in the search.
pub(super) const RUNS: u64 = 4;
const RESAMPLES: u64 = 200;

/// Gap of a model with its 90 % interval.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn gap_value(
    objective: &Objective<'_>,
    model: &SensorConfig,
    seed: u64,
) -> Result<GapValue, GapError> {
    let value = gap(objective.layout, &deviations(objective, model)?);
    let chance = rho_of_chance();
    let mut gaps: Vec<f64> = resampled(objective, model, seed, RESAMPLES)?
        .iter()
        .enumerate()
        .map(|(i, deviations)| {
            let blocks = by_block(objective.layout, deviations);
            // Blocks are drawn as well as runs: the mean over blocks depends on which there are.
            let mut rng = CounterRng::new(seed, "blocks of a gap", i as u64);
            let drawn = (0..blocks.len()).map(|_| blocks[rng.below(blocks.len())].1);
            drawn.sum::<f64>() / blocks.len() as f64 / chance
        })
        .collect();
    gaps.sort_by(f64::total_cmp);
    let at = |share: f64| gaps[nearest_index(gaps.len(), share)];
    Ok(GapValue { value, lo: at(0.05).min(value), hi: at(0.95).max(value) })
}

pub(super) fn deviations(
    objective: &Objective<'_>,
    model: &SensorConfig,
) -> Result<Vec<f64>, GapError> {
    Ok(objective.expect(model, RUNS)?.deviations(objective.layout, &objective.measured))
}

/// Deviations of the recording from resampled runs of a model.
pub(super) fn resampled(
    objective: &Objective<'_>,
    model: &SensorConfig,
    seed: u64,
    resamples: u64,
) -> Result<Vec<Vec<f64>>, GapError> {
    let expected = objective.expect(model, RUNS)?;
    let runs = (0..RUNS).map(|run| objective.run(model, run)).collect::<Result<Vec<_>, _>>()?;
    Ok((0..resamples)
        // A bootstrap: means of as many runs, drawn with replacement, scatter as their mean does.
        .map(|i| {
            let mut rng = CounterRng::new(seed, "runs of a gap", i);
            let drawn: Vec<usize> = runs.iter().map(|_| rng.below(runs.len())).collect();
            let mut resample = expected.clone();
            for (k, mean) in resample.mean.iter_mut().enumerate() {
                *mean = drawn.iter().map(|run| runs[*run][k]).sum::<f64>() / drawn.len() as f64;
            }
            resample.deviations(objective.layout, &objective.measured)
        })
        .collect())
}

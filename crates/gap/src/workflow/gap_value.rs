//! Gaps with intervals.
//!
//! # Method
//! Bootstrap: the runs that a model is judged by are drawn again with replacement, and so are the
//! blocks of numbers that a gap is the mean of. The interval holds nine tenths of the gaps of
//! resamples.

use evpose_core::CounterRng;
use evpose_sensor::SensorConfig;

use crate::compare::{by_block, rho_of_chance};
use crate::verdict::GapValue;
use crate::{GapError, Lab, gap};

/// Runs that a model is judged by: as many as naming takes.
pub(super) const RUNS: u64 = 4;
/// Resamples.
const RESAMPLES: u64 = 200;

/// The gap of a model in a lab with its interval of 90 %.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn gap_value(lab: &Lab<'_>, model: &SensorConfig, seed: u64) -> Result<GapValue, GapError> {
    let value = gap(lab.layout, &deviations(lab, model)?);
    let chance = rho_of_chance();
    let mut gaps: Vec<f64> = resampled(lab, model, seed, RESAMPLES)?
        .iter()
        .enumerate()
        .map(|(i, deviations)| {
            let blocks = by_block(lab.layout, deviations);
            let mut rng = CounterRng::new(seed, "blocks of a gap", i as u64);
            let drawn = (0..blocks.len()).map(|_| blocks[rng.below(blocks.len())].1);
            drawn.sum::<f64>() / blocks.len() as f64 / chance
        })
        .collect();
    gaps.sort_by(f64::total_cmp);
    let at = |share: f64| gaps[(share * (gaps.len() - 1) as f64).round() as usize];
    Ok(GapValue { value, lo: at(0.05).min(value), hi: at(0.95).max(value) })
}

/// Deviations of the recording of a lab from a model.
pub(super) fn deviations(lab: &Lab<'_>, model: &SensorConfig) -> Result<Vec<f64>, GapError> {
    Ok(lab.expect(model, RUNS)?.deviations(lab.layout, &lab.measured))
}

/// The same for resamples of the runs of the model.
pub(super) fn resampled(
    lab: &Lab<'_>,
    model: &SensorConfig,
    seed: u64,
    resamples: u64,
) -> Result<Vec<Vec<f64>>, GapError> {
    let expected = lab.expect(model, RUNS)?;
    let runs = (0..RUNS).map(|run| lab.run(model, run)).collect::<Result<Vec<_>, _>>()?;
    Ok((0..resamples)
        .map(|i| {
            let mut rng = CounterRng::new(seed, "runs of a gap", i);
            let drawn: Vec<usize> = runs.iter().map(|_| rng.below(runs.len())).collect();
            let mut resample = expected.clone();
            for (k, mean) in resample.mean.iter_mut().enumerate() {
                *mean = drawn.iter().map(|run| runs[*run][k]).sum::<f64>() / drawn.len() as f64;
            }
            resample.deviations(lab.layout, &lab.measured)
        })
        .collect())
}

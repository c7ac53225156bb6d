//! Two summaries against each other: how far apart, in units of what chance and tolerance allow.

use crate::summary::{Block, Kind, Layout};

/// Degrees of freedom of the robust distance: a number that is far off counts, but does not decide
/// alone.
const NU: f64 = 4.0;
/// What a number is worth that only one of two summaries has.
const MISSING: f64 = 3.0;
/// What every number is worth of a model that has far too many events.
const HOPELESS: f64 = 100.0;
/// Variance of a count on its scale that nothing goes below: two simulators that agree on the
/// physics still round edges differently.
const COUNT_VARIANCE: f64 = 0.25;

/// Robust measure of a squared deviation.
pub fn rho(z2: f64) -> f64 {
    NU * (z2 / NU).ln_1p()
}

/// The mean of [`rho`] over a standard normal deviation: what chance alone gives.
pub fn rho_of_chance() -> f64 {
    let step = 0.01;
    let density = |z: f64| (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
    (-800..=800).map(|i| f64::from(i) * step).map(|z| rho(z * z) * density(z) * step).sum()
}

/// What a model expects of a summary.
#[derive(Debug, Clone)]
pub struct Expectation {
    /// The mean of every number, NaN where there is none.
    pub mean: Vec<f64>,
    /// Its variance from run to run, without tolerance.
    pub variance: Vec<f64>,
    /// Events in all.
    events: f64,
}

impl Expectation {
    /// Mean and variance of runs with different seeds.
    ///
    /// A number varies at least by `least`: few runs do not tell, and a model without noise is no
    /// reason to take chance in the recording for a difference.
    pub fn of_runs(layout: &Layout, runs: &[Vec<f64>], least: &[f64]) -> Self {
        let n = runs.len() as f64;
        let mut mean = vec![0.0; layout.entries.len()];
        let mut variance = vec![0.0; layout.entries.len()];
        for i in 0..mean.len() {
            let values = || runs.iter().map(|run| run[i]);
            mean[i] = values().sum::<f64>() / n;
            if runs.len() > 1 {
                let spread: f64 = values().map(|v| (v - mean[i]).powi(2)).sum();
                // The mean of few runs is itself uncertain.
                variance[i] = spread / (n - 1.0) * (1.0 + 1.0 / n);
            }
            variance[i] = variance[i].max(least.get(i).copied().unwrap_or(0.0));
        }
        let events = layout.events(&mean);
        Self { mean, variance, events }
    }

    /// How far a summary is from this, number by number, in standard deviations.
    pub fn deviations(&self, layout: &Layout, summary: &[f64]) -> Vec<f64> {
        (0..self.mean.len()).map(|i| self.deviation(layout, i, summary[i]).unwrap_or(0.0)).collect()
    }

    /// The deviation of one number; none where neither side has it.
    fn deviation(&self, layout: &Layout, i: usize, value: f64) -> Option<f64> {
        let mean = self.mean[i];
        if !layout.entries[i].is_compared() {
            return None;
        }
        if mean.is_infinite() {
            return Some(HOPELESS);
        }
        match (mean.is_nan(), value.is_nan()) {
            (true, true) => None,
            (false, false) => Some((value - mean) / self.scale(layout, i)),
            _ => Some(MISSING),
        }
    }

    /// Standard deviation of a number with tolerance.
    pub fn scale(&self, layout: &Layout, i: usize) -> f64 {
        if !self.mean[i].is_finite() || !layout.entries[i].is_compared() {
            return 1.0;
        }
        let floor = match layout.entries[i].kind {
            Kind::Count(_) => COUNT_VARIANCE,
            Kind::Number(_) => 0.0,
        };
        let tolerance = layout.tolerance(i, self.mean[i], self.events);
        (self.variance[i].max(floor) + tolerance * tolerance).sqrt()
    }
}

/// Mean robust distance of each block that has numbers.
pub fn by_block(layout: &Layout, deviations: &[f64]) -> Vec<(Block, f64)> {
    let mut sums: std::collections::BTreeMap<Block, (f64, f64)> = std::collections::BTreeMap::new();
    for (entry, z) in layout.entries.iter().zip(deviations) {
        if !entry.is_compared() {
            continue;
        }
        let (sum, count) = sums.entry(entry.block).or_default();
        *sum += rho(z * z);
        *count += 1.0;
    }
    sums.into_iter().map(|(block, (sum, count))| (block, sum / count)).collect()
}

/// The gap: the mean distance of blocks over that of chance. One cannot be told from a fresh run of
/// the model.
pub fn gap(layout: &Layout, deviations: &[f64]) -> f64 {
    let blocks = by_block(layout, deviations);
    let sum: f64 = blocks.iter().map(|(_, distance)| distance).sum();
    sum / blocks.len() as f64 / rho_of_chance()
}

/// The distance that fits make small: all numbers together.
pub fn misfit(deviations: &[f64]) -> f64 {
    deviations.iter().map(|z| rho(z * z)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However far off they are.
    #[test]
    fn numbers_of_blocks_that_are_left_out_count_for_nothing() {
        let all = Layout::of_all_probes();
        let some = Layout::of_blocks(|block| block != Block::Swing);
        let mean = vec![100.0; all.entries.len()];
        let expected = Expectation::of_runs(&all, &[mean.clone(), mean.clone()], &[]);
        let mut summary = mean;
        for (value, entry) in summary.iter_mut().zip(&all.entries) {
            *value = if entry.block == Block::Swing { f64::NAN } else { *value };
        }
        let of = |layout: &Layout| expected.deviations(layout, &summary);
        assert!(gap(&all, &of(&all)) > 0.1);
        assert_eq!((gap(&some, &of(&some)), misfit(&of(&some))), (0.0, 0.0));
        assert!(by_block(&some, &of(&some)).iter().all(|(block, _)| *block != Block::Swing));
    }
}

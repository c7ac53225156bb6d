//! Comparison of summaries: deviations in standard units, the discrepancy statistic and the gap.

use crate::entry::{StatisticBlock, StatisticKind};
use crate::layout::Layout;

/// Degrees of freedom of the Student t distribution whose log-likelihood [`rho`] is: an outlying
/// statistic counts, but does not decide alone.
pub(crate) const RHO_FREEDOM: f64 = 4.0;
/// Deviation of a statistic that is defined on one side only.
const MISSING: f64 = 3.0;
/// Deviation of all statistics of a model with far too many events.
const HOPELESS: f64 = 100.0;
/// Minimum variance of a transformed count: two simulators of the same physics still round the
/// edges of bins differently.
const COUNT_VARIANCE: f64 = 0.25;

/// Robust loss of a squared deviation: twice the negative log-likelihood of a Student t
/// distribution, up to a factor.
pub fn rho(z2: f64) -> f64 {
    RHO_FREEDOM * (z2 / RHO_FREEDOM).ln_1p()
}

/// Mean of [`rho`] over a standard normal deviation, which is its value by chance.
pub fn rho_of_chance() -> f64 {
    let step = 0.01;
    let density = |z: f64| (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
    (-800..=800).map(|i| f64::from(i) * step).map(|z| rho(z * z) * density(z) * step).sum()
}

/// Expected summary of a model.
#[derive(Debug, Clone)]
pub struct Expectation {
    /// Mean of every statistic, NaN where it is undefined.
    pub mean: Vec<f64>,
    /// Variance of every statistic from run to run, without tolerance.
    pub variance: Vec<f64>,
    events: f64,
}

impl Expectation {
    /// Mean and variance of runs with different seeds.
    ///
    /// `min_variances` are lower bounds: few runs estimate a variance badly, and the recording is
    /// noisy even if the model has no noise.
    pub fn of_runs(layout: &Layout, runs: &[Vec<f64>], min_variances: &[f64]) -> Self {
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
            variance[i] = variance[i].max(min_variances.get(i).copied().unwrap_or(0.0));
        }
        let events = layout.events(&mean);
        Self { mean, variance, events }
    }

    /// Deviation of every statistic of a summary from its expectation, in standard deviations.
    pub fn deviations(&self, layout: &Layout, summary: &[f64]) -> Vec<f64> {
        (0..self.mean.len()).map(|i| self.deviation(layout, i, summary[i]).unwrap_or(0.0)).collect()
    }

    /// Deviation of one statistic; none where it is undefined on both sides.
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

    /// Standard deviation of a statistic, including its tolerance.
    pub fn scale(&self, layout: &Layout, i: usize) -> f64 {
        if !self.mean[i].is_finite() || !layout.entries[i].is_compared() {
            return 1.0;
        }
        let floor = match layout.entries[i].kind {
            StatisticKind::Count(_) => COUNT_VARIANCE,
            StatisticKind::Value(_) => 0.0,
        };
        let tolerance = layout.tolerance(i, self.mean[i], self.events);
        // Tolerances are errors of the simulation: they add in squares, as independent ones do.
        (self.variance[i].max(floor) + tolerance * tolerance).sqrt()
    }
}

/// Mean robust loss of each block that has compared statistics.
pub fn by_block(layout: &Layout, deviations: &[f64]) -> Vec<(StatisticBlock, f64)> {
    let mut sums: std::collections::BTreeMap<StatisticBlock, (f64, f64)> =
        std::collections::BTreeMap::new();
    for (entry, z) in layout.entries.iter().zip(deviations) {
        if !entry.is_compared() {
            continue;
        }
        let (sum, count) = sums.entry(entry.block).or_default();
        // Means, so that a block counts alike however many statistics it has.
        *sum += rho(z * z);
        *count += 1.0;
    }
    sums.into_iter().map(|(block, (sum, count))| (block, sum / count)).collect()
}

/// The gap: mean over blocks of their mean robust loss, divided by its value by chance. A gap of
/// one is that of another run of the model.
pub fn gap(layout: &Layout, deviations: &[f64]) -> f64 {
    let blocks = by_block(layout, deviations);
    let sum: f64 = blocks.iter().map(|(_, distance)| distance).sum();
    sum / blocks.len() as f64 / rho_of_chance()
}

/// The discrepancy statistic, which fits minimise: the sum of the robust losses of all deviations.
pub fn discrepancy(deviations: &[f64]) -> f64 {
    deviations.iter().map(|z| rho(z * z)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excluded_blocks_do_not_count_however_far_off_they_are() {
        let all = Layout::of_all_probes();
        let some = Layout::of_blocks(|block| block != StatisticBlock::LogIntensityStep);
        let mean = vec![100.0; all.entries.len()];
        let expected = Expectation::of_runs(&all, &[mean.clone(), mean.clone()], &[]);
        let mut summary = mean;
        for (value, entry) in summary.iter_mut().zip(&all.entries) {
            *value =
                if entry.block == StatisticBlock::LogIntensityStep { f64::NAN } else { *value };
        }
        let of = |layout: &Layout| expected.deviations(layout, &summary);
        assert!(gap(&all, &of(&all)) > 0.1);
        assert_eq!((gap(&some, &of(&some)), discrepancy(&of(&some))), (0.0, 0.0));
        assert!(
            by_block(&some, &of(&some))
                .iter()
                .all(|(block, _)| *block != StatisticBlock::LogIntensityStep)
        );
    }
}

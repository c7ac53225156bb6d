//! Quantiles that are shrunk towards zero for small samples, so that they have no outliers.

use evpose_core::stats::quantile::{self, nearest_index};

/// Sample size from which on quantiles are not shrunk.
const SETTLED: f64 = 20.0;

/// Shrinkage factor of a sample of `n` values: `n / 20`, at most one.
fn shrinkage(samples: usize) -> f64 {
    (samples as f64 / SETTLED).min(1.0)
}

fn at(values: &mut [f32], share: f64) -> f64 {
    let index = nearest_index(values.len(), share);
    f64::from(*values.select_nth_unstable_by(index, f32::total_cmp).1)
}

/// Median of a sample, shrunk towards zero below twenty values; zero of an empty sample.
pub(super) fn shrunk_median(values: &mut [f32]) -> f64 {
    if values.is_empty() { 0.0 } else { shrinkage(values.len()) * at(values, 0.5) }
}

/// Interquartile range of a sample (twice the median absolute deviation if it is symmetric), shrunk
/// towards zero below twenty values; zero of an empty sample.
pub(super) fn shrunk_iqr(values: &mut [f32]) -> f64 {
    if values.is_empty() {
        0.0
    } else {
        shrinkage(values.len()) * (at(values, 0.75) - at(values, 0.25))
    }
}

/// Histogram of lags in whole microseconds, up to a limit.
#[derive(Debug, Clone)]
pub(super) struct Lags {
    counts: Vec<u32>,
    events: usize,
}

impl Lags {
    /// An empty histogram of lags whose size is below `limit_us`.
    pub(super) fn below(limit_us: i64) -> Self {
        Self { counts: vec![0; 2 * limit_us as usize - 1], events: 0 }
    }

    pub(super) fn add(&mut self, lag_us: i64) {
        let middle = self.counts.len() as i64 / 2;
        if let Some(count) = self.counts.get_mut((lag_us + middle) as usize) {
            *count += 1;
            self.events += 1;
        }
    }

    pub(super) fn shrinkage(&self) -> f64 {
        shrinkage(self.events)
    }

    /// Median lag, shrunk towards zero below twenty events.
    pub(super) fn median_us(&self) -> f64 {
        let mut left = self.events / 2;
        let place = self.counts.iter().position(|count| {
            let is_here = left < *count as usize;
            left = left.saturating_sub(*count as usize);
            is_here
        });
        let middle = self.counts.len() as f64 / 2.0 - 0.5;
        place.map_or(0.0, |place| self.shrinkage() * (place as f64 - middle))
    }
}

/// Quantile of integers from their histogram. Ties are spread over one unit, so that the quantile
/// is a continuous function of the counts.
pub(super) fn of_histogram(histogram: &[u32], share: f64) -> f64 {
    let counts = histogram.iter().map(|n| u64::from(*n));
    quantile::of_histogram(counts, share)
        .map_or(0.0, |(value, inside)| (value as f64 - 0.5 + inside).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_few_values_are_shrunk() {
        let mut many: Vec<f32> = (0..41).map(|i| i as f32).collect();
        assert_eq!(shrunk_median(&mut many), 20.0);
        assert_eq!(shrunk_iqr(&mut many), 20.0);
        assert_eq!(shrunk_median(&mut [8.0; 5]), 2.0);
        assert_eq!((shrunk_median(&mut []), shrunk_iqr(&mut [])), (0.0, 0.0));
    }

    #[test]
    fn lags_beyond_the_limit_do_not_count() {
        let mut lags = Lags::below(100);
        assert_eq!(lags.median_us(), 0.0);
        for _ in 0..10 {
            [-101, -100, -99, 40, 41, 99, 100, 5_000].iter().for_each(|lag| lags.add(*lag));
        }
        // Forty events; the one behind twenty of them.
        assert_eq!(lags.median_us(), 41.0);
    }

    #[test]
    fn ties_are_spread_over_one_unit() {
        // Half of all values are 3, spread from 2.5 to 3.5; the others are 7.
        let histogram = [0, 0, 0, 50, 0, 0, 0, 50];
        assert!((of_histogram(&histogram, 0.25) - 3.0).abs() < 1e-12);
        assert!((of_histogram(&histogram, 0.5) - 3.5).abs() < 1e-12);
        assert!((of_histogram(&histogram, 0.75) - 7.0).abs() < 1e-12);
        assert_eq!(of_histogram(&[], 0.5), 0.0);
    }
}

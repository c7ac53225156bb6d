//! Statistics of samples with their standard errors.

use evpose_core::stats::quantile::linear;

/// Fewest values of a median or a spread.
const ENOUGH: usize = 30;
/// Standard error of a median relative to that of a mean, and of a spread relative to the spread.
const MEDIAN_ERROR: f64 = 1.2533;
const SPREAD_ERROR: f64 = 1.2;
/// Interquartile range of a normal distribution over its standard deviation.
const NORMAL_RANGE: f64 = 1.349;
/// Standard error of the logarithm of a ratio that two simulators of one sensor differ by.
const RATIO_TOLERANCE: f64 = 0.01;
/// Fewest events that a ratio is formed of.
const ENOUGH_EVENTS: f64 = 20.0;

/// A statistic of one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Value {
    pub(crate) value: f64,
    /// Standard error by sampling, and by what two simulators of one sensor differ by.
    pub(crate) error: f64,
}

impl Value {
    pub(super) fn new(value: f64, error: f64) -> Self {
        Self { value, error }
    }

    /// A count of independent things.
    pub(super) fn of_count(count: f64) -> Self {
        Self::new(count, (count + 1.0).sqrt())
    }

    /// Median of a sample; none of too few values. `tolerance` is an error beside that of sampling.
    pub(super) fn median(sample: &mut [f64], tolerance: f64) -> Option<Self> {
        let (median, range) = quartiles(sample)?;
        let error = MEDIAN_ERROR * range / NORMAL_RANGE / (sample.len() as f64).sqrt();
        Some(Self::new(median, error.hypot(tolerance)))
    }

    /// Interquartile range of a sample; none of too few values.
    pub(super) fn spread(sample: &mut [f64], tolerance: f64) -> Option<Self> {
        let (_, range) = quartiles(sample)?;
        let error = SPREAD_ERROR * range / (sample.len() as f64).sqrt();
        Some(Self::new(range, error.hypot(tolerance)))
    }

    /// Logarithm of the ratio of counts to what is expected; none of too few.
    pub(super) fn log_ratio(count: f64, expected: f64) -> Option<Self> {
        let is_enough = expected >= ENOUGH_EVENTS;
        // One half more, so that the logarithm of nothing is finite.
        let error = (1.0 / (count + 0.5)).sqrt().hypot(RATIO_TOLERANCE);
        is_enough.then(|| Self::new(((count + 0.5) / (expected + 0.5)).ln(), error))
    }

    pub(super) fn less(self, other: Self) -> Self {
        Self::new(self.value - other.value, self.error.hypot(other.error))
    }
}

fn quartiles(sample: &mut [f64]) -> Option<(f64, f64)> {
    if sample.len() < ENOUGH {
        return None;
    }
    sample.sort_by(f64::total_cmp);
    Some((linear(sample, 0.5), linear(sample, 0.75) - linear(sample, 0.25)))
}

//! Detection of a machine under load: outliers and drift of timings.

use serde::Serialize;

use evpose_core::stats::quantile::{nearest_rank, outlier_count};

/// Maximum fraction of outliers before a warning.
const MAX_OUTLIERS: f64 = 0.1;
/// Maximum relative difference of the medians of both halves before a warning.
const MAX_DRIFT: f64 = 0.05;

/// Noise of a series of timings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Noise {
    times: usize,
    /// Modified z-scores above 3.5 (Iglewicz and Hoaglin 1993).
    outliers: usize,
    /// The median of the second half over that of the first, less 1.
    drift: f64,
}

impl Noise {
    /// The noise of timings in the order of measurement.
    pub(super) fn from_times(times_ms: &[f64]) -> Self {
        let median = |times: &[f64]| {
            let mut sorted = times.to_vec();
            sorted.sort_by(f64::total_cmp);
            nearest_rank(&sorted, 0.5)
        };
        let mut sorted = times_ms.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (first, second) = times_ms.split_at(times_ms.len() / 2);
        // Medians are compared, since an outlier in one half is no drift.
        let drift = if first.is_empty() { 0.0 } else { median(second) / median(first) - 1.0 };
        Self { times: times_ms.len(), outliers: outlier_count(&sorted), drift }
    }

    /// A warning for the user, if the noise is too high.
    pub(super) fn warning(self) -> Option<String> {
        let Self { times, outliers, drift } = self;
        if outliers as f64 > MAX_OUTLIERS * times as f64 {
            return Some(format!("{outliers} of {times} were outliers"));
        }
        (drift.abs() > MAX_DRIFT)
            .then(|| format!("the second half took {:+.0} % of the first's time", 100.0 * drift))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_machine_is_not_warned_of() {
        let steady: Vec<f64> = (0..40).map(|i| 10.0 + 0.01 * f64::from(i % 7)).collect();
        assert_eq!(Noise::from_times(&steady).warning(), None);
        assert_eq!(Noise::from_times(&[3.0]).warning(), None);
    }

    #[test]
    fn outliers_and_drift_each_cause_a_warning() {
        let busy: Vec<f64> = (0..40)
            .map(|i| if i % 5 == 0 { 30.0 } else { 10.0 + 0.01 * f64::from(i % 7) })
            .collect();
        assert_eq!(Noise::from_times(&busy).warning().as_deref(), Some("8 of 40 were outliers"));
        let slowed: Vec<f64> =
            (0..40).map(|i| if i < 20 { 10.0 } else { 11.0 } + 0.5 * f64::from(i % 7)).collect();
        let warning = Noise::from_times(&slowed).warning().unwrap_or_default();
        assert!(warning.starts_with("the second half took +"), "{warning}");
    }
}

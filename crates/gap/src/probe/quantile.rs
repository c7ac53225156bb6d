//! Quantiles that shrink to zero where there is little to take them of.

/// Samples smaller than this count by their share of it.
const SETTLED: f64 = 20.0;

fn trust(samples: usize) -> f64 {
    (samples as f64 / SETTLED).min(1.0)
}

fn at(values: &mut [f32], share: f64) -> f64 {
    let place = ((values.len() - 1) as f64 * share).round() as usize;
    f64::from(*values.select_nth_unstable_by(place, f32::total_cmp).1)
}

/// The median, pulled to zero below twenty values.
pub(super) fn median(values: &mut [f32]) -> f64 {
    if values.is_empty() { 0.0 } else { trust(values.len()) * at(values, 0.5) }
}

/// The distance of the quartiles, pulled to zero below twenty values.
pub(super) fn spread(values: &mut [f32]) -> f64 {
    if values.is_empty() {
        0.0
    } else {
        trust(values.len()) * (at(values, 0.75) - at(values, 0.25))
    }
}

/// How often lags in whole microseconds occur, up to a limit.
#[derive(Debug, Clone)]
pub(super) struct Lags {
    counts: Vec<u32>,
    events: usize,
}

impl Lags {
    /// Lags of a size below `limit_us`.
    pub(super) fn below(limit_us: i64) -> Self {
        Self { counts: vec![0; 2 * limit_us as usize - 1], events: 0 }
    }

    /// Counts a lag if it is below the limit.
    pub(super) fn add(&mut self, lag_us: i64) {
        let middle = self.counts.len() as i64 / 2;
        if let Some(count) = self.counts.get_mut((lag_us + middle) as usize) {
            *count += 1;
            self.events += 1;
        }
    }

    /// One, or less below twenty events.
    pub(super) fn trust(&self) -> f64 {
        trust(self.events)
    }

    /// The median, pulled to zero below twenty events.
    pub(super) fn median_us(&self) -> f64 {
        let mut left = self.events / 2;
        let place = self.counts.iter().position(|count| {
            let is_here = left < *count as usize;
            left = left.saturating_sub(*count as usize);
            is_here
        });
        let middle = self.counts.len() as f64 / 2.0 - 0.5;
        place.map_or(0.0, |place| self.trust() * (place as f64 - middle))
    }
}

/// A quantile of whole numbers from how often each occurs. Equal numbers are spread over one unit,
/// so that it moves smoothly with the shares.
pub(super) fn of_histogram(histogram: &[u32], share: f64) -> f64 {
    let all: u64 = histogram.iter().map(|n| u64::from(*n)).sum();
    let wanted = share * all as f64;
    let mut below = 0.0;
    for (value, &times) in histogram.iter().enumerate().filter(|(_, times)| **times > 0) {
        let times = f64::from(times);
        if below + times >= wanted {
            return (value as f64 - 0.5 + (wanted - below) / times).max(0.0);
        }
        below += times;
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_values_count_by_their_share() {
        let mut many: Vec<f32> = (0..41).map(|i| i as f32).collect();
        assert_eq!(median(&mut many), 20.0);
        assert_eq!(spread(&mut many), 20.0);
        assert_eq!(median(&mut [8.0; 5]), 2.0);
        assert_eq!((median(&mut []), spread(&mut [])), (0.0, 0.0));
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
        // Half of all numbers are 3, which reach from 2.5 to 3.5; the others are 7.
        let histogram = [0, 0, 0, 50, 0, 0, 0, 50];
        assert!((of_histogram(&histogram, 0.25) - 3.0).abs() < 1e-12);
        assert!((of_histogram(&histogram, 0.5) - 3.5).abs() < 1e-12);
        assert!((of_histogram(&histogram, 0.75) - 7.0).abs() < 1e-12);
        assert_eq!(of_histogram(&[], 0.5), 0.0);
    }
}

//! Spread of summary statistics over samples of nuisance parameters.

use crate::{Layout, StatisticKind};

/// Standard deviations over samples that are tolerated.
const TOLERATED: f64 = 3.0;
/// Statistics whose tolerated spread exceeds this, as a fraction of all events or as a multiple of
/// their own tolerance, are excluded.
const MAX_SHARE: f64 = 0.05;
const MAX_MULTIPLE: f64 = 20.0;

/// Mean square differences of samples to the compared scene, by data split and statistic, on the
/// scale of the statistic's tolerance.
pub(super) struct NuisanceSpread {
    /// Sums of squares of the three data splits; infinite where a sample has no such statistic.
    squares: [Vec<f64>; 3],
    samples: u64,
}

impl NuisanceSpread {
    pub(super) fn new(layout: &Layout, samples: u64) -> Self {
        Self { squares: [0, 1, 2].map(|_| vec![0.0; layout.entries.len()]), samples }
    }

    /// Adds a sample's summary of a data split, whose compared scene has the summary `own`.
    pub(super) fn add(&mut self, part: usize, layout: &Layout, own: &[f64], sample: &[f64]) {
        let events = layout.events(own).max(1.0);
        // Summaries hold twice the root of counts, which has a variance of one.
        let count_of = |value: f64| 0.25 * value * value;
        for (i, sum) in self.squares[part].iter_mut().enumerate() {
            let (a, b) = (own[i], sample[i]);
            if a.is_nan() && b.is_nan() {
                continue;
            }
            let apart = match layout.entries[i].kind {
                StatisticKind::Count(_) => (count_of(b) - count_of(a)) / events,
                StatisticKind::Value(_) => b - a,
            };
            *sum += if apart.is_finite() { apart * apart } else { f64::INFINITY };
        }
    }

    /// Widens the tolerances of `layout` to the spread.
    pub(super) fn widen(&self, layout: &mut Layout) {
        for (i, entry) in layout.entries.iter_mut().enumerate() {
            let max = self.squares.iter().map(|part| part[i]).fold(0.0, f64::max);
            let apart = TOLERATED * (max / self.samples as f64).sqrt();
            let (tolerance, largest) = match &mut entry.kind {
                StatisticKind::Count(share) => (share, MAX_SHARE),
                StatisticKind::Value(own) => {
                    let largest = MAX_MULTIPLE * *own;
                    (own, largest)
                }
            };
            // A statistic that depends that much on what is not known is left out.
            *tolerance = if apart > largest { f64::INFINITY } else { tolerance.max(apart) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Entry, StatisticBlock};

    const SAMPLES: u64 = 8;

    #[test]
    fn a_small_spread_is_tolerated_and_a_large_one_excludes_a_statistic() {
        let mut layout = Layout::of_all_probes();
        let kinds =
            [StatisticKind::Value(0.1), StatisticKind::Value(0.1), StatisticKind::Count(0.0)];
        let entry = |kind| Entry { block: StatisticBlock::Timing, name: String::new(), kind };
        let first = layout.entries.len();
        layout.entries.extend(kinds.map(entry));
        let own = vec![20.0; layout.entries.len()];
        let mut sample = own.clone();
        (sample[first], sample[first + 1]) = (20.2, 30.0);
        let mut spread = NuisanceSpread::new(&layout, SAMPLES);
        (0..SAMPLES).for_each(|_| spread.add(1, &layout, &own, &sample));
        spread.widen(&mut layout);
        let tolerance = |i: usize| match layout.entries[first + i].kind {
            StatisticKind::Value(tolerance) | StatisticKind::Count(tolerance) => tolerance,
        };
        assert!((tolerance(0) - 0.6).abs() < 1e-9, "{}", tolerance(0));
        assert!(tolerance(1).is_infinite() && tolerance(2) == 0.0);
    }
}

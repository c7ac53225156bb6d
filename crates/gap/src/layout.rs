//! Layout of a summary: a fixed vector of statistics, computed in the same way from measured and
//! from simulated events.

use crate::entry::{Entry, StatisticBlock, StatisticKind};
use crate::probe::{ALL_EVENTS, PROBES};
use crate::{Cell, View};

/// The entries of a summary, in order.
#[derive(Debug, Clone)]
pub struct Layout {
    /// All entries, probe after probe.
    pub entries: Vec<Entry>,
}

const COUNT_TOLERANCE: f64 = 0.01;

/// Constant of the variance-stabilising transform of counts (Anscombe 1948).
const ANSCOMBE: f64 = 0.375;

impl Layout {
    /// Entries of all probes.
    pub fn of_all_probes() -> Self {
        Self { entries: PROBES.iter().flat_map(|probe| (probe.entries)()).collect() }
    }

    /// Entries of all probes, of which only those of some blocks are compared.
    pub fn of_blocks(is_compared: impl Fn(StatisticBlock) -> bool) -> Self {
        let mut layout = Self::of_all_probes();
        for entry in layout.entries.iter_mut().filter(|entry| !is_compared(entry.block)) {
            let (StatisticKind::Count(tolerance) | StatisticKind::Value(tolerance)) =
                &mut entry.kind;
            *tolerance = f64::INFINITY;
        }
        layout
    }

    /// Computes the summary of a view, each statistic on the scale on which it is compared.
    pub fn summarise(&self, view: &View<'_>) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.entries.len());
        for probe in &PROBES {
            (probe.measure)(view, &mut values);
        }
        assert_eq!(values.len(), self.entries.len());
        for (value, entry) in values.iter_mut().zip(&self.entries) {
            if let StatisticKind::Count(_) = entry.kind {
                // Anscombe's transform (1948): the variance of a Poisson count becomes one.
                *value = 2.0 * (*value + ANSCOMBE).sqrt();
            }
        }
        values
    }

    /// Tolerance of an entry on its scale, at a value of it in a summary of this many events.
    pub fn tolerance(&self, entry: usize, value: f64, events: f64) -> f64 {
        match self.entries[entry].kind {
            // The derivative of the transform takes counts to differences on its scale.
            StatisticKind::Count(share) => {
                let events_of_entry = 0.25 * value * value;
                (COUNT_TOLERANCE * events_of_entry + share * events) * 2.0 / value.max(1.0)
            }
            StatisticKind::Value(tolerance) => tolerance,
        }
    }

    /// Counts of OFF and ON events of a summary while luminance changes.
    pub fn events_in_motion(&self, summary: &[f64]) -> [f64; 2] {
        let mut counts = [0.0; 2];
        for (i, value) in summary.iter().take(ALL_EVENTS).enumerate() {
            // Entries go by polarity first, then by speed, of which the first class is rest.
            if i / 2 % Cell::SPEEDS > 0 {
                counts[i % 2] += (0.25 * value * value - ANSCOMBE).max(0.0);
            }
        }
        counts
    }

    /// Total number of events of a summary, from the histogram that counts every event once.
    pub fn events(&self, summary: &[f64]) -> f64 {
        let all = self.entries.iter().zip(summary).take(ALL_EVENTS);
        all.map(|(_, value)| 0.25 * value * value - ANSCOMBE).sum()
    }
}

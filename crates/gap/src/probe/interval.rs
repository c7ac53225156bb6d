//! Inter-event intervals of pixels.

use crate::probe::interface::StatisticProbe;
use crate::{Entry, StatisticBlock, StatisticKind, View};

/// Histograms over the logarithm of the interval, by the polarities of the two events; separate
/// ones for pixels at rest.
pub(super) static PROBE: StatisticProbe = StatisticProbe { name: "interval", entries, measure };

/// Bins per decade, from 10 us to 1 s.
const PER_DECADE: usize = 6;
const BINS: usize = 5 * PER_DECADE + 2;
const PAIRS: [&str; 4] = ["OFF OFF", "ON OFF", "OFF ON", "ON ON"];
/// Fraction of all events that may fall to either side of the edge of a bin.
const BIN_TOLERANCE: f64 = 0.001;
/// Coarser bins at rest: 0.1 ms to 1 s.
const QUIET_BINS: usize = 10;

fn bin(interval_us: i64) -> usize {
    let place = ((interval_us.max(1) as f64).log10() - 1.0) * PER_DECADE as f64;
    (place + 1.0).clamp(0.0, (BINS - 1) as f64) as usize
}

fn quiet_bin(interval_us: i64) -> usize {
    let place = ((interval_us.max(1) as f64).log10() - 2.0) * 2.0;
    (place + 1.0).clamp(0.0, (QUIET_BINS - 1) as f64) as usize
}

fn entries() -> Vec<Entry> {
    let entry = |block, name| {
        let share = if block == StatisticBlock::Quiet { 0.0 } else { BIN_TOLERANCE };
        Entry { block, name, kind: StatisticKind::Count(share) }
    };
    let moving = PAIRS.iter().flat_map(|pair| {
        (0..BINS)
            .map(move |bin| entry(StatisticBlock::Interval, format!("{pair} intervals, bin {bin}")))
    });
    let quiet = PAIRS.iter().flat_map(|pair| {
        (0..QUIET_BINS).map(move |bin| {
            entry(StatisticBlock::Quiet, format!("{pair} intervals at rest, bin {bin}"))
        })
    });
    moving.chain(quiet).collect()
}

fn measure(view: &View<'_>, out: &mut Vec<f64>) {
    let mut moving = [0.0; 4 * BINS];
    let mut quiet = [0.0; 4 * QUIET_BINS];
    for event in view.events() {
        let Some((interval_us, was_on)) = event.before() else { continue };
        let pair = usize::from(was_on) + 2 * usize::from(event.is_on);
        if event.cell.is_quiet() {
            quiet[pair * QUIET_BINS + quiet_bin(interval_us)] += 1.0;
        } else {
            moving[pair * BINS + bin(interval_us)] += 1.0;
        }
    }
    out.extend(moving.iter().chain(&quiet));
}

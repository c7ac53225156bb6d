//! Behaviour under load, while many pixels have events at once: rate limits, queues and lost
//! events.

use crate::probe::interface::StatisticProbe;
use crate::probe::quantile::{self, Lags};
use crate::probe::reference;
use crate::{Entry, StatisticBlock, View};

/// Quantiles of load, lag and counts while the reference is busy, and the shortest intervals of the
/// whole sensor.
pub(super) static PROBE: StatisticProbe = StatisticProbe { name: "load", entries, measure };

/// Finest bins, and the widths of all bins as multiples.
const BIN_US: i64 = 100;
const WIDTHS: [usize; 3] = [1, 10, 100];
const LOADS: [f64; 3] = [0.5, 0.9, 0.99];
const INTERVALS: [f64; 4] = [0.01, 0.05, 0.1, 0.5];
/// Intervals of the whole sensor are clipped here, microseconds.
const MAX_INTERVAL_US: usize = 1 << 15;
/// Fraction of all milliseconds that count as busy.
const BUSY: f64 = 0.05;
/// Largest lag that is compared: events further apart may be unrelated.
const NEAR_US: i64 = 5_000;
/// Prior count that shrinks ratios of few events towards one.
const SETTLED: f64 = 20.0;

/// `ln(1 + n)` for three quantiles and the maximum of the events `n` per bin.
fn loads(bins: &[u32], width: usize) -> [f64; 4] {
    let coarse: Vec<u32> = bins.chunks(width).map(|bins| bins.iter().sum()).collect();
    let max = coarse.iter().max().copied().unwrap_or(0);
    let mut histogram = vec![0_u32; max as usize + 1];
    coarse.iter().for_each(|n| histogram[*n as usize] += 1);
    let [a, b, c] = LOADS.map(|share| quantile::of_histogram(&histogram, share).ln_1p());
    [a, b, c, f64::from(max).ln_1p()]
}

/// Marks the milliseconds in which the reference is busiest, and counts its events in calm and in
/// busy ones.
fn busy(view: &View<'_>, milliseconds: usize) -> (Vec<bool>, [f64; 2]) {
    let mut counts = vec![0_u32; milliseconds];
    for list in reference::lists(view, view.window) {
        for t_us in list.t_us {
            counts[(view.since_start_us(*t_us) / 1_000) as usize] += 1;
        }
    }
    let mut order: Vec<usize> = (0..milliseconds).collect();
    let count = ((BUSY * milliseconds as f64) as usize).max(1).min(milliseconds);
    // By the reference: a readout that loses events in busy milliseconds must not make them calm.
    order.sort_by_key(|bin| (std::cmp::Reverse(counts[*bin]), *bin));
    let mut is_busy = vec![false; milliseconds];
    order[..count].iter().for_each(|bin| is_busy[*bin] = true);
    let mut events = [0.0; 2];
    for (count, is_busy) in counts.iter().zip(&is_busy) {
        events[usize::from(*is_busy)] += f64::from(*count);
    }
    (is_busy, events)
}

fn entries() -> Vec<Entry> {
    let value = |name: String, tolerance| Entry::value(StatisticBlock::Load, name, tolerance);
    let loads = WIDTHS.iter().flat_map(|width| {
        let name = ["quantile 0.5", "quantile 0.9", "quantile 0.99", "maximum"];
        name.map(|name| {
            let us = width * BIN_US as usize;
            value(format!("log {name} of events per {us} us"), 0.02)
        })
    });
    let others = [
        ("lag in busy less that in calm milliseconds, in steps", 0.05),
        ("log of events against expected, calm milliseconds", 0.01),
        ("log of events against expected, busy milliseconds", 0.01),
    ];
    let others = others.map(|(name, tolerance)| value(name.to_owned(), tolerance));
    let intervals = INTERVALS
        .map(|share| value(format!("log10 of quantile {share} of intervals of all"), 0.02));
    loads.chain(others).chain(intervals).collect()
}

fn measure(view: &View<'_>, out: &mut Vec<f64>) {
    let length_us = view.window.length().0.max(1) as usize;
    let mut bins = vec![0_u32; length_us.div_ceil(BIN_US as usize)];
    let milliseconds = length_us.div_ceil(1_000);
    let (is_busy, expected) = busy(view, milliseconds);
    let mut lags = [Lags::below(NEAR_US), Lags::below(NEAR_US)];
    let mut events = [0.0; 2];
    for event in view.events() {
        let since_us = view.since_start_us(event.t_us);
        bins[(since_us / BIN_US) as usize] += 1;
        let busy = usize::from(is_busy[(since_us / 1_000) as usize]);
        events[busy] += 1.0;
        if let Some(lag_us) = event.lag_us() {
            lags[busy].add(lag_us);
        }
    }
    out.extend(WIDTHS.iter().flat_map(|width| loads(&bins, *width)));
    let [calm, busy] = &lags;
    // Few events on either side shrink the difference towards none.
    let lag_us = calm.shrinkage().min(busy.shrinkage()) * (busy.median_us() - calm.median_us());
    out.push(1e-6 * lag_us * view.reference_scene.scene.fps());
    out.extend([0, 1].map(|i| ((events[i] + SETTLED) / (expected[i] + SETTLED)).ln()));

    // Gaps between events of all pixels, as a shared bus makes them.
    let mut intervals = vec![0_u32; MAX_INTERVAL_US + 1];
    for pair in view.events().windows(2) {
        intervals[((pair[1].t_us - pair[0].t_us) as usize).min(MAX_INTERVAL_US)] += 1;
    }
    // One more, since stamps can be equal.
    let log = |share| (quantile::of_histogram(&intervals, share) + 1.0).log10();
    out.extend(INTERVALS.map(log));
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Micros};

    use super::*;
    use crate::probe::testing;

    fn is_busy() -> Vec<bool> {
        let view = View::new(testing::reference_scene(), testing::events(), testing::whole());
        busy(&view, 601).0
    }

    #[test]
    fn events_that_wait_in_busy_milliseconds_lag_there() {
        let is_busy = is_busy();
        let late = testing::changed(|event| {
            let waits = is_busy[(event.t.0 / 1_000) as usize] && event.t.0 % 1_000 < 900;
            Some(Event { t: event.t + Micros(if waits { 100 } else { 0 }), ..event })
        });
        let name = "lag in busy less that in calm milliseconds, in steps";
        assert_eq!(testing::value(&PROBE, testing::events(), name), 0.0);
        assert!((testing::value(&PROBE, &late, name) - 0.1).abs() < 1e-9);
    }

    #[test]
    fn events_that_are_lost_in_busy_milliseconds_are_missed_there() {
        let is_busy = is_busy();
        let mut count = 0;
        let lossy = testing::changed(|event| {
            count += 1;
            (count % 2 == 0 || !is_busy[(event.t.0 / 1_000) as usize]).then_some(event)
        });
        let log_ratio = |kind| {
            let name = format!("log of events against expected, {kind} milliseconds");
            testing::value(&PROBE, &lossy, &name)
        };
        assert_eq!(log_ratio("calm"), 0.0);
        assert!((log_ratio("busy") + 2_f64.ln()).abs() < 0.05, "{}", log_ratio("busy"));
    }

    #[test]
    fn a_burst_is_the_maximum_of_the_load() {
        let burst = (0..500).map(|i| testing::on(300_000 + i % 100, 90, 10));
        let burst = testing::stream(burst.chain(testing::events().iter()));
        let log = testing::value(&PROBE, &burst, "log maximum of events per 100 us");
        assert!((501_f64.ln()..560_f64.ln()).contains(&log), "{log}");
    }

    #[test]
    fn the_shortest_intervals_are_those_between_events_of_the_whole_sensor() {
        let event = |i: i64| testing::on(50 * i, (i % 90) as u16, (i % 70) as u16);
        let regular = testing::stream((0..1_000).map(event));
        let log = testing::value(&PROBE, &regular, "log10 of quantile 0.5 of intervals of all");
        assert!((log - 51_f64.log10()).abs() < 1e-9, "{log}");
    }
}

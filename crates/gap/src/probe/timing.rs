//! Lags of events behind the reference, and reference events that are missing.

use evpose_core::{Micros, TimeWindow};

use crate::probe::interface::{StatisticProbe, brightness_third, is_moving};
use crate::probe::quantile::Lags;
use crate::probe::reference;
use crate::{Cell, Entry, StatisticBlock, StatisticKind, View};

/// Histograms and medians of the lag behind the nearest reference event of the same pixel and
/// polarity, and counts of missing events.
pub(super) static PROBE: StatisticProbe = StatisticProbe { name: "timing", entries, measure };

/// Edges of the size of a lag, microseconds.
const EDGES_US: [i64; 9] = [30, 100, 200, 400, 800, 1_600, 3_200, 6_400, 15_000];
/// Bins: both signs, one in the middle, and one for events without a partner.
const BINS: usize = 2 * EDGES_US.len();
/// Thirds of brightness and two polarities.
const HISTOGRAMS: usize = 3 * 2;
const CLASSES: usize = Cell::BRIGHTNESSES * 2;
const THIRDS: usize = 3;
/// Largest lag that goes into medians: events further apart may be unrelated.
const NEAR_US: i64 = 3_000;
/// A reference event without a measured one within this time is missing.
const REACH_US: i64 = 5_000;
/// Tolerance of lags, as a fraction of the scene's time step.
const TOLERANCE_STEPS: f64 = 0.05;

/// Fraction of all events that may fall to either side of the edge of a bin.
const BIN_TOLERANCE: f64 = 0.004;
/// Lags are uncertain by a fraction of the scene's time step, so that each is spread over bins by a
/// triangular kernel with this spacing, in time steps.
const GRAIN_STEPS: f64 = 0.02;
/// Offsets in spacings, and weights, of the kernel.
const KERNEL: [(i64, f64); 9] = [
    (-4, 0.04),
    (-3, 0.08),
    (-2, 0.12),
    (-1, 0.16),
    (0, 0.2),
    (1, 0.16),
    (2, 0.12),
    (3, 0.08),
    (4, 0.04),
];
/// Fraction of all events that may be missing by rounding alone.
const ROUNDED: f64 = 0.0005;

/// Kernel weights of an event on the bins of lags.
struct Spread {
    grain_us: i64,
    /// First bin and weights of five successive bins, for lags from `-NARROW_US` to `NARROW_US`.
    near: Vec<(usize, [f64; 5])>,
}

/// Largest lag with precomputed weights; beyond it, bins are wide against the kernel.
const NARROW_US: i64 = 500;

impl Spread {
    fn new(grain_us: i64) -> Self {
        let near = (-NARROW_US..=NARROW_US).map(|lag_us| {
            let places = KERNEL.map(|(offset, _)| bin(Some(lag_us + offset * grain_us)));
            let first = places[0].min(BINS - 5);
            let mut weights = [0.0; 5];
            for (place, (_, weight)) in places.into_iter().zip(KERNEL) {
                weights[(place - first).min(4)] += weight;
            }
            (first, weights)
        });
        Self { grain_us, near: near.collect() }
    }

    fn add(&self, lag_us: Option<i64>, histogram: &mut [f64]) {
        let known = lag_us.filter(|lag_us| lag_us.abs() <= NARROW_US);
        if let Some((first, weights)) = known.map(|lag_us| self.near[(lag_us + NARROW_US) as usize])
        {
            let bins = histogram[first..].iter_mut();
            bins.zip(weights).for_each(|(bin, weight)| *bin += weight);
            return;
        }
        // Lags beyond the table are rare: their bins are looked up one by one.
        for (offset, weight) in KERNEL {
            histogram[bin(lag_us.map(|lag_us| lag_us + offset * self.grain_us))] += weight;
        }
    }
}

fn sign(is_on: usize) -> &'static str {
    ["OFF", "ON"][is_on]
}

/// Bin of a lag: zero lag is in the middle; the last bin is for events without a partner.
fn bin(lag_us: Option<i64>) -> usize {
    let none = BINS - 1;
    let Some(lag_us) = lag_us else { return none };
    let size = EDGES_US.iter().filter(|edge| lag_us.abs() >= **edge).count();
    let middle = EDGES_US.len() - 1;
    match size {
        // Lags beyond the last edge are those of other events, as is no lag at all.
        far if far > middle => none,
        size if lag_us < 0 => middle - size,
        size => middle + size,
    }
}

/// Counts reference events without a measured one within reach, away from the ends of the window,
/// by brightness and polarity.
fn missing(view: &View<'_>) -> [f64; CLASSES] {
    let mut missing = [0.0; CLASSES];
    let reach = Micros(REACH_US);
    let inner = TimeWindow { start: view.window.start + reach, end: view.window.end - reach };
    if inner.start >= inner.end {
        return missing;
    }
    let mut miss = |pixel: usize, is_on: bool, t_us: i64| {
        let cell = view.reference_scene.classes.cell(pixel, 1e-6 * t_us as f64);
        missing[2 * cell.brightness() + usize::from(is_on)] += 1.0;
    };
    // Rest of every list behind the events processed so far.
    let mut left: Vec<&[i64]> = vec![&[]; 2 * view.size().pixels()];
    for list in reference::lists(view, inner) {
        left[2 * list.pixel + usize::from(list.is_on)] = list.t_us;
    }
    for event in view.events() {
        let pixel = event.pixel as usize;
        let times = &mut left[2 * pixel + usize::from(event.is_on)];
        while let [t_us, rest @ ..] = *times
            && *t_us <= event.t_us + REACH_US
        {
            if *t_us < event.t_us - REACH_US {
                miss(pixel, event.is_on, *t_us);
            }
            *times = rest;
        }
    }
    // What is left has no event: all those of its pixel and polarity came too early.
    for (list, times) in left.iter().enumerate() {
        times.iter().for_each(|t_us| miss(list / 2, list % 2 == 1, *t_us));
    }
    missing
}

fn entries() -> Vec<Entry> {
    let lag = |name| Entry::value(StatisticBlock::Timing, name, TOLERANCE_STEPS);
    let histogram = (0..HISTOGRAMS * BINS).map(|i| {
        let (bin, is_on, third) = (i % BINS, i / BINS % 2, i / BINS / 2);
        let name = format!("lag of {} events, brightness third {third}, bin {bin}", sign(is_on));
        Entry { block: StatisticBlock::Timing, name, kind: StatisticKind::Count(BIN_TOLERANCE) }
    });
    let by_class = (0..CLASSES)
        .map(|i| lag(format!("median lag in steps, {} events, brightness {}", sign(i % 2), i / 2)));
    let by_third = (0..THIRDS).map(|i| lag(format!("median lag in steps, third {i} of time")));
    let missing = (0..CLASSES).map(|i| {
        let name = format!("expected {} events that never come, brightness {}", sign(i % 2), i / 2);
        Entry { block: StatisticBlock::Timing, name, kind: StatisticKind::Count(ROUNDED) }
    });
    histogram.chain(by_class).chain(by_third).chain(missing).collect()
}

fn measure(view: &View<'_>, out: &mut Vec<f64>) {
    let mut histogram = [0.0; HISTOGRAMS * BINS];
    let mut by_class = vec![Lags::below(NEAR_US); CLASSES];
    let mut by_third = vec![Lags::below(NEAR_US); THIRDS];
    let length_us = view.window.length().0.max(1);
    // Lags within a fraction of a frame depend on how light is interpolated, not on the camera.
    let grain_us = (1e6 * GRAIN_STEPS * view.reference_scene.scene.step_s()).round() as i64;
    let spread = Spread::new(grain_us);
    for event in view.events().iter().filter(|event| is_moving(event.cell)) {
        let is_on = usize::from(event.is_on);
        let group = 2 * brightness_third(event.cell) + is_on;
        spread.add(event.lag_us(), &mut histogram[group * BINS..(group + 1) * BINS]);
        if let Some(lag_us) = event.lag_us() {
            let third = view.since_start_us(event.t_us) * THIRDS as i64 / length_us;
            by_class[2 * event.cell.brightness() + is_on].add(lag_us);
            by_third[third as usize].add(lag_us);
        }
    }
    out.extend(histogram);
    let steps_per_us = 1e-6 / view.reference_scene.scene.step_s();
    let lags = by_class.iter().chain(&by_third);
    out.extend(lags.map(|lags| steps_per_us * lags.median_us()));
    out.extend(missing(view));
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, EventStream};

    use super::*;
    use crate::probe::testing;

    fn later(us: impl Fn(Micros) -> i64) -> EventStream {
        testing::changed(|event| Some(Event { t: event.t + Micros(us(event.t)), ..event }))
    }

    #[test]
    fn the_bins_of_lags_are_symmetric() {
        let bins = [-20_000, -15_000, -14_999, -30, -29, 0, 29, 30, 14_999, 15_000];
        assert_eq!(bins.map(|lag| bin(Some(lag))), [17, 17, 0, 7, 8, 8, 8, 9, 16, 17]);
        assert_eq!(bin(None), BINS - 1);
    }

    #[test]
    fn a_shift_of_all_stamps_is_the_median_lag_of_every_class() {
        // Steps are a millisecond.
        let late = later(|_| 100);
        for name in entries().iter().filter(|entry| entry.name.starts_with("median lag")) {
            assert_eq!(testing::value(&PROBE, testing::events(), &name.name), 0.0);
            let lag = testing::value(&PROBE, &late, &name.name);
            assert!((lag - 0.1).abs() < 1e-9, "{}: {lag}", name.name);
        }
    }

    #[test]
    fn a_clock_that_runs_fast_has_a_lag_that_grows() {
        let fast = later(|t| t.0 / 1_000);
        for (third, lag) in [0.1, 0.3, 0.5].into_iter().enumerate() {
            let name = format!("median lag in steps, third {third} of time");
            let value = testing::value(&PROBE, &fast, &name);
            assert!((value - lag).abs() < 0.02, "{third}: {value}");
        }
    }

    #[test]
    fn events_that_never_come_are_counted() {
        let missed = |events: &EventStream| -> f64 {
            missing(&View::new(testing::reference_scene(), events, testing::whole())).iter().sum()
        };
        assert_eq!(missed(testing::events()), 0.0);
        let inner = REACH_US..testing::whole().end.0 - REACH_US;
        let is_gone = |event: Event| event.x == 20;
        let gone = testing::events().iter().filter(|event| is_gone(*event));
        let gone = gone.filter(|event| inner.contains(&event.t.0)).count();
        let without = testing::changed(|event| (!is_gone(event)).then_some(event));
        assert_eq!(missed(&without), gone as f64);
        // Within reach none is missing, beyond it all are.
        assert_eq!(missed(&later(|_| 4_000)), 0.0);
        assert!(missed(&later(|_| 6_000)) > 0.9 * testing::events().len() as f64);
    }
}

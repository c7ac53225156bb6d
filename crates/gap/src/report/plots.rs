//! The curves of a report, in which effects are visible.

use std::f64::consts::TAU;

use super::{AxisScale, Plot};
use crate::{Cell, EventFeatures, View};

/// Bins of intervals per decade, and decades, from ten microseconds to one second.
const PER_DECADE: usize = 8;
const DECADES: usize = 5;
/// Frequencies of the spectrum, their range, and the bin length of its rate.
const FREQUENCIES: usize = 56;
const LOWEST_HZ: f64 = 4.0;
const HIGHEST_HZ: f64 = 450.0;
const RATE_BIN_US: i64 = 1_000;
/// Phase bins of a period of the clock, and its length.
const RESIDUES: usize = 50;
const PERIOD_US: i64 = 1_000;
/// Maximum lag, microseconds; larger ones belong to another edge.
const LONGEST_LAG_US: i64 = 20_000;
/// Minimum events of a median.
const MIN_EVENTS: usize = 10;

type Curve = fn(&View<'_>) -> Vec<f64>;

/// Computes all curves of a recording, of runs of the model, and of the corrected model if there
/// are any.
pub fn plots(measured: &View<'_>, runs: &[View<'_>], corrected: &[View<'_>]) -> Vec<Plot> {
    let fill = |(mut plot, curve): (Plot, Curve)| {
        if std::ptr::fn_addr_eq(curve, lags as Curve) {
            plot.caption += &dark_against_bright(&curve(measured));
        }
        let all = |views: &[View<'_>]| views.iter().map(curve).collect::<Vec<_>>();
        plot.with(curve(measured), &all(runs), &all(corrected))
    };
    [over_intervals(), by_brightness(), by_speed(), by_age(), over_frequency(), over_phase()]
        .into_iter()
        .map(fill)
        .collect()
}

/// A plot with linear axes and without curves.
fn plot(title: &str, caption: &str, [x_name, y_name]: [&str; 2], x: Vec<f64>) -> Plot {
    Plot {
        title: title.to_owned(),
        caption: caption.to_owned(),
        x_name: x_name.to_owned(),
        y_name: y_name.to_owned(),
        x,
        ..Plot::default()
    }
}

/// Classes as positions on an axis, counted from one.
fn classes(count: usize) -> Vec<f64> {
    (1..=count).map(|i| i as f64).collect()
}

fn over_intervals() -> (Plot, Curve) {
    let plot = plot(
        "Times between events of a pixel",
        "An empty left end is a refractory period, a peak is a regular source, a long tail is \
         noise.",
        ["interval in ms", "events a bin"],
        (0..PER_DECADE * DECADES).map(|i| interval_us(i as f64 + 0.5) / 1e3).collect(),
    );
    (Plot { x_scale: AxisScale::Log, y_scale: AxisScale::Log, ..plot }, intervals)
}

fn by_brightness() -> (Plot, Curve) {
    let plot = plot(
        "Lag behind the ideal sensor, by brightness",
        "A slow photoreceptor is later in the dark; a delay or a clock is the same everywhere.",
        ["fifth by brightness, the darkest first", "median lag in ms"],
        classes(Cell::BRIGHTNESSES),
    );
    (plot, lags)
}

/// Whether the darkest events of a recording come later than the brightest, as a sentence behind
/// others; empty where there are too few.
fn dark_against_bright(lags_ms: &[f64]) -> String {
    /// Difference below which both are the same, milliseconds.
    const SAME_MS: f64 = 0.02;
    let known: Vec<f64> = lags_ms.iter().copied().filter(|lag| lag.is_finite()).collect();
    let [darkest, .., brightest] = known[..] else { return String::new() };
    let later_ms = darkest - brightest;
    match later_ms.abs() < SAME_MS {
        true => " Here the darkest and the brightest are alike.".to_owned(),
        false => {
            let how = if later_ms > 0.0 { "later" } else { "earlier" };
            format!(" Here the darkest come {:.2} ms {how} than the brightest.", later_ms.abs())
        }
    }
}

fn by_speed() -> (Plot, Curve) {
    let plot = plot(
        "Events by speed of change",
        "Missing events at high speed are a slow pixel, at low speed a leak or a high-pass.",
        ["1 at rest, 2 slow, 3 middle, 4 fast", "events over ideal sensor"],
        classes(Cell::SPEEDS),
    );
    (Plot { y_scale: AxisScale::Log, ..plot }, speeds)
}

fn by_age() -> (Plot, Curve) {
    let plot = plot(
        "Events behind an edge",
        "A tail is a slow pixel or a bouncing comparator, a level that stays is noise. Class 1 is \
         while light changes, then up to 5, 10, 20, 50, 100, 200 ms later, and rest.",
        ["time since light changed, by class", "events"],
        classes(Cell::AGES),
    );
    // Behind an edge rates fall by orders of magnitude.
    (Plot { y_scale: AxisScale::Log, ..plot }, ages)
}

fn over_frequency() -> (Plot, Curve) {
    let plot = plot(
        "Spectrum of the event rate",
        "A line is a lamp or a clock; a fall towards high frequencies is a slow pixel.",
        ["frequency in Hz", "power over mean rate"],
        (0..FREQUENCIES).map(frequency_hz).collect(),
    );
    (Plot { x_scale: AxisScale::Log, y_scale: AxisScale::Log, ..plot }, spectrum_of)
}

fn over_phase() -> (Plot, Curve) {
    let phases = (0..RESIDUES).map(|i| (i as f64 + 0.5) * PERIOD_US as f64 / RESIDUES as f64);
    let plot = plot(
        "Times within a millisecond",
        "Level if stamps are fine; steps and peaks are the clock or the readout.",
        ["time modulo 1 ms, microseconds", "share of events"],
        phases.collect(),
    );
    (plot, residues_of)
}

fn interval_us(bin: f64) -> f64 {
    10f64.powf(1.0 + bin / PER_DECADE as f64)
}

fn intervals(view: &View<'_>) -> Vec<f64> {
    let mut counts = vec![0.0; PER_DECADE * DECADES];
    for (interval_us, _) in view.events().iter().filter_map(|event| event.before()) {
        let place = ((interval_us.max(1) as f64).log10() - 1.0) * PER_DECADE as f64;
        if place >= 0.0 && (place as usize) < counts.len() {
            counts[place as usize] += 1.0;
        }
    }
    // Zero has no place on a logarithmic axis.
    counts.into_iter().map(|count| if count > 0.0 { count } else { f64::NAN }).collect()
}

fn lags(view: &View<'_>) -> Vec<f64> {
    let mut lags = vec![Vec::new(); Cell::BRIGHTNESSES];
    for event in view.events().iter().filter(|event| event.cell.age() <= 1) {
        if let Some(lag_us) = event.lag_us().filter(|lag| lag.abs() < LONGEST_LAG_US) {
            lags[event.cell.brightness()].push(lag_us);
        }
    }
    lags.iter_mut()
        .map(|lags| {
            if lags.len() < MIN_EVENTS {
                // A median of a few events would be drawn as if it were one of many.
                return f64::NAN;
            }
            let middle = lags.len() / 2;
            *lags.select_nth_unstable(middle).1 as f64 / 1e3
        })
        .collect()
}

fn speeds(view: &View<'_>) -> Vec<f64> {
    let mut expected = [0.0; Cell::SPEEDS];
    for pixel in 0..view.size().pixels() {
        for is_on in [false, true] {
            let times = view.reference_scene.expected.times(pixel, is_on);
            let inside = times.iter().filter(|t| view.window.contains(evpose_core::Micros(**t)));
            for t in inside {
                expected[view.reference_scene.classes.cell(pixel, *t as f64 * 1e-6).speed()] += 1.0;
            }
        }
    }
    let counts = counts(view, Cell::SPEEDS, |event| event.cell.speed());
    let ratio = |(count, expected): (f64, f64)| {
        // A ratio of a few events is noise: the plot has a gap there.
        if expected >= MIN_EVENTS as f64 { count / expected } else { f64::NAN }
    };
    counts.into_iter().zip(expected).map(ratio).collect()
}

fn ages(view: &View<'_>) -> Vec<f64> {
    let counts = counts(view, Cell::AGES, |event| event.cell.age());
    counts.into_iter().map(|count| if count > 0.0 { count } else { f64::NAN }).collect()
}

fn residues_of(view: &View<'_>) -> Vec<f64> {
    let bin = |event: &EventFeatures| {
        (event.t_us.rem_euclid(PERIOD_US) * RESIDUES as i64 / PERIOD_US) as usize
    };
    let all = view.events().len().max(1) as f64;
    counts(view, RESIDUES, bin).into_iter().map(|count| count / all).collect()
}

fn counts(view: &View<'_>, bins: usize, bin: impl Fn(&EventFeatures) -> usize) -> Vec<f64> {
    let mut counts = vec![0.0; bins];
    for event in view.events() {
        counts[bin(event)] += 1.0;
    }
    counts
}

fn frequency_hz(i: usize) -> f64 {
    LOWEST_HZ * (HIGHEST_HZ / LOWEST_HZ).powf(i as f64 / (FREQUENCIES - 1) as f64)
}

/// Power spectrum of the rate in millisecond bins, relative to independent events.
fn spectrum_of(view: &View<'_>) -> Vec<f64> {
    let bins = (view.window.length().0 / RATE_BIN_US).max(1) as usize;
    let bin = |event: &EventFeatures| {
        ((view.since_start_us(event.t_us) / RATE_BIN_US).max(0) as usize).min(bins - 1)
    };
    let rate = counts(view, bins, bin);
    let all = view.events().len() as f64;
    let mean = all / bins as f64;
    let power = |i: usize| {
        let turns = frequency_hz(i) * RATE_BIN_US as f64 * 1e-6;
        let (mut re, mut im) = (0.0, 0.0);
        for (k, count) in rate.iter().enumerate() {
            let (sin, cos) = (TAU * turns * k as f64).sin_cos();
            re += (count - mean) * cos;
            im += (count - mean) * sin;
        }
        // Independent events have the power of their number.
        let power = (re * re + im * im) / all;
        // Zero has no place on a logarithmic axis.
        if power > 0.0 { power } else { f64::NAN }
    };
    (0..FREQUENCIES).map(power).collect()
}

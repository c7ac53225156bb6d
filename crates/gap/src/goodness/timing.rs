//! Delays, intervals, steps of light between events, and marks of clock and readout.

use std::collections::HashMap;
use std::f64::consts::TAU;

use evpose_sensor::{EffectConfig, Value as Parameter};

use super::light::{busy_milliseconds, is_bright};
use super::value::Value;
use crate::{EventFeatures, View};

/// Largest class of the time since light changed in which a pixel counts as moving: 5 ms.
const MOVING: usize = 1;
/// Largest lag that is measured, microseconds; larger ones belong to another edge.
const MAX_LAG_US: i64 = 20_000;
/// Tolerance of lags, as a fraction of the scene's time step.
const TOLERANCE_STEPS: f64 = 0.05;
/// Tolerance of steps of log light.
const STEP_TOLERANCE: f64 = 0.002;
/// Fraction of a period below which intervals are shorter than it: fits of periods are up to a fifth too long.
const SHORT: f64 = 0.75;
/// Tolerance of fractions of events.
const FRACTION_TOLERANCE: f64 = 0.002;
/// Time between two events of one burst, microseconds.
const BURST_US: i64 = 100;

/// Lags of moving pixels behind the ideal sensor, milliseconds.
fn lags(view: &View<'_>, is_counted: impl Fn(&EventFeatures) -> bool) -> Vec<f64> {
    let moving = view.events().iter().filter(|event| event.cell.age() <= MOVING);
    let lag_us = moving.filter(|event| is_counted(event)).filter_map(EventFeatures::lag_us);
    lag_us.filter(|us| us.abs() < MAX_LAG_US).map(|us| 1e-3 * us as f64).collect()
}

fn median_lag(view: &View<'_>, is_counted: impl Fn(&EventFeatures) -> bool) -> Option<Value> {
    let tolerance_ms = 1e3 * TOLERANCE_STEPS * view.reference_scene.scene.step_s();
    Value::median(&mut lags(view, is_counted), tolerance_ms)
}

/// Median lag of all.
pub(super) fn lag(view: &View<'_>) -> Option<Value> {
    median_lag(view, |_| true)
}

/// In the dark, less in bright light.
pub(super) fn dark_lag(view: &View<'_>) -> Option<Value> {
    let of = |is_wanted| median_lag(view, move |event| is_bright(event.cell) == Some(is_wanted));
    Some(of(false)?.less(of(true)?))
}

/// In the last third of the time, less in the first.
pub(super) fn lag_growth(view: &View<'_>) -> Option<Value> {
    let third_us = (view.window.length().0 / 3).max(1);
    let of =
        |third| median_lag(view, move |event| view.since_start_us(event.t_us) / third_us == third);
    Some(of(2)?.less(of(0)?))
}

/// While many pixels have events, less in calm milliseconds.
pub(super) fn busy_lag(view: &View<'_>) -> Option<Value> {
    let is_busy = busy_milliseconds(view);
    let of = |is_wanted| median_lag(view, |event| is_busy(event.t_us) == is_wanted);
    Some(of(true)?.less(of(false)?))
}

/// Interquartile range.
pub(super) fn lag_spread(view: &View<'_>) -> Option<Value> {
    let tolerance_ms = 1e3 * TOLERANCE_STEPS * view.reference_scene.scene.step_s();
    Value::spread(&mut lags(view, |_| true), tolerance_ms)
}

/// Fraction of the intervals of pixels that are shorter than the period of an effect.
pub(super) fn short_intervals(view: &View<'_>, effect: &EffectConfig) -> Option<Value> {
    let limit_us = SHORT * effect.number("period_us")?;
    let intervals = view.events().iter().filter_map(|event| event.before());
    let (mut short, mut all) = (0.0_f64, 0.0_f64);
    for (us, _) in intervals {
        all += 1.0;
        short += f64::from(u8::from((us as f64) < limit_us));
    }
    fraction(short, all)
}

fn fraction(part: f64, all: f64) -> Option<Value> {
    let share = part / all.max(1.0);
    let error = (share * (1.0 - share) / all.max(1.0)).sqrt();
    (all >= 30.0).then(|| Value::new(share, error.hypot(FRACTION_TOLERANCE)))
}

/// Changes of log light from event to event of a pixel whose light changes.
fn steps(view: &View<'_>, is_counted: impl Fn(&EventFeatures, bool) -> bool) -> Vec<f64> {
    let moving = view.events().iter().filter(|event| event.cell.age() == 0);
    let is_wanted = |event: &&EventFeatures| {
        event.before().is_some_and(|(_, was_on)| is_counted(event, was_on == event.is_on))
    };
    moving.filter(is_wanted).map(|event| f64::from(event.log_step)).collect()
}

/// Steps behind an event of the same polarity, less those behind one of the other.
pub(super) fn step_asymmetry(view: &View<'_>) -> Option<Value> {
    let of = |wanted: bool| {
        Value::median(&mut steps(view, |_, is_same| is_same == wanted), STEP_TOLERANCE)
    };
    Some(of(true)?.less(of(false)?))
}

/// Steps where light changes fast, less where it changes slowly.
pub(super) fn fast_steps(view: &View<'_>) -> Option<Value> {
    let of = |speed: usize| {
        let of_speed =
            |event: &EventFeatures, is_same: bool| is_same && event.cell.speed() == speed;
        Value::median(&mut steps(view, of_speed), STEP_TOLERANCE)
    };
    Some(of(3)?.less(of(1)?))
}

/// Interquartile range of steps.
pub(super) fn step_spread(view: &View<'_>) -> Option<Value> {
    Value::spread(&mut steps(view, |_, is_same| is_same), STEP_TOLERANCE)
}

/// Amplitude of the line of a lamp in the ON rate less the OFF rate, relative to all events.
pub(super) fn line(view: &View<'_>, effect: &EffectConfig) -> Option<Value> {
    let hz = effect.number("frequency_hz")?;
    let (mut x, mut y) = (0.0, 0.0);
    for event in view.events() {
        let (sin, cos) = (TAU * hz * 1e-6 * event.t_us as f64).sin_cos();
        let sign = if event.is_on { 1.0 } else { -1.0 };
        x += sign * cos;
        y += sign * sin;
    }
    let n = view.events().len() as f64;
    (n >= 30.0).then(|| Value::new(x.hypot(y) / n, 1.0 / n.sqrt()))
}

/// Length of the mean of unit vectors at the phases of events.
fn locked(phases: impl Iterator<Item = f64>) -> Option<Value> {
    let (mut x, mut y, mut n) = (0.0_f64, 0.0, 0.0);
    for phase in phases {
        let (sin, cos) = (TAU * phase).sin_cos();
        x += cos;
        y += sin;
        n += 1.0;
    }
    (n >= 30.0).then(|| Value::new(x.hypot(y) / n, (1.0 / n).sqrt().hypot(0.01)))
}

/// Fraction of events that are locked to the lines of a scan.
pub(super) fn scan(view: &View<'_>, effect: &EffectConfig) -> Option<Value> {
    let period_us = effect.number("period_us").filter(|us| *us > 0.0)?;
    let is = |key: &str, word: &str| effect.params.get(key) == Some(&Parameter::from(word));
    let width = u32::from(view.size().width);
    let (by_column, backward) = (is("axis", "columns"), is("direction", "backward"));
    let lines = if by_column { view.size().width } else { view.size().height };
    locked(view.events().iter().map(|event| {
        let line = if by_column { event.pixel % width } else { event.pixel / width };
        let visited = f64::from(line) / f64::from(lines);
        let visited = if backward { -visited } else { visited };
        (event.t_us as f64 / period_us - visited).rem_euclid(1.0)
    }))
}

/// Fraction of stamps at the most common phase of a clock.
pub(super) fn grid(view: &View<'_>, effect: &EffectConfig) -> Option<Value> {
    let period_us = effect.number("period_us")?.round() as i64;
    if period_us < 2 {
        return None;
    }
    let mut counts: HashMap<i64, f64> = HashMap::new();
    for event in view.events() {
        *counts.entry(event.t_us.rem_euclid(period_us)).or_default() += 1.0;
    }
    fraction(counts.values().copied().fold(0.0, f64::max), view.events().len() as f64)
}

/// Fraction of the events of bursts that are in the row of the event before.
pub(super) fn row_order(view: &View<'_>) -> Option<Value> {
    let width = u32::from(view.size().width);
    let (mut same, mut all) = (0.0, 0.0);
    for pair in view.events().windows(2) {
        if pair[1].t_us - pair[0].t_us < BURST_US {
            all += 1.0;
            let is_same = pair[0].pixel / width == pair[1].pixel / width;
            same += f64::from(u8::from(is_same));
        }
    }
    fraction(same, all)
}

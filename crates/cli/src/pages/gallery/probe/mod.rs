//! The measurements, one function each.

mod interval;
mod light;
mod map;
mod signal;
mod timing;

use anyhow::Result;
use evpose_core::{Event, Plane};
use evpose_sensor::{Probe, SensorModel};

use super::bench::{self, Shown, Variant};
use evpose_report::chart::{Chart, ChartAxis, Mark, Series};
use evpose_report::colour::{OFF, ON};

/// Light of scenes at rest, relative to white.
const GREY: f64 = 0.2;

pub(super) fn measure(probe: Probe, variants: &[Variant], seed: u64) -> Result<Shown> {
    match probe {
        Probe::EventImage => Ok(Shown::Nothing),
        Probe::Grid => map::grid(variants, seed),
        Probe::RampMap => map::ramps(variants, seed),
        Probe::RestMap => map::rest(variants, seed),
        Probe::StepResponse => signal::step_response(variants, seed, 100),
        Probe::CoarseStepResponse => signal::step_response(variants, seed, 10_000),
        Probe::Trace => signal::trace(variants, seed),
        Probe::Contrast => light::contrast(variants, seed),
        Probe::Grating => light::grating(variants, seed),
        Probe::RateByRadius => light::rate_by_radius(variants, seed),
        Probe::RateByLight => light::rate(variants, seed),
        Probe::RestIntervals => interval::rest(variants, seed),
        Probe::BusyIntervals => interval::busy(variants, seed),
        Probe::NoisePairs => interval::pairs(variants, seed),
        Probe::RateOverTime => timing::rate(variants, seed),
        Probe::FlashRaster => timing::flash(variants, seed),
        Probe::FlashRate => timing::flash_rate(variants, seed),
        Probe::StampError => timing::stamp_error(variants, seed),
    }
}

/// Event rates of the moving hand.
pub(super) fn hand_rate(model: &SensorModel, hand: &[Plane<f32>], seed: u64) -> Result<Chart> {
    let events = bench::watch(model, hand, seed)?;
    let end_s = (hand.len() as f64 - 1.0) * 1e-3;
    let size = bench::size_of(hand);
    Ok(Chart {
        title: "events of all pixels".to_owned(),
        x: ChartAxis::new("time in ms"),
        y: ChartAxis::new("M events / s, OFF downwards"),
        series: rates(&events, end_s, 1e-3, 1e6, size.pixels()),
    })
}

/// Rates of ON events upwards and of OFF events downwards, in bins of `bin_s`, in units of `unit`
/// events per second.
fn rates(events: &[Event], end_s: f64, bin_s: f64, unit: f64, pixels: usize) -> Vec<Series> {
    let bins = (end_s / bin_s).ceil().max(1.0) as usize;
    let mut counts = [vec![0.0; bins], vec![0.0; bins]];
    for event in events {
        let bin = (event.t.as_seconds() / bin_s) as usize;
        if let Some(count) = counts[usize::from(event.polarity.is_on())].get_mut(bin) {
            *count += 1.0;
        }
    }
    // The first exposure of a sensor that starts in the dark is a burst that hides all else.
    let burst = pixels as f64 / 2.0;
    for count in counts.iter_mut().flat_map(|counts| counts.first_mut()) {
        *count = if *count > burst { f64::NAN } else { *count };
    }
    let series = |counts: &[f64], sign: f64, colour| Series {
        label: String::new(),
        colour,
        mark: Mark::Steps,
        points: counts
            .iter()
            .enumerate()
            .map(|(k, n)| (1e3 * bin_s * k as f64, sign * n / bin_s / unit))
            .collect(),
    };
    vec![series(&counts[1], 1.0, ON), series(&counts[0], -1.0, OFF)]
}

fn series(variant: &Variant, mark: Mark, points: Vec<(f64, f64)>) -> Series {
    let label = format!("{}: {}", variant.label, variant.values);
    Series { label, colour: variant.colour, mark, points }
}

/// At most `most` of many, evenly.
fn thin<T>(items: Vec<T>, most: usize) -> Vec<T> {
    let every = items.len().div_ceil(most.max(1)).max(1);
    items.into_iter().step_by(every).collect()
}

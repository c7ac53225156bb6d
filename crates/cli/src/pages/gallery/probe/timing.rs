//! Rates over time, readouts behind a flash, and stamps.

use anyhow::Result;
use evpose_core::Event;

use super::{GREY, Shown, Variant, rates, series, thin};
use crate::pages::gallery::bench::{Scene, by_pixel};
use evpose_report::chart::{Chart, ChartAxis, Mark, Series};
use evpose_report::colour::{OFF, ON};

const DOTS: usize = 900;

/// A scene whose own light is steady.
pub(super) fn rate(variants: &[Variant], seed: u64) -> Result<Shown> {
    let scene = Scene { size: (40, 30), steps: 400, step_us: 100, light: |_, _, _| GREY };
    let mut charts = Vec::new();
    for variant in variants {
        let (events, seconds) = scene.rest(&variant.model, seed)?;
        charts.push(Chart {
            title: format!("{}: {} events", variant.label, events.len()),
            x: ChartAxis::new("time in ms"),
            y: ChartAxis::new("events / s, OFF downwards, M"),
            // A burst at the start is a part of what is shown: no count of pixels hides it.
            series: rates(&events, seconds, 5e-4, 1e6, usize::MAX),
        });
    }
    Ok(Shown::Each(charts))
}

/// Light doubles everywhere, within 0.1 ms.
pub(super) fn flash(variants: &[Variant], seed: u64) -> Result<Shown> {
    let light = |_: usize, _: usize, t_s: f64| if t_s >= 1e-3 { 2.0 * GREY } else { GREY };
    let scene = Scene { size: (120, 90), steps: 800, step_us: 100, light };
    let mut charts = Vec::new();
    for variant in variants {
        let events = scene.show(&variant.model, seed)?;
        let last_us = events.last().map_or(0, |event| event.t.0);
        let points = |is_on: bool| {
            let chosen = events.iter().filter(|event| event.polarity.is_on() == is_on);
            let dots = chosen.map(|event| (event.t.0 as f64 * 1e-3, f64::from(event.y)));
            thin(dots.collect(), DOTS)
        };
        let dots =
            |colour, points| Series { label: String::new(), colour, mark: Mark::Dots, points };
        // At least the flash itself has to fit.
        let end_ms = (last_us as f64 * 1e-3).max(1.2);
        charts.push(Chart {
            title: format!("{}: {} events", variant.label, events.len()),
            x: ChartAxis::new("time in ms; flash at 1 ms")
                .over(0.85, end_ms + 0.05 * (end_ms - 0.8)),
            y: ChartAxis::new("row").over(0.0, 90.0),
            series: vec![dots(ON, points(true)), dots(OFF, points(false))],
        });
    }
    Ok(Shown::Each(charts))
}

/// The rate of a whole image that flickers.
pub(super) fn flash_rate(variants: &[Variant], seed: u64) -> Result<Shown> {
    let light =
        |_: usize, _: usize, t_s: f64| GREY * (std::f64::consts::TAU * 40.0 * t_s).sin().exp();
    let scene = Scene { size: (160, 120), steps: 250, step_us: 200, light };
    let mut chart = Chart {
        title: "160 x 120 pixels in light that swings at 40 Hz".to_owned(),
        x: ChartAxis::new("time in ms"),
        y: ChartAxis::log("million events / s").over(0.05, 100.0),
        series: Vec::new(),
    };
    for variant in variants {
        let events = scene.show(&variant.model, seed)?;
        let mut bins = vec![0.0; 50];
        for event in &events {
            // A readout may deliver events late, behind the last bin.
            if let Some(bin) = bins.get_mut((event.t.0 / 1_000) as usize) {
                // An event in a millisecond is a thousand in a second.
                *bin += 1e-3;
            }
        }
        let points = bins.iter().enumerate().map(|(k, rate)| (k as f64, *rate)).collect();
        let mut curve = series(variant, Mark::Steps, points);
        curve.label += &format!(", {} events", events.len());
        chart.series.push(curve);
    }
    Ok(Shown::Together(vec![chart]))
}

/// Stamps against those of the sensor without the effect, event by event, for slow and fast
/// changes.
pub(super) fn stamp_error(variants: &[Variant], seed: u64) -> Result<Shown> {
    let light = |x: usize, y: usize, t_s: f64| {
        // ln per second, and levels in other places.
        let slope = 5.0 + 15.0 * x as f64 / 31.0;
        GREY * (slope * t_s.min(0.1) + 0.2 * y as f64 / 24.0 - 1.5).exp()
    };
    let scene = Scene { size: (32, 24), steps: 120, step_us: 1_000, light };
    let Some((reference, _)) = variants.split_first() else { return Ok(Shown::Nothing) };
    let expected = by_pixel(&scene.show(&reference.model, seed)?, scene.size());
    let mut charts = Vec::new();
    for variant in variants {
        let found = by_pixel(&scene.show(&variant.model, seed)?, scene.size());
        // Pixels are compared one by one, since the effect may change the order of the stream.
        let pairs = expected.iter().zip(&found).flat_map(|(a, b)| a.iter().zip(b));
        let error = |(a, b): (&Event, &Event)| (a.t.0 as f64 * 1e-3, (b.t.0 - a.t.0) as f64);
        let points: Vec<(f64, f64)> = thin(pairs.map(error).collect(), DOTS);
        let errors = points.iter().map(|point| point.1);
        let (low, high) = errors.fold((0.0_f64, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
        let room = (0.08 * (high - low)).max(0.5);
        let colour = variant.colour;
        charts.push(Chart {
            title: format!("{}: {}", variant.label, variant.values),
            x: ChartAxis::new("time in ms").over(0.0, 100.0),
            y: ChartAxis::new("stamp less ideal stamp, us").over(low - room, high + room),
            series: vec![Series { label: String::new(), colour, mark: Mark::Dots, points }],
        });
    }
    Ok(Shown::Each(charts))
}

//! Counts and rates by light and by spatial period.

use anyhow::Result;
use evpose_core::Event;

use super::{GREY, Shown, Variant, series};
use crate::pages::gallery::bench::Scene;
use evpose_report::chart::{Chart, ChartAxis, Mark};

fn by_column(events: &[Event], columns: usize, keep: impl Fn(&Event) -> bool) -> Vec<f64> {
    let mut counts = vec![0.0; columns];
    for event in events.iter().filter(|event| keep(event)) {
        counts[usize::from(event.x)] += 1.0;
    }
    counts
}

/// Light grows by a factor of three, from every level there is.
pub(super) fn contrast(variants: &[Variant], seed: u64) -> Result<Shown> {
    const COLUMNS: usize = 96;
    const ROWS: usize = 40;
    const START_S: f64 = 0.1;
    let level = |x: usize| 1e-4 * 10_f64.powf(x as f64 / (COLUMNS - 1) as f64 * 3.5);
    // What comes before puts rows anywhere between two events.
    let light = |x: usize, y: usize, t_s: f64| {
        let before = 2.0 * y as f64 / ROWS as f64 * (1.0 - t_s / START_S).max(0.0);
        level(x) * (3_f64.ln() * (t_s / START_S - 1.0).max(0.0) - before).exp()
    };
    let scene = Scene { size: (COLUMNS as u16, ROWS as u16), steps: 200, step_us: 1_000, light };
    let mut chart = Chart {
        title: "light grows by a factor of three".to_owned(),
        x: ChartAxis::log("light at the start, relative to white"),
        y: ChartAxis::new("events, part of ln 3 / 0.2"),
        series: Vec::new(),
    };
    // The thresholds of the ideal sensor are 0.2.
    let full = 3_f64.ln() / 0.2 * ROWS as f64;
    for variant in variants {
        let events = scene.show(&variant.model, seed)?;
        let counts = by_column(&events, COLUMNS, |event| event.t.as_seconds() > START_S);
        let points = counts.iter().enumerate().map(|(x, n)| (level(x), n / full)).collect();
        chart.series.push(series(variant, Mark::Line, points));
    }
    Ok(Shown::Together(vec![chart]))
}

/// Gratings of eight periods that move to the right by half a pixel in a millisecond.
pub(super) fn grating(variants: &[Variant], seed: u64) -> Result<Shown> {
    const PERIODS: [f64; 8] = [2.5, 3.5, 5.0, 7.0, 10.0, 16.0, 28.0, 48.0];
    const BAND: usize = 28;
    const PX_PER_S: f64 = 500.0;
    const STEPS: i64 = 192;
    let light = |x: usize, y: usize, t_s: f64| {
        let place = (x as f64 - PX_PER_S * t_s) / PERIODS[y / BAND];
        GREY * (0.7 * (std::f64::consts::TAU * place).sin()).exp()
    };
    let height = (BAND * PERIODS.len()) as u16;
    let scene = Scene { size: (128, height), steps: STEPS, step_us: 1_000, light };
    let mut chart = Chart {
        title: "gratings that move by 0.5 px / ms, contrast of 1.4".to_owned(),
        x: ChartAxis::log("period in px"),
        y: ChartAxis::new("events per pixel and period"),
        series: Vec::new(),
    };
    for variant in variants {
        let events = scene.show(&variant.model, seed)?;
        let mut counts = [0.0; PERIODS.len()];
        // Bands see each other; their middles do not see much of it, nor of the borders.
        let (rows, columns) = (BAND / 2 - 2..BAND / 2 + 2, 32..96);
        for event in &events {
            let (x, y) = (usize::from(event.x), usize::from(event.y));
            if rows.contains(&(y % BAND)) && columns.contains(&x) {
                counts[y / BAND] += 1.0 / (rows.len() * columns.len()) as f64;
            }
        }
        // Divided by the period, this is the count of periods that passed each pixel.
        let passed_px = PX_PER_S * STEPS as f64 * 1e-3;
        let points = PERIODS.iter().zip(counts).map(|(p, n)| (*p, n * p / passed_px)).collect();
        chart.series.push(series(variant, Mark::Line, points));
    }
    Ok(Shown::Together(vec![chart]))
}

/// Minutes at rest, from dark to white.
pub(super) fn rate(variants: &[Variant], seed: u64) -> Result<Shown> {
    const COLUMNS: usize = 24;
    const ROWS: usize = 40;
    let level = |x: usize| (x as f64 + 0.5) / COLUMNS as f64;
    let scene = Scene {
        size: (COLUMNS as u16, ROWS as u16),
        steps: 3_000,
        step_us: 100_000,
        light: |x: usize, _: usize, _: f64| level(x),
    };
    let mut charts = [true, false].map(|is_on| Chart {
        title: format!("{} events of pixels at rest, 300 s", if is_on { "ON" } else { "OFF" }),
        x: ChartAxis::new("light relative to white").over(0.0, 1.0),
        y: ChartAxis::log("Hz per pixel").over(5e-4, 20.0),
        series: Vec::new(),
    });
    for variant in variants {
        let (events, seconds) = scene.rest(&variant.model, seed)?;
        for (chart, is_on) in charts.iter_mut().zip([true, false]) {
            let counts = by_column(&events, COLUMNS, |event| event.polarity.is_on() == is_on);
            // The rate of one pixel, from the count of a column of them.
            let per_s = 1.0 / (seconds.max(1e-9) * ROWS as f64);
            let points = counts.iter().enumerate().map(|(x, n)| (level(x), n * per_s)).collect();
            chart.series.push(series(variant, Mark::Line, points));
        }
    }
    Ok(Shown::Together(charts.into()))
}

/// A grey scene at rest, in rings about the centre.
pub(super) fn rate_by_radius(variants: &[Variant], seed: u64) -> Result<Shown> {
    const RINGS: usize = 12;
    let scene = Scene { size: (96, 72), steps: 6_000, step_us: 500, light: |_, _, _| GREY };
    // In parts of the way to the corner.
    let ring = |x: usize, y: usize| {
        let (dx, dy) = ((x as f64 - 47.5) / 48.0, (y as f64 - 35.5) / 48.0);
        ((dx.hypot(dy) / 1.25 * RINGS as f64) as usize).min(RINGS - 1)
    };
    // Outer rings have more pixels, until the sides of the image cut them.
    let mut pixels = [0.0; RINGS];
    for y in 0..72 {
        (0..96).for_each(|x| pixels[ring(x, y)] += 1.0);
    }
    let mut chart = Chart {
        title: "events of a grey scene at rest".to_owned(),
        x: ChartAxis::new("distance from the centre, 1 in the corner").over(0.0, 1.0),
        y: ChartAxis::new("Hz per pixel"),
        series: Vec::new(),
    };
    for variant in variants {
        let (events, seconds) = scene.rest(&variant.model, seed)?;
        let mut counts = [0.0; RINGS];
        for event in &events {
            counts[ring(usize::from(event.x), usize::from(event.y))] += 1.0 / seconds;
        }
        let rates = counts.iter().zip(pixels).enumerate();
        let points =
            rates.map(|(k, (n, all))| ((k as f64 + 0.5) / RINGS as f64, n / all)).collect();
        chart.series.push(series(variant, Mark::Line, points));
    }
    Ok(Shown::Together(vec![chart]))
}

//! Counts and rates by light and by spatial period.

use anyhow::Result;
use evpose_core::Event;

use super::{GREY, Shown, Variant, series};
use crate::commands::sensor::gallery::bench::Scene;
use crate::report::chart::{Axis, Chart, Mark};

/// Events of each column.
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
    const ROWS: usize = 24;
    let level = |x: usize| 1e-4 * 10_f64.powf(x as f64 / (COLUMNS - 1) as f64 * 3.5);
    // Rows start at other places between two levels of an event.
    let light = |x: usize, y: usize, t_s: f64| {
        level(x) * (0.2 * y as f64 / ROWS as f64 + 3_f64.ln() * t_s / 0.1).exp()
    };
    let scene = Scene { size: (COLUMNS as u16, ROWS as u16), steps: 100, step_us: 1_000, light };
    let mut chart = Chart {
        title: "light grows by a factor of three".to_owned(),
        x: Axis::log("light at the start, relative to white"),
        y: Axis::new("events, part of ln 3 / 0.2"),
        series: Vec::new(),
    };
    let full = 3_f64.ln() / 0.2 * ROWS as f64;
    for variant in variants {
        let (events, _) = scene.show(&variant.model, seed)?;
        let counts = by_column(&events, COLUMNS, |_| true);
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
        x: Axis::log("period in px"),
        y: Axis::new("events per pixel and period"),
        series: Vec::new(),
    };
    for variant in variants {
        let (events, _) = scene.show(&variant.model, seed)?;
        let mut counts = [0.0; PERIODS.len()];
        // Bands see each other; their middles do not see much of it, nor of the borders.
        let (mut rows, mut columns) = (0..BAND, 0..128);
        let (from, to) = (BAND / 2 - 2, BAND / 2 + 2);
        (rows.start, rows.end, columns.start, columns.end) = (from, to, 32, 96);
        for event in &events {
            let (x, y) = (usize::from(event.x), usize::from(event.y));
            if rows.contains(&(y % BAND)) && columns.contains(&x) {
                counts[y / BAND] += 1.0 / (rows.len() * columns.len()) as f64;
            }
        }
        let passed_px = PX_PER_S * STEPS as f64 * 1e-3;
        let points = PERIODS.iter().zip(counts).map(|(p, n)| (*p, n * p / passed_px)).collect();
        chart.series.push(series(variant, Mark::Line, points));
    }
    Ok(Shown::Together(vec![chart]))
}

/// A minute at rest, from dark to white.
pub(super) fn rate(variants: &[Variant], seed: u64) -> Result<Shown> {
    const COLUMNS: usize = 24;
    const ROWS: usize = 40;
    let level = |x: usize| (x as f64 + 0.5) / COLUMNS as f64;
    let scene = Scene {
        size: (COLUMNS as u16, ROWS as u16),
        steps: 3_000,
        step_us: 20_000,
        light: |x: usize, _: usize, _: f64| level(x),
    };
    let mut charts = [true, false].map(|is_on| Chart {
        title: format!("{} events of pixels at rest, 60 s", if is_on { "ON" } else { "OFF" }),
        x: Axis::new("light relative to white").over(0.0, 1.0),
        y: Axis::log("Hz per pixel").over(1e-3, 20.0),
        series: Vec::new(),
    });
    for variant in variants {
        let (events, seconds) = scene.rest(&variant.model, seed)?;
        for (chart, is_on) in charts.iter_mut().zip([true, false]) {
            let counts = by_column(&events, COLUMNS, |event| event.polarity.is_on() == is_on);
            let per_s = 1.0 / (seconds.max(1e-9) * ROWS as f64);
            let points = counts.iter().enumerate().map(|(x, n)| (level(x), n * per_s)).collect();
            chart.series.push(series(variant, Mark::Line, points));
        }
    }
    Ok(Shown::Together(charts.into()))
}

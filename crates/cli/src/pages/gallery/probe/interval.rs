//! Times between events.

use anyhow::Result;
use evpose_core::Event;

use super::{GREY, Shown, Variant, series};
use crate::pages::gallery::bench::{Scene, by_pixel};
use evpose_report::chart::{Chart, ChartAxis, Mark, Series};
use evpose_report::colour::{OFF, ON};

/// Bins of a histogram of times.
const PER_DECADE: f64 = 12.0;

/// Share of the intervals in logarithmic bins from `low_s` up.
fn histogram(intervals: &[f64], low_s: f64, high_s: f64) -> Vec<(f64, f64)> {
    let bins = (PER_DECADE * (high_s / low_s).log10()).ceil().max(1.0) as usize;
    let mut counts = vec![0.0; bins];
    for interval in intervals {
        let bin = PER_DECADE * (interval / low_s).log10();
        // Intervals below the range count in the first bin.
        if let Some(count) = counts.get_mut(bin.max(0.0) as usize) {
            *count += 1.0 / intervals.len() as f64;
        }
    }
    let edge = |k: usize| low_s * 10_f64.powf(k as f64 / PER_DECADE);
    counts.into_iter().enumerate().map(|(k, share)| (edge(k), share)).collect()
}

fn intervals(pixels: &[Vec<Event>]) -> Vec<(f64, bool)> {
    let pairs = pixels.iter().flat_map(|events| events.windows(2));
    pairs
        .map(|pair| {
            let interval_s = (pair[1].t.0 - pair[0].t.0) as f64 * 1e-6;
            (interval_s, pair[0].polarity == pair[1].polarity)
        })
        .collect()
}

/// Standard deviation over mean.
fn variation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    square.sqrt() / mean
}

/// Minutes of a scene that does not move.
pub(super) fn rest(variants: &[Variant], seed: u64) -> Result<Shown> {
    let mut chart = Chart {
        title: "intervals of pixels at rest, 400 s".to_owned(),
        x: ChartAxis::log("interval in s").over(0.01, 400.0),
        y: ChartAxis::new("share of all intervals"),
        series: Vec::new(),
    };
    // Minutes, since a pixel at rest may fire less than once a minute.
    let scene = Scene { size: (24, 18), steps: 8_000, step_us: 50_000, light: |_, _, _| GREY };
    for variant in variants {
        let (events, _) = scene.rest(&variant.model, seed)?;
        let seconds: Vec<f64> =
            intervals(&by_pixel(&events, scene.size())).iter().map(|pair| pair.0).collect();
        let mut curve = series(variant, Mark::Steps, histogram(&seconds, 0.01, 400.0));
        if seconds.len() > 1 {
            curve.label += &format!(", CV {:.2}", variation(&seconds));
        } else {
            curve.label += ", none";
        }
        chart.series.push(curve);
    }
    Ok(Shown::Together(vec![chart]))
}

/// Seconds of the same scene, by what the next event is.
pub(super) fn pairs(variants: &[Variant], seed: u64) -> Result<Shown> {
    let scene = Scene { size: (48, 36), steps: 10_000, step_us: 200, light: |_, _, _| GREY };
    let mut charts = Vec::new();
    for variant in variants {
        let (events, seconds) = scene.rest(&variant.model, seed)?;
        let pairs = intervals(&by_pixel(&events, scene.size()));
        let of = |is_same: bool| -> Vec<f64> {
            pairs.iter().filter(|pair| pair.1 == is_same).map(|pair| pair.0).collect()
        };
        let (same, other) = (of(true), of(false));
        let total = pairs.len().max(1) as f64;
        let part = |colour, values: &[f64]| Series {
            label: String::new(),
            colour,
            mark: Mark::Steps,
            // Shares of all pairs: both curves together sum to 1.
            points: histogram(values, 1e-5, 2.0)
                .into_iter()
                .map(|(s, share)| (1e3 * s, share * values.len() as f64 / total))
                .collect(),
        };
        let hz = events.len() as f64 / seconds.max(1e-9) / scene.size().pixels() as f64;
        charts.push(Chart {
            title: format!("{}: {hz:.2} Hz per pixel", variant.label),
            x: ChartAxis::log("interval in ms").over(0.01, 2_000.0),
            y: ChartAxis::new("other sign blue, same red"),
            series: vec![part(ON, &other), part(OFF, &same)],
        });
    }
    Ok(Shown::Each(charts))
}

/// Light that swings at 5 to 50 Hz.
pub(super) fn busy(variants: &[Variant], seed: u64) -> Result<Shown> {
    let light = |x: usize, y: usize, t_s: f64| {
        // A decade of frequencies over 48 columns; each row has a phase of its own.
        let hz = 5.0 * 10_f64.powf(x as f64 / 47.0);
        GREY * (std::f64::consts::TAU * (hz * t_s + y as f64 * 0.173)).sin().exp()
    };
    let scene = Scene { size: (48, 12), steps: 2_500, step_us: 200, light };
    let mut chart = Chart {
        title: "intervals of pixels in light that swings at 5 to 50 Hz".to_owned(),
        x: ChartAxis::log("interval in ms").over(0.05, 200.0),
        y: ChartAxis::new("share of all intervals"),
        series: Vec::new(),
    };
    for variant in variants {
        let events = scene.show(&variant.model, seed)?;
        let seconds: Vec<f64> =
            intervals(&by_pixel(&events, scene.size())).iter().map(|pair| pair.0).collect();
        let points =
            histogram(&seconds, 5e-5, 0.2).into_iter().map(|(s, n)| (1e3 * s, n)).collect();
        let mut curve = series(variant, Mark::Steps, points);
        curve.label += &format!(", {} events", events.len());
        chart.series.push(curve);
    }
    Ok(Shown::Together(vec![chart]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_holds_every_interval_once() {
        let found = histogram(&[0.01, 0.02, 0.5, 0.5], 1e-3, 1.0);
        assert!((found.iter().map(|bin| bin.1).sum::<f64>() - 1.0).abs() < 1e-12);
        let most = found.iter().find(|bin| bin.1 > 0.4).map_or(0.0, |bin| bin.0);
        assert!((0.4..=0.5).contains(&most), "{most}");
    }

    #[test]
    fn equal_intervals_do_not_vary() {
        assert!(variation(&[2.0, 2.0, 2.0]).abs() < 1e-12);
        assert!((variation(&[1.0, 3.0]) - 0.5).abs() < 1e-12);
    }
}

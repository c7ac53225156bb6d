//! Signals of a pixel: step responses and traces.

use anyhow::Result;
use evpose_core::{Micros, Plane, SensorSize};
use evpose_sensor::{Domain, SensorModel, Stage};

use super::{GREY, Shown, Variant, series};
use evpose_report::chart::{Chart, ChartAxis, Mark, Series};
use evpose_report::colour::{OFF, ON};

fn last_voltage(model: &SensorModel) -> Result<&'static str> {
    let mut last = "logarithmic";
    for row in model.describe().rows.iter().filter(|row| row.is_active) {
        let is_voltage = row.spec.domain == Domain::Photoreceptor;
        let stage = (row.spec.build)(&row.settings)?;
        if is_voltage
            && matches!(stage, Stage::Pixel(_) | Stage::Plane(_) | Stage::Photoreceptor(_))
        {
            last = row.spec.name;
        }
    }
    Ok(last)
}

/// Light three times as strong, from a dark and from a bright level.
pub(super) fn step_response(variants: &[Variant], seed: u64, step_us: i64) -> Result<Shown> {
    const BEFORE_US: i64 = 20_000;
    const AFTER_US: i64 = 100_000;
    let levels: [(&str, f64); 2] = [("bright", 0.3), ("dark", 0.01)];
    let size = SensorSize { width: 2, height: 1 };
    let mut charts = levels.map(|(name, level)| Chart {
        title: format!("step from {level} to {:.2} of white ({name})", 3.0 * level),
        x: ChartAxis::new("ms behind the step"),
        y: ChartAxis::new("voltage, part of the step").over(-0.1, 1.25),
        series: Vec::new(),
    });
    for variant in variants {
        let mut run = variant.model.start(size, seed);
        let stage = last_voltage(&variant.model)?;
        run.tap(stage, (0, 0))?;
        run.tap(stage, (1, 0))?;
        let mut plane = Plane::for_sensor(size, 0.0);
        for t in (0..=(BEFORE_US + AFTER_US) / step_us).map(|k| k * step_us) {
            let factor = if t > BEFORE_US { 3.0 } else { 1.0 };
            for (y, (_, level)) in plane.data_mut().iter_mut().zip(levels) {
                *y = (factor * level) as f32;
            }
            run.expose(&plane, Micros(t))?;
        }
        // The first light that is stronger is one step behind the last that is not.
        let shift_s = if step_us > 1_000 { BEFORE_US } else { BEFORE_US + step_us } as f64 * 1e-6;
        for ((tap, chart), (_, level)) in run.taps().iter().zip(&mut charts).zip(levels) {
            let start = tap.samples().first().map_or(0.0, |sample| f64::from(sample.1));
            // The dark offset of the ideal sensor flattens steps in the dark.
            let rise = ((3.0 * level + 1e-3) / (level + 1e-3)).ln();
            let points = tap
                .samples()
                .iter()
                .map(|&(t_s, v)| (1e3 * (t_s - shift_s), (f64::from(v) - start) / rise));
            chart.series.push(series(variant, Mark::Line, points.collect()));
        }
    }
    Ok(Shown::Together(charts.into()))
}

/// One pixel before light that swings, known every 2 ms.
pub(super) fn trace(variants: &[Variant], seed: u64) -> Result<Shown> {
    let size = SensorSize { width: 1, height: 1 };
    let mut charts = Vec::new();
    for variant in variants {
        let mut run = variant.model.start(size, seed);
        run.label_origins(false);
        let voltage = last_voltage(&variant.model)?;
        let rows = &variant.model.describe().rows;
        // The voltage first: taps are read in this order below.
        run.tap(voltage, (0, 0))?;
        for row in rows {
            if matches!((row.spec.build)(&row.settings)?, Stage::Detector(_)) {
                run.tap(row.spec.name, (0, 0))?;
            }
        }
        let (mut on, mut off) = (Vec::new(), Vec::new());
        for t in (0..=50).map(|k| Micros(2_000 * k)) {
            let phase = std::f64::consts::TAU * 15.0 * t.as_seconds();
            let light = GREY * (0.8 * phase.sin()).exp();
            for event in run.expose(&Plane::for_sensor(size, light as f32), t)?.iter() {
                let ticks = if event.polarity.is_on() { &mut on } else { &mut off };
                ticks.push((
                    1e3 * event.t.as_seconds(),
                    // Below the signals, still inside the axis.
                    if event.polarity.is_on() { -2.75 } else { -2.95 },
                ));
            }
        }
        let ms = |samples: &[(f64, f32)]| -> Vec<(f64, f64)> {
            samples.iter().map(|&(t, v)| (1e3 * t, f64::from(v))).collect()
        };
        let level = ms(run.taps()[0].samples());
        let residual = run.taps().get(1).map(|tap| ms(tap.samples())).unwrap_or_default();
        // The detector's signal is V - M.
        let memory = level.iter().zip(&residual).map(|(v, d)| (v.0, v.1 - d.1)).collect();
        let part = |label: &str, colour, mark, points| Series {
            label: label.to_owned(),
            colour,
            mark,
            points,
        };
        charts.push(Chart {
            title: format!("{}: {} ON, {} OFF", variant.label, on.len(), off.len()),
            x: ChartAxis::new("time in ms"),
            y: ChartAxis::new("V (line), M (steps), ln").over(-3.1, -0.7),
            series: vec![
                part("", (170, 172, 178), Mark::Steps, memory),
                part("", (29, 36, 48), Mark::Line, level),
                part("", ON, Mark::Ticks, on),
                part("", OFF, Mark::Ticks, off),
            ],
        });
    }
    Ok(Shown::Each(charts))
}

//! `evpose sensor tap`: the signal of one pixel after every stage.

use std::fmt::Write as _;

use anyhow::{Result, bail};
use evpose_core::SensorSize;
use evpose_sensor::{ChainRow, Domain, Origin, SensorModel, Stage};

use super::args::{Input, TapArgs};
use super::input;
use crate::outputs::write_file;
use crate::pages::hand_scene;
use crate::progress::say;
use crate::sensor_source as source;
use evpose_report::chart::{self, Chart, ChartAxis, Mark, Series};
use evpose_report::colour::{OFF, ON};

/// An event of the pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tick {
    t_s: f64,
    is_on: bool,
    origin: Origin,
}

/// Signal after a stage.
struct Signal {
    stage: &'static str,
    domain: Domain,
    /// Time in seconds and value: light before the photoreceptor, log light after it.
    points: Vec<(f64, f64)>,
}

struct Trace {
    /// Input light: time in seconds, relative to white.
    light: Vec<(f64, f64)>,
    /// Signals after each stage that has one, by the name of the stage.
    signals: Vec<Signal>,
    events: Vec<Tick>,
    /// ON and OFF thresholds of the sensor, if it has them.
    levels: Vec<f64>,
}

pub(super) fn run(args: &TapArgs) -> Result<()> {
    let sensor = source::sensor(&args.sensor)?;
    let extension = args.out.extension().and_then(|extension| extension.to_str());
    // Before the simulation, so that a wrong name costs no time.
    if !matches!(extension, Some("svg" | "csv")) {
        bail!("{}: the name must end in .svg or .csv", args.out.display());
    }
    let size = hand_scene::size(1.0);
    let trace = record(&sensor.model()?, size, args.pixel, args.input, args.seed)?;
    let text = match extension {
        Some("csv") => csv(&trace),
        _ => plot(&trace, &format!("{}, pixel {},{}", sensor.name, args.pixel.0, args.pixel.1))?,
    };
    write_file(&args.out, text)?;
    let on = trace.events.iter().filter(|event| event.is_on).count();
    say(format!(
        "{} stages, {on} ON and {} OFF events; written to {}",
        trace.signals.len(),
        trace.events.len() - on,
        args.out.display()
    ));
    Ok(())
}

fn record(
    model: &SensorModel,
    size: SensorSize,
    pixel: (u16, u16),
    input: Input,
    seed: u64,
) -> Result<Trace> {
    let mut run = model.start(size, seed);
    // The plot shows events by their cause.
    run.label_origins(true);
    let mut domains = Vec::new();
    // A stage without effect would repeat the signal before it.
    for row in model.describe().rows.iter().filter(|row| row.is_active) {
        let stage = (row.spec.build)(&row.settings)?;
        // Other kinds change detection, steps, requests or time stamps, and have no signal.
        let has_signal = matches!(
            stage,
            Stage::Pixel(_) | Stage::Plane(_) | Stage::Photoreceptor(_) | Stage::Detector(_)
        );
        if has_signal {
            run.tap(row.spec.name, pixel)?;
            domains.push(row.spec.domain);
        }
    }
    let (mut light, mut events) = (Vec::new(), Vec::new());
    input::expose(&mut run, input, pixel, seed, |now, origins, plane, t| {
        let at = (usize::from(pixel.0), usize::from(pixel.1));
        light.push((t.as_seconds(), f64::from(*plane.at(at.0, at.1))));
        for (event, origin) in now.iter().zip(origins.unwrap_or_default()) {
            if (event.x, event.y) == pixel {
                let t_s = event.t.as_seconds();
                events.push(Tick { t_s, is_on: event.polarity.is_on(), origin: *origin });
            }
        }
    })?;
    let signals = run.taps().iter().zip(domains).map(|(tap, domain)| {
        let points = tap.samples().iter().map(|&(t, v)| (t, f64::from(v))).collect();
        Signal { stage: tap.stage(), domain, points }
    });
    Ok(Trace { light, signals: signals.collect(), events, levels: levels(model) })
}

/// Nominal thresholds with their signs.
fn levels(model: &SensorModel) -> Vec<f64> {
    let has_levels = |row: &&ChainRow| {
        let has = |name| row.spec.number_params().any(|own| own.name == name);
        has("threshold_on") && has("threshold_off")
    };
    let row = model.describe().rows.iter().find(has_levels);
    let settings = row.map(|row| &row.settings).into_iter();
    settings.flat_map(|own| [own.number("threshold_on"), -own.number("threshold_off")]).collect()
}

/// The trace as CSV in long form: one line per sample or event.
fn csv(trace: &Trace) -> String {
    // Events and samples have times of their own, so that columns would have gaps.
    let mut text = "t_s,signal,value\n".to_owned();
    let mut add = |name: &str, points: &[(f64, f64)]| {
        for (t_s, value) in points {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{t_s:.6},{name},{value}");
        }
    };
    add("luminance", &trace.light);
    for Signal { stage, points, .. } in &trace.signals {
        add(stage, points);
    }
    for event in &trace.events {
        let sign = if event.is_on { 1 } else { -1 };
        let _ = writeln!(text, "{:.6},event:{},{sign}", event.t_s, word(event.origin));
    }
    text
}

fn word(origin: Origin) -> &'static str {
    match origin {
        Origin::Signal => "signal",
        Origin::Leak => "leak",
        Origin::Shot => "shot",
        Origin::Hot => "hot",
    }
}

/// Colour of an event: by sign for signal events, by origin for noise.
fn colour(origin: Origin, is_on: bool) -> (u8, u8, u8) {
    match (origin, is_on) {
        (Origin::Signal, true) => ON,
        (Origin::Signal, false) => OFF,
        (Origin::Leak, _) => (0, 158, 115),
        (Origin::Shot, _) => (120, 120, 120),
        (Origin::Hot, _) => (230, 159, 0),
    }
}

/// Plots one panel per stage over the same time axis, with the events at the bottom.
fn plot(trace: &Trace, title: &str) -> Result<String> {
    const INK: (u8, u8, u8) = (29, 36, 48);
    let end_ms = trace.light.last().map_or(1.0, |point| 1e3 * point.0);
    let time = |name: &str| ChartAxis::new(name).over(0.0, end_ms);
    let ms = |points: &[(f64, f64)]| points.iter().map(|&(t, v)| (1e3 * t, v)).collect();
    let line = |points| Series { label: String::new(), colour: INK, mark: Mark::Line, points };
    let mut charts = vec![Chart {
        title: format!("{title}: luminance"),
        x: time(""),
        y: ChartAxis::new("relative to white"),
        series: vec![line(ms(&trace.light))],
    }];
    for Signal { stage, domain, points } in &trace.signals {
        let (y, meaning) = match domain {
            Domain::Optics | Domain::Photodiode => ("relative to white", "light"),
            Domain::Detector => ("difference, ln", "log intensity less reference level"),
            _ => ("log intensity, ln", "log intensity"),
        };
        let mut series = vec![line(ms(points))];
        // Thresholds apply to the difference from the reference level alone.
        if *domain == Domain::Detector {
            for &level in &trace.levels {
                let (name, colour) = if level > 0.0 { ("ON", ON) } else { ("OFF", OFF) };
                let points = vec![(0.0, level), (end_ms, level)];
                series.push(Series::line(format!("{name} threshold, nominal"), colour, points));
            }
        }
        charts.push(Chart {
            title: format!("{stage} ({domain}): {meaning}"),
            x: time(""),
            y: ChartAxis::new(y),
            series,
        });
    }
    let mut series: Vec<Series> = Vec::new();
    for origin in [Origin::Signal, Origin::Leak, Origin::Shot, Origin::Hot] {
        for is_on in [true, false] {
            let of_kind = |e: &&Tick| e.origin == origin && e.is_on == is_on;
            let height = if is_on { 1.0 } else { -1.0 };
            let points: Vec<(f64, f64)> =
                trace.events.iter().filter(of_kind).map(|e| (1e3 * e.t_s, height)).collect();
            // Kinds that do not occur would crowd the key.
            if !points.is_empty() {
                let label = format!("{} {}", word(origin), if is_on { "ON" } else { "OFF" });
                let colour = colour(origin, is_on);
                series.push(Series { label, colour, mark: Mark::Ticks, points });
            }
        }
    }
    charts.push(Chart {
        title: format!("events: {}", trace.events.len()),
        x: time("time, ms"),
        y: ChartAxis::new("polarity").over(-2.0, 2.0).named(&[(1.0, "ON"), (-1.0, "OFF")]),
        series,
    });
    Ok(chart::stack(&charts, (900, 185))?)
}

#[cfg(test)]
mod tests {
    use evpose_sensor::SensorConfig;

    use super::*;

    fn ideal(input: Input) -> Result<Trace> {
        let model = SensorModel::from_config(&SensorConfig::default())?;
        record(&model, SensorSize { width: 3, height: 2 }, (1, 1), input, 1)
    }

    /// `ln(I + 1/1000)` between -2.3 and -0.7: 1.6 less what the offset takes, so seven thresholds
    /// of 0.2 within the 0.1 ms before the step is complete, and seven back.
    #[test]
    fn a_step_gives_the_thresholds_it_is_worth_within_its_rise() -> Result<()> {
        let trace = ideal(Input::Step)?;
        let rise = ((-0.7_f64).exp() + 1e-3).ln() - ((-2.3_f64).exp() + 1e-3).ln();
        let count = (rise / 0.2).floor() as usize;
        assert_eq!(count, 7);
        let (on, off): (Vec<Tick>, Vec<Tick>) = trace.events.iter().partition(|e| e.is_on);
        assert_eq!((on.len(), off.len()), (count, count));
        for (k, event) in on.iter().enumerate() {
            // Crossings of a line that rises over the last 100 us before 50 ms.
            let expected_s = 0.05 - 1e-4 + 1e-4 * 0.2 * (k + 1) as f64 / rise;
            assert!((event.t_s - expected_s).abs() <= 1e-6, "{} {expected_s}", event.t_s);
            assert_eq!(event.origin, Origin::Signal);
        }
        // Behind the seventh, the difference from the memory is what is left.
        let Signal { stage: name, points: residual, .. } = &trace.signals[1];
        assert_eq!(*name, "level_crossing");
        let after = residual.iter().find(|(t, _)| *t > 0.1).map_or(0.0, |point| point.1);
        assert!((after - (rise - 1.4)).abs() < 1e-4, "{after}");
        Ok(())
    }

    #[test]
    fn a_ramp_gives_events_at_even_times() -> Result<()> {
        let trace = ideal(Input::Ramp)?;
        let rising: Vec<f64> = trace.events.iter().filter(|e| e.is_on).map(|e| e.t_s).collect();
        // 2.0 less what the offset takes: nine thresholds, 10 ms each, a little longer in the dark.
        assert_eq!(rising.len(), 9);
        for pair in rising.windows(2) {
            assert!((pair[1] - pair[0] - 0.01).abs() < 2e-4, "{pair:?}");
        }
        Ok(())
    }

    #[test]
    fn every_stage_has_a_panel_and_a_name_in_the_table() -> Result<()> {
        let model = SensorModel::from_config(&SensorConfig::preset("davis346")?)?;
        let size = SensorSize { width: 3, height: 2 };
        let trace = record(&model, size, (0, 0), Input::Flicker, 1)?;
        let (svg, csv) = (plot(&trace, "davis346")?, csv(&trace));
        for stage in ["logarithmic", "photoreceptor_lowpass", "level_crossing"] {
            assert!(svg.contains(stage) && csv.contains(stage), "{stage}");
        }
        assert!(csv.starts_with("t_s,signal,value\n0.000000,luminance,0.2"));
        Ok(())
    }
}

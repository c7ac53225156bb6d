//! Cameras from recordings of unknown light: simulated ones, whose values are known.

use std::f64::consts::{LN_10, TAU};

use evpose_core::stats::interval::Interval;
use evpose_core::{Event, EventStream, Micros, Plane, SensorSize, TimeWindow};
use evpose_gap::camera::{CameraRecording, CameraReport};
use evpose_sensor::{EffectConfig, SensorConfig, SensorModel};
use rayon::prelude::*;

/// A printed page, by column and row.
fn page(x: f64, y: f64) -> f64 {
    let wave = (0.9 * x + 0.2 * y).sin() + (0.35 * x - 0.8 * y).sin() + (0.5 * y).cos();
    0.25 * (0.45 * wave).exp()
}

/// The events of a sensor before a page that rests, or is panned to and fro once a second, with a fifth of rest.
fn seen(config: &SensorConfig, size: SensorSize, is_panned: bool, seconds: f64) -> EventStream {
    let mut run = SensorModel::from_config(config).unwrap().start(size, 3);
    let mut all = EventStream::empty(size);
    let fps = if is_panned { 500.0 } else { 50.0 };
    for k in 0..=(seconds * fps) as i64 {
        let turns = if is_panned { TAU * ((k as f64 / fps).fract() / 0.8).min(1.0) } else { 0.0 };
        let (dx, dy) = (6.0 * (1.0 - turns.cos()), 3.0 * turns.sin());
        let mut plane = Plane::for_sensor(size, 0.0);
        for (i, value) in plane.data_mut().iter_mut().enumerate() {
            let (x, y) = (i % usize::from(size.width), i / usize::from(size.width));
            *value = page(x as f64 + dx, y as f64 + dy) as f32;
        }
        let events = run.expose(&plane, Micros::from_seconds(k as f64 / fps)).unwrap();
        events.iter().for_each(|event| all.push(event).unwrap());
    }
    all
}

fn report_of(recordings: &[(&str, EventStream)]) -> CameraReport {
    let tested = recordings
        .par_iter()
        .map(|(name, events)| CameraRecording::new((*name).to_owned(), events.clone()).unwrap());
    CameraReport::new(tested.collect()).unwrap()
}

fn reach(value: &Interval) -> f64 {
    value.high.unwrap() - value.estimate
}

fn holds(value: &Interval, truth: f64) -> bool {
    value.low.unwrap() <= truth && truth <= value.high.unwrap()
}

#[track_caller]
fn known(report: &CameraReport, name: &str) -> Interval {
    let known = report.quantity(name).unwrap().known();
    known.first().unwrap_or_else(|| panic!("no {name}: {:#?}", report.rows())).0
}

#[test]
fn what_is_known_of_presets_is_true() {
    let size = SensorSize { width: 64, height: 48 };
    for (name, must) in [("davis240c", "background_off_hz"), ("dvxplorer", "scan_period_us")] {
        let config = SensorConfig::preset(name).unwrap();
        let [still, pan] =
            [(false, 4.0), (true, 1.0)].map(|(is_panned, s)| seen(&config, size, is_panned, s));
        let report = report_of(&[("static", still), ("pan", pan)]);
        let number = |effect: &str, key: &str| config.effect(effect).and_then(|e| e.number(key));
        let pixels = (0..size.pixels()).map(|i| page((i % 64) as f64, (i / 64) as f64));
        let light = pixels.sum::<f64>() / size.pixels() as f64;
        // Means over pixels whose rates are spread by a tenth of a decade.
        let spread = (0.5 * (0.1 * LN_10).powi(2)).exp();
        let leak = spread * number("leak_on", "rate_hz").unwrap();
        let noise = number("shot_noise_poisson", "rate_hz").unwrap();
        let off = spread * 0.5 * noise * (1.0 - 0.75 * light);
        for quantity in &report.quantities {
            for (value, _) in quantity.known() {
                let truth = match quantity.name {
                    "threshold_ratio" => Some(1.0),
                    "leak_hz" => Some(leak),
                    "refractory_us" => number("refractory", "period_us"),
                    "scan_period_us" => number("scanned_readout", "period_us"),
                    // Noise resets memories, which hides a part of the leak.
                    "background_on_hz" => Some(value.estimate.clamp(off, off + leak)),
                    "background_off_hz" => Some(off),
                    _ => None,
                };
                let is_true = truth.is_some_and(|truth| holds(&value, truth));
                assert!(is_true, "{name}: {} is {value:?}, not {truth:?}", quantity.name);
            }
        }
        for name in ["threshold_ratio", "background_on_hz", must] {
            known(&report, name);
        }
        let sensor = SensorConfig::from_toml(&report.preset()).unwrap();
        assert_eq!(sensor, report.sensor());
        SensorModel::from_config(&sensor).unwrap();
    }
}

#[test]
fn halves_and_mirror_are_one_camera_and_a_longer_time_scales_times_alone() {
    let size = SensorSize { width: 32, height: 24 };
    let camera = |noise_hz: f64| {
        let mut config = SensorConfig::default();
        config.set("level_crossing", "threshold_on", 0.12).unwrap();
        config.set("level_crossing", "threshold_off", 0.15).unwrap();
        config.effects.extend([
            effect("refractory", "period_us", 800.0),
            effect("shot_noise_poisson", "rate_hz", noise_hz),
        ]);
        config
    };
    // Dark pixels are noisy, which shows the refractory period.
    let recordings = [
        ("pan", seen(&camera(0.2), size, true, 2.0)),
        ("dark", seen(&camera(200.0), size, false, 1.0)),
    ];
    let changed = |change: &dyn Fn(&EventStream) -> EventStream| {
        report_of(&recordings.each_ref().map(|(name, events)| (*name, change(events))))
    };
    let whole = changed(&EventStream::clone);
    for (name, truth) in [("threshold_ratio", 0.8), ("refractory_us", 800.0)] {
        let value = known(&whole, name);
        assert!(holds(&value, truth), "{name}: {value:?}, not {truth}");
    }
    let half = |events: &EventStream, part: i64| {
        let middle = events.t()[events.len() - 1].0 / 2;
        events.slice(TimeWindow { start: Micros(part * middle), end: Micros((part + 1) * middle) })
    };
    let each = |events: &EventStream, change: &dyn Fn(Event) -> Event| {
        EventStream::from_events(events.sensor(), events.iter().map(change)).unwrap()
    };
    let mirror = |event: Event| Event { x: size.width - 1 - event.x, ..event };
    let slower = |event: Event| Event { t: Micros(event.t.0 * 11 / 10), ..event };
    let check = |change: &str, longer: f64, of: &dyn Fn(&EventStream) -> EventStream| {
        let other = changed(of);
        for (name, scale) in [("threshold_ratio", 1.0), ("refractory_us", longer)] {
            let (one, other) = (known(&whole, name), known(&other, name));
            let apart = (other.estimate - scale * one.estimate).abs();
            let is_same = apart <= reach(&other).hypot(scale * reach(&one));
            assert!(is_same, "{change}: {name} {other:?}, not {one:?}");
        }
    };
    check("first half", 1.0, &|events| half(events, 0));
    check("second half", 1.0, &|events| half(events, 1));
    check("mirror", 1.0, &|events| each(events, &mirror));
    check("time x 1.1", 1.1, &|events| each(events, &slower));
}

fn effect(name: &str, key: &str, value: f64) -> EffectConfig {
    EffectConfig::new(name).with(key, value)
}

#[test]
fn a_scene_at_rest_shows_a_leak_beneath_noise_and_hot_pixels() {
    let size = SensorSize { width: 32, height: 24 };
    let mut config = SensorConfig::default();
    config.effects.extend([
        effect("leak_on", "rate_hz", 0.5),
        effect("shot_noise_poisson", "rate_hz", 0.2),
        effect("hot_pixels", "fraction", 0.01).with("median_hz", 50.0).with("on_share", 0.8),
    ]);
    let report = report_of(&[("static", seen(&config, size, false, 12.0))]);
    for (name, truth) in [("leak_hz", 0.5), ("hot_fraction", 0.01), ("background_off_hz", 0.1)] {
        let value = known(&report, name);
        assert!(holds(&value, truth), "{name}: {value:?}, not {truth}");
    }
}

#[test]
fn recordings_that_agree_are_pooled_and_others_contradict_each_other() {
    let size = SensorSize { width: 16, height: 12 };
    let dark = |name: &str, us: f64| {
        let mut config = SensorConfig::default();
        let noise = effect("shot_noise_poisson", "rate_hz", 80.0);
        config.effects.extend([noise, effect("refractory", "period_us", us)]);
        CameraRecording::new(name.to_owned(), seen(&config, size, false, 0.5)).unwrap()
    };
    let [a, b, again] = [("a", 3_000.0), ("b", 4_000.0), ("c", 3_000.0)].map(|(n, us)| dark(n, us));
    let report = |recordings: &[&CameraRecording]| {
        CameraReport::new(recordings.iter().map(|one| (*one).clone()).collect())
    };
    let alone = known(&report(&[&a]).unwrap(), "refractory_us");
    let pooled = known(&report(&[&a, &again]).unwrap(), "refractory_us");
    assert!(holds(&alone, 3_000.0), "{alone:?}");
    assert!((reach(&pooled) - reach(&alone) * 0.5_f64.sqrt()).abs() < 1e-6, "{pooled:?}");
    let report_of_two = report(&[&a, &b]).unwrap();
    let apart = report_of_two.quantity("refractory_us").unwrap();
    assert!(apart.value.is_none() && apart.why.as_ref().unwrap().contains("contradictory: "));
    let refused = report(&[&a, &a]).unwrap_err().to_string();
    assert_eq!(refused, "recording: a: given twice");
}

use std::collections::BTreeMap;

use evpose_core::{CounterRng, Event, EventStream, Micros, Plane, Polarity, SensorSize};
use evpose_sensor::{EffectConfig, STAGES, SensorConfig, SensorModel};

use super::scene_free::test_recording;
use super::*;

const SIZE: SensorSize = SensorSize { width: 32, height: 24 };
/// Enough for a p-value of 0.05 although one surrogate is an outlier.
const REPLICATES: usize = 39;

/// Poisson events at `rate_hz` a pixel, most of them ON.
fn poisson(size: SensorSize, rate_hz: f64, seconds: f64, seed: u64) -> EventStream {
    let mut rng = CounterRng::new(seed, "poisson", 0);
    let mut t_s = 0.0;
    let mut events = Vec::new();
    loop {
        t_s -= f64::from(rng.unit()).ln() / (rate_hz * size.pixels() as f64);
        if t_s >= seconds {
            return EventStream::from_events(size, events).unwrap();
        }
        let (x, y) = (rng.below(size.width.into()) as u16, rng.below(size.height.into()) as u16);
        let polarity = Polarity::from_on(rng.chance(0.6));
        events.push(Event { t: Micros::from_seconds(t_s), x, y, polarity });
    }
}

/// A blob that moves to and fro on the left of a scene at rest.
fn blob(x: f64, y: f64, t_s: f64) -> f64 {
    let (cx, cy) = (8.0 + 5.0 * (9.0 * t_s).sin(), 12.0 + 7.0 * (5.0 * t_s).cos());
    let squared = (x - cx).powi(2) + (y - cy).powi(2);
    0.15 + 0.02 * (x + y).sin() + 0.6 * (-squared / 9.0).exp()
}

fn recorded(effects: &[EffectConfig], seconds: f64) -> EventStream {
    let mut config = SensorConfig::default();
    // A readout of its own takes the place of the ideal one.
    if effects.iter().any(|effect| ["scanned_readout", "arbiter"].contains(&effect.name.as_str())) {
        config.effects.retain(|effect| effect.name != "ideal_readout");
    }
    config.effects.extend(effects.iter().cloned());
    seen(&config, seconds, blob)
}

/// The events of a sensor that looks at `light`, by column, row and seconds.
fn seen(config: &SensorConfig, seconds: f64, light: fn(f64, f64, f64) -> f64) -> EventStream {
    let mut run = SensorModel::from_config(config).unwrap().start(SIZE, 5);
    let mut all = EventStream::empty(SIZE);
    for k in 0..=(seconds * 500.0) as i64 {
        let mut plane = Plane::for_sensor(SIZE, 0.0);
        for (i, value) in plane.data_mut().iter_mut().enumerate() {
            *value = light((i % 32) as f64, (i / 32) as f64, k as f64 * 0.002) as f32;
        }
        for event in run.expose(&plane, Micros(k * 2_000)).unwrap().iter() {
            all.push(event).unwrap();
        }
    }
    all
}

/// Some background, as every camera has.
fn background() -> EffectConfig {
    EffectConfig::new("uniform_noise").with("on_hz", 0.5).with("off_hz", 0.3)
}

fn effect<'a>(findings: &'a SceneFreeFindings, name: &str) -> &'a SceneFreeEffect {
    let effect = findings.effects.iter().find(|effect| effect.name == name);
    effect.unwrap_or_else(|| panic!("no {name}: {findings}\n{:#?}", findings.statistics))
}

#[track_caller]
fn assert_parameter(effect: &SceneFreeEffect, name: &str, expected: f64, relative: f64) {
    let found = effect.parameters.iter().find(|p| p.name == name).unwrap();
    assert!((found.value / expected - 1.0).abs() <= relative, "{found:?}, expected {expected}");
    assert!(found.lo90 <= found.value && found.value <= found.hi90);
}

fn names(findings: &SceneFreeFindings) -> Vec<&'static str> {
    findings.effects.iter().map(|effect| effect.name).collect()
}

#[test]
fn a_surrogate_keeps_the_counts_of_every_pixel_polarity_and_window() {
    let events = recorded(&[background()], 0.3);
    for window_us in [5_000, 20_000, 100_000] {
        let counts = |events: &EventStream| {
            let mut counts = BTreeMap::new();
            for event in events.iter() {
                let key = (event.x, event.y, event.polarity.is_on(), event.t.0 / window_us);
                *counts.entry(key).or_insert(0) += 1;
            }
            counts
        };
        let surrogate = surrogates(&events, Micros(window_us), 7, 1);
        assert_eq!(counts(&surrogate), counts(&events));
        assert_ne!(surrogate, events);
        assert_eq!(surrogate, surrogates(&events, Micros(window_us), 7, 1));
        assert_ne!(surrogate, surrogates(&events, Micros(window_us), 7, 2));
        let inside = |t: &Micros| (events.t()[0]..=events.t()[events.len() - 1]).contains(t);
        assert!(surrogate.t().iter().all(inside));
    }
}

#[test]
fn times_in_a_surrogate_are_uniform_over_their_window() {
    let at = Event { t: Micros(7_500), x: 0, y: 0, polarity: Polarity::On };
    let ends = [0, 20_000].map(|t| Event { t: Micros(t), ..at });
    let events = [ends[0]].into_iter().chain([at; 4_000]).chain([ends[1]]);
    let surrogate =
        surrogates(&EventStream::from_events(SIZE, events).unwrap(), Micros(5_000), 1, 0);
    let inner = &surrogate.t()[1..4_001];
    assert!(inner.iter().all(|t| (5_000..10_000).contains(&t.0)));
    let mean = inner.iter().map(|t| t.0 as f64).sum::<f64>() / 4_000.0;
    // Four standard errors.
    assert!((mean - 7_499.5).abs() < 4.0 * 5_000.0 / (12.0f64 * 4_000.0).sqrt(), "{mean}");
}

#[test]
fn p_values_of_poisson_events_are_uniform() {
    const REPEATS: usize = 200;
    const REPLICATES: usize = 19;
    let size = SensorSize { width: 12, height: 12 };
    // The least p over all statistics, and that of each statistic.
    let mut least = vec![0usize; REPLICATES + 2];
    let mut single: BTreeMap<(&str, &str), Vec<f64>> = BTreeMap::new();
    for repeat in 0..REPEATS {
        let findings = test_recording(&poisson(size, 40.0, 0.15, repeat as u64), REPLICATES, 1);
        let p = findings.statistics.iter().filter_map(|row| row.adjusted_p).fold(1.0, f64::min);
        least[(p * (REPLICATES + 1) as f64).round() as usize] += 1;
        for row in &findings.statistics {
            single.entry((row.name, row.null)).or_default().push(row.p);
        }
    }
    // Kolmogorov's distance between steps: 1.63 / sqrt(n) is the one in a hundred.
    let distance = |counts: &[usize], n: usize| {
        let mut sum = 0;
        let steps = counts.iter().enumerate().map(|(rank, count)| {
            sum += count;
            (sum as f64 / n as f64 - rank as f64 / (REPLICATES + 1) as f64).abs()
        });
        steps.fold(0.0, f64::max)
    };
    let far = 1.63 / (REPEATS as f64).sqrt();
    assert!(distance(&least, REPEATS) < far, "{least:?}");
    for (name, all) in single {
        let small = all.iter().filter(|p| **p <= 0.1 + 1e-9).count() as f64;
        let n = all.len() as f64;
        // No statistic is too often deviant: four standard deviations of a count.
        assert!(small <= 0.1 * n + 4.0 * (0.09 * n).sqrt() + 1.0, "{name:?}: {small} of {n}");
    }
}

#[test]
fn nothing_is_found_in_scenes_seen_by_the_ideal_sensor() {
    let grating = |x: f64, _: f64, t_s: f64| 0.3 + 0.2 * (0.8 * (x - 40.0 * t_s)).sin();
    let ramp = |x: f64, y: f64, t_s: f64| (0.1 + 0.005 * (x + y)) * (1.5 * (6.0 * t_s).sin()).exp();
    let bar = |x: f64, y: f64, t_s: f64| {
        let (sin, cos) = (8.0 * t_s).sin_cos();
        let across = (x - 16.0) * cos + (y - 12.0) * sin;
        if across.abs() < 2.0 { 0.8 } else { 0.1 }
    };
    let texture = |x: f64, y: f64, t_s: f64| {
        let (x, y) = (x + 30.0 * t_s, y - 17.0 * t_s);
        0.3 + 0.1 * (0.9 * x + 0.3 * y).sin() + 0.1 * (0.5 * x - 1.1 * y + 1.0).sin()
    };
    let scenes: [fn(f64, f64, f64) -> f64; 5] = [blob, grating, ramp, bar, texture];
    for (i, scene) in scenes.into_iter().enumerate() {
        for noisy in [false, true] {
            let mut config = SensorConfig::default();
            config.effects.extend(noisy.then(background));
            let mismatch = EffectConfig::new("threshold_mismatch").with("sigma", 0.03);
            config.effects.push(mismatch);
            let findings = test_recording(&seen(&config, 1.5, scene), REPLICATES, 1);
            let names = names(&findings);
            // Noise may be indistinguishable from slow motion.
            let is_known = |name: &&str| noisy && *name == "uniform_noise";
            assert!(names.iter().all(is_known), "scene {i}, {noisy}: {findings}");
        }
    }
}

#[test]
fn hot_pixels_are_found_at_their_places() {
    let events = recorded(&[background()], 1.5);
    let mut all: Vec<Event> = events.iter().collect();
    let places = [(3u16, 4u16), (9, 12), (20, 20), (30, 1)];
    let mut rng = CounterRng::new(1, "hot", 0);
    for (x, y) in places {
        for _ in 0..150 {
            let t = Micros(rng.below(1_500_000) as i64);
            all.push(Event { t, x, y, polarity: Polarity::On });
        }
    }
    all.sort_by_key(|event| event.t);
    let findings = test_recording(&EventStream::from_events(SIZE, all).unwrap(), REPLICATES, 1);
    let hot = effect(&findings, "hot_pixels");
    assert!(places.iter().all(|place| hot.pixels.contains(place)), "{:?}", hot.pixels);
    assert_eq!(hot.pixels.len(), places.len());
    assert_parameter(hot, "median_hz", 100.0, 0.1);
    assert_parameter(hot, "fraction", 4.0 / 768.0, 1e-9);
}

#[test]
fn dead_pixels_are_found_at_their_places() {
    let places = [(5u16, 6u16), (22, 17)];
    let events = poisson(SIZE, 30.0, 1.5, 3);
    let alive = events.iter().filter(|event| !places.contains(&(event.x, event.y)));
    let findings = test_recording(&EventStream::from_events(SIZE, alive).unwrap(), REPLICATES, 1);
    assert_eq!(effect(&findings, "dead_pixels").pixels, places);
}

/// With its parameters, beside another that is there, and without one that it might be taken for.
#[test]
fn an_effect_that_leaves_a_mark_is_found_and_no_other() {
    let effect_of = |name: &str, params: &[(&str, f64)]| {
        params.iter().fold(EffectConfig::new(name), |effect, (key, value)| effect.with(key, *value))
    };
    let shot_noise = |rate_hz: f64| effect_of("shot_noise_poisson", &[("rate_hz", rate_hz)]);
    // Of each parameter also the relative tolerance.
    for (name, params, beside, seconds, other) in [
        ("refractory", &[("period_us", 3_000.0, 0.02)][..], Some(shot_noise(60.0)), 1.0, None),
        (
            "leak_on",
            &[("rate_hz", 4.0, 0.05), ("jitter", 0.1, 0.4)],
            None,
            4.0,
            Some("uniform_noise"),
        ),
        ("uniform_noise", &[("on_hz", 3.0, 0.1), ("off_hz", 0.5, 0.2)], None, 2.0, Some("leak_on")),
        ("arbiter", &[("rate_hz", 1e5, 0.03)], Some(shot_noise(40.0)), 1.5, None),
    ] {
        let given: Vec<_> = params.iter().map(|(key, value, _)| (*key, *value)).collect();
        let effects: Vec<_> = [effect_of(name, &given)].into_iter().chain(beside).collect();
        let findings = test_recording(&recorded(&effects, seconds), REPLICATES, 1);
        for (key, value, relative) in params {
            assert_parameter(effect(&findings, name), key, *value, *relative);
        }
        assert!(other.is_none_or(|other| !names(&findings).contains(&other)), "{findings}");
    }
}

#[test]
fn noise_of_the_photoreceptor_alternates() {
    let noise =
        EffectConfig::new("photoreceptor_noise").with("sigma", 0.07).with("cutoff_hz", 60.0);
    let findings = test_recording(&recorded(&[noise], 2.0), REPLICATES, 1);
    effect(&findings, "photoreceptor_noise");
}

#[test]
fn a_lamp_is_found_by_its_frequency() {
    let lamp = EffectConfig::new("lamp_flicker").with("frequency_hz", 100.0).with("depth", 0.25);
    let findings = test_recording(&recorded(&[lamp, background()], 1.5), REPLICATES, 1);
    assert_parameter(effect(&findings, "lamp_flicker"), "frequency_hz", 100.0, 0.01);
    assert!(!names(&findings).contains(&"refractory"), "{findings}");
}

#[test]
fn a_scan_is_found_with_its_period_axis_and_direction() {
    for (axis, direction, words) in
        [("rows", "forward", "rows, forward"), ("columns", "backward", "columns, backward")]
    {
        let scan = EffectConfig::new("scanned_readout")
            .with("period_us", 1_370.0)
            .with("axis", axis)
            .with("direction", direction);
        let findings = test_recording(&recorded(&[scan, background()], 1.5), REPLICATES, 1);
        let scan = effect(&findings, "scanned_readout");
        assert_eq!(scan.variant, Some(words));
        assert_parameter(scan, "period_us", 1_370.0, 1e-3);
        let names = names(&findings);
        assert!(!names.contains(&"refractory") && !names.contains(&"timestamp_quantisation"));
    }
}

#[test]
fn a_coarse_clock_is_found_whole_or_not() {
    for period_us in [50.0, 1_000.0, 333.3] {
        let clock = EffectConfig::new("timestamp_quantisation").with("period_us", period_us);
        let findings = test_recording(&recorded(&[clock, background()], 1.5), REPLICATES, 1);
        let clock = effect(&findings, "timestamp_quantisation");
        assert_parameter(clock, "period_us", period_us, 1e-3);
        assert!(!names(&findings).contains(&"scanned_readout"));
    }
}

#[test]
fn a_ceiling_of_the_rate_is_found() {
    let control = EffectConfig::new("event_rate_control")
        .with("rate_hz", 1e5)
        .with("window_us", 1_000.0)
        .with("drop", "late");
    let lively = |x: f64, y: f64, t_s: f64| 0.3 + 0.25 * (0.9 * x + 0.5 * y + 40.0 * t_s).sin();
    let mut config = SensorConfig::default();
    config.effects.extend([control, background()]);
    let findings = test_recording(&seen(&config, 1.5, lively), REPLICATES, 1);
    assert_parameter(effect(&findings, "event_rate_control"), "rate_hz", 1e5, 0.02);
}

#[test]
fn every_effect_of_the_catalogue_is_found_absent_untestable_or_a_model() {
    let findings = test_recording(&poisson(SIZE, 1.0, 1.0, 1), REPLICATES, 1);
    let mut reported = names(&findings);
    reported.extend(&findings.absent);
    reported.extend(findings.untestable.iter().map(|untestable| untestable.name));
    let known = |name: &&str| STAGES.iter().any(|stage| stage.name == *name);
    assert!(reported.iter().all(known), "{reported:?}");
    let mut once = reported.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), reported.len(), "{reported:?}");
    for name in ["psf_blur", "photoreceptor_lowpass", "clock_offset_drift"] {
        assert!(findings.untestable.iter().any(|untestable| untestable.name == name));
    }
}

#[test]
fn no_events_are_no_findings() {
    let findings = test_recording(&EventStream::empty(SIZE), 5, 1);
    assert!(findings.effects.is_empty() && findings.absent.is_empty(), "{findings}");
}

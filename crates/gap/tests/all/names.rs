//! Tests of names: with the effect a name passes, with the relative that it is confused with it is
//! demoted.

use evpose_core::{Micros, Plane, TimeWindow};
use evpose_gap::verdict::SignatureTest;
use evpose_gap::workflow::{prepared, test_name};
use evpose_gap::{Layout, LightSequence, Objective, ReferenceScene};
use evpose_sensor::{EffectConfig, STAGES, SensorConfig, Stage};

const WIDTH: usize = 48;
const HEIGHT: usize = 36;
const FRAMES: usize = 400;

/// A texture that moves fast in the upper and slowly in the lower part, at brightnesses from a
/// twentieth to all of white, and rests on the right.
fn light(k: usize, x: usize, y: usize) -> f32 {
    let t_s = k as f32 / 1000.0;
    let speed = if y < HEIGHT / 2 { 160.0 } else { 30.0 };
    let moved = if x < 34 { speed * t_s } else { 0.0 };
    let (u, v) = (x as f32 - moved, y as f32);
    let ground = 0.05 * 16_f32.powf(((7 * x + 11 * y) % 16) as f32 / 15.0);
    let ground = if x < 34 { 0.06 + 0.4 * (y % 12) as f32 / 12.0 } else { ground };
    // Fine and even bands.
    let fineness = if (y / 6).is_multiple_of(2) { 1.0 } else { 0.3 };
    ground * (0.7 * (fineness * u + 0.1 * v).sin() + 0.4 * (0.17 * u - 0.3 * v).cos()).exp()
}

fn scene() -> LightSequence {
    let plane = |k: usize| {
        let pixels = (0..WIDTH * HEIGHT).map(|i| light(k, i % WIDTH, i / WIDTH));
        Plane::from_vec(WIDTH, HEIGHT, pixels.collect()).unwrap()
    };
    LightSequence::new(1000.0, (0..FRAMES).map(plane).collect()).unwrap()
}

fn with(effects: &[EffectConfig]) -> SensorConfig {
    let mut model = prepared(&SensorConfig::default(), None).config;
    for effect in effects {
        let is_readout = |name: &str| {
            let stage = STAGES.find(name).map(|spec| spec.typical_stage());
            matches!(stage, Some(Ok(Stage::Readout(_))))
        };
        // There is one readout: that of the model gives way.
        model.effects.retain(|other| !(is_readout(&effect.name) && is_readout(&other.name)));
        model.insert(effect.clone());
    }
    model
}

/// The test of the last effect of `named`, in a recording of a camera with the effects `hidden`.
fn test(hidden: &[EffectConfig], named: &[EffectConfig]) -> SignatureTest {
    let scene = scene();
    let end = scene.duration() + Micros(1);
    let events = scene.events(&with(hidden), 77).unwrap();
    let reference = prepared(&SensorConfig::default(), None).reference;
    let known = ReferenceScene::new(scene, &reference).unwrap();
    let layout = Layout::of_all_probes();
    let window = TimeWindow { start: Micros(0), end };
    let objective = Objective::new(&known, &layout, &events, window, &reference, 5).unwrap();
    let (last, others) = named.split_last().unwrap();
    test_name(&objective, &with(named), &with(others), &last.name).unwrap().unwrap()
}

fn effect(name: &str, parameters: &[(&str, f64)]) -> EffectConfig {
    parameters.iter().fold(EffectConfig::new(name), |effect, (key, value)| effect.with(key, *value))
}

/// With the effect its name passes; in a recording of the relative it does not.
#[allow(clippy::needless_pass_by_value, reason = "calls read as tables")]
fn distinguishes(named: EffectConfig, relative: EffectConfig) {
    let own = test(std::slice::from_ref(&named), std::slice::from_ref(&named));
    assert!(own.passes && own.p < 0.05, "{}: {own:?}", named.name);
    let other = test(std::slice::from_ref(&relative), std::slice::from_ref(&named));
    assert!(!other.passes, "{} for {}: {other:?}", named.name, relative.name);
    assert!(!other.must.is_empty() && !other.shows.is_empty() && !other.recording.is_empty());
}

fn mismatch() -> EffectConfig {
    effect("threshold_mismatch", &[("sigma", 0.04)])
}

fn noise() -> EffectConfig {
    effect("threshold_temporal_noise", &[("sigma", 0.04)])
}

fn lowpass() -> EffectConfig {
    effect("photoreceptor_lowpass", &[("cutoff_hz", 60.0)])
}

fn latency() -> EffectConfig {
    effect("pixel_latency", &[("delay_us", 3000.0)])
}

fn leak() -> EffectConfig {
    effect("leak_on", &[("rate_hz", 6.0)])
}

fn cap() -> EffectConfig {
    effect("event_rate_control", &[("rate_hz", 6e4), ("window_us", 1000.0)])
}

#[test]
fn spread_between_pixels_stays_and_noise_in_time_does_not() {
    distinguishes(mismatch(), noise());
    distinguishes(noise(), mismatch());
}

#[test]
fn a_slow_photoreceptor_is_later_in_the_dark_and_a_latency_is_not() {
    distinguishes(lowpass(), latency());
    distinguishes(latency(), lowpass());
}

#[test]
fn a_refractory_period_leaves_no_short_interval() {
    distinguishes(effect("refractory", &[("period_us", 20_000.0)]), lowpass());
}

#[test]
fn dead_pixels_are_silent_throughout_and_a_cap_on_the_rate_loses_events_of_all() {
    let dead = effect("dead_pixels", &[("fraction", 0.08)]);
    distinguishes(dead.clone(), cap());
    distinguishes(cap(), dead);
}

#[test]
fn hot_pixels_are_hot() {
    let hot = effect("hot_pixels", &[("fraction", 0.03), ("median_hz", 60.0), ("on_share", 0.5)]);
    distinguishes(hot, effect("uniform_noise", &[("on_hz", 1.0), ("off_hz", 1.0)]));
}

#[test]
fn a_leak_makes_on_events_alone_and_one_by_light_more_in_light() {
    distinguishes(leak(), effect("uniform_noise", &[("on_hz", 4.0), ("off_hz", 4.0)]));
    distinguishes(effect("parasitic_photo_leak", &[("hz_per_white", 10.0)]), leak());
}

#[test]
fn a_drift_grows() {
    distinguishes(effect("clock_offset_drift", &[("drift_ppm", 4_000.0)]), latency());
}

#[test]
fn a_scan_is_locked_to_its_lines_and_a_clock_is_not() {
    let grid = effect("timestamp_quantisation", &[("period_us", 5_000.0)]);
    distinguishes(effect("scanned_readout", &[("period_us", 5_000.0)]), grid.clone());
    distinguishes(grid, effect("timestamp_jitter", &[("sigma_us", 1_000.0)]));
}

#[test]
fn a_delay_shorter_than_a_visit_of_the_readout_is_none() {
    let scan = || effect("scanned_readout", &[("period_us", 10_000.0)]);
    let short = || [scan(), latency()];
    let masked = test(&short(), &short());
    assert!(!masked.passes && masked.must.contains("readout"), "{masked:?}");
    let long = || [scan(), effect("pixel_latency", &[("delay_us", 18_000.0)])];
    assert!(!test(&long(), &long()).must.contains("readout"));
}

#[test]
fn scattered_stamps_are_no_shifted_ones() {
    let late = effect("pixel_latency", &[("delay_us", 1_000.0)]);
    distinguishes(effect("timestamp_jitter", &[("sigma_us", 1_000.0)]), late);
}

#[test]
fn a_bus_delays_and_orders_busy_moments() {
    let bus = effect("arbiter", &[("rate_hz", 6e4)]);
    distinguishes(bus, latency());
}

#[test]
fn a_lamp_has_a_line() {
    let lamp = effect("lamp_flicker", &[("frequency_hz", 100.0), ("depth", 0.2)]);
    distinguishes(lamp, leak());
}

#[test]
fn glare_takes_contrast_in_the_dark_and_blur_on_fine_structure() {
    distinguishes(effect("veiling_glare", &[("fraction", 0.3)]), latency());
    distinguishes(effect("psf_blur", &[("sigma_px", 1.0)]), latency());
}

#[test]
fn a_wrong_reset_changes_the_step_to_the_next_event() {
    distinguishes(effect("reset_overshoot", &[("fraction", 0.3)]), noise());
}

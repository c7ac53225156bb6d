//! Time of a sensor chain per pixel and step, on one core, from frames in memory.
//!
//! `cargo run --release -p evpose-sensor --example bench_sensor [seconds] [part of a name]`

#![allow(clippy::print_stdout, reason = "the output of a program")]

use std::time::Instant;

use evpose_core::{Micros, Plane, SensorSize};
use evpose_sensor::{EffectConfig, SensorConfig, SensorError, SensorModel};

const SIZE: SensorSize = SensorSize::DAVIS240C;
const FRAMES: usize = 64;
const STEP_US: i64 = 1_000;

/// A textured disc that moves over a textured ground: edges of both signs at all slopes.
fn frame(index: usize) -> Plane<f32> {
    let mut plane = Plane::for_sensor(SIZE, 0.0);
    let width = usize::from(SIZE.width);
    // Back and forth, so that the sequence can be repeated without a jump.
    let half = FRAMES / 2;
    let way = if index < half { index } else { FRAMES - index } as f32;
    let (cx, cy) = (70.0 + 0.8 * way, 75.0 + 0.35 * way);
    for (i, y) in plane.data_mut().iter_mut().enumerate() {
        let (px, py) = ((i % width) as f32, (i / width) as f32);
        let ground = 0.25 + 0.1 * (0.11 * px).sin() * (0.07 * py).cos();
        let (dx, dy) = (px - cx, py - cy);
        let disc = 0.55 + 0.2 * (0.35 * dx).sin() * (0.27 * dy).sin();
        // An edge two pixels wide, as a lens gives it.
        let inside = (0.5 * (45.0 - dx.hypot(dy)) + 0.5).clamp(0.0, 1.0);
        *y = ground + (disc - ground) * inside;
    }
    plane
}

fn with(effects: &[EffectConfig]) -> SensorConfig {
    let mut config = SensorConfig::default();
    config.effects.extend_from_slice(effects);
    config
}

/// Thresholds that nothing reaches: what pixels cost without events.
fn quiet() -> SensorConfig {
    let crossing = EffectConfig::new("level_crossing");
    let effects = vec![crossing.with("threshold_on", 5.0).with("threshold_off", 5.0)];
    SensorConfig { effects }
}

fn mismatch() -> EffectConfig {
    EffectConfig::new("threshold_mismatch").with("sigma", 0.02)
}

fn lowpass() -> EffectConfig {
    EffectConfig::new("photoreceptor_lowpass").with("cutoff_hz", 300.0).with("dark_light", 0.08)
}

fn leak() -> EffectConfig {
    EffectConfig::new("leak_on").with("rate_hz", 0.1).with("spread_decades", 0.1)
}

fn shot() -> EffectConfig {
    let shot = EffectConfig::new("shot_noise_poisson").with("rate_hz", 5.0);
    shot.with("spread_decades", 0.1).with("light_slope", 0.75)
}

fn refractory() -> EffectConfig {
    EffectConfig::new("refractory").with("period_us", 500.0)
}

fn bench(name: &str, config: &SensorConfig, seconds: f64) -> Result<(), SensorError> {
    let frames: Vec<Plane<f32>> = (0..FRAMES).map(frame).collect();
    let mut run = SensorModel::from_config(config)?.start(SIZE, 1);
    let mut now = 0;
    let mut pass = || -> Result<(f64, usize), SensorError> {
        let begin = Instant::now();
        let mut events = 0;
        for frame in &frames {
            events += run.expose(frame, Micros(now))?.len();
            now += STEP_US;
        }
        let per_step = (FRAMES * SIZE.pixels()) as f64;
        Ok((begin.elapsed().as_secs_f64() * 1e9 / per_step, events))
    };
    for _ in 0..3 {
        pass()?;
    }
    let begin = Instant::now();
    let mut times = Vec::new();
    let mut events = 0;
    while begin.elapsed().as_secs_f64() < seconds || times.len() < 5 {
        let (ns, count) = pass()?;
        times.push(ns);
        events += count;
    }
    times.sort_by(f64::total_cmp);
    let share = events as f64 / (times.len() * FRAMES * SIZE.pixels()) as f64;
    println!(
        "{name:24} min {:6.2}  median {:6.2} ns per pixel and step, {:5.2} % events",
        times[0],
        times[times.len() / 2],
        100.0 * share,
    );
    Ok(())
}

fn main() -> Result<(), SensorError> {
    let only = std::env::args().nth(2);
    let seconds = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(2.0);
    let all = [mismatch(), lowpass(), leak(), shot(), refractory()];
    for (name, config) in [
        ("ideal", with(&[])),
        ("no events", quiet()),
        ("thresholds, mismatch", with(&[mismatch()])),
        ("+ low-pass", with(&[mismatch(), lowpass()])),
        ("+ leak", with(&[mismatch(), leak()])),
        ("+ shot noise", with(&[mismatch(), shot()])),
        ("+ refractory", with(&[mismatch(), refractory()])),
        ("all of them", with(&all)),
        ("eventhands", SensorConfig::preset("eventhands")?),
        ("v2e-clean", SensorConfig::preset("v2e-clean")?),
        ("v2e-noisy", SensorConfig::preset("v2e-noisy")?),
        ("davis346", SensorConfig::preset("davis346")?),
    ] {
        if only.as_ref().is_none_or(|only| name.contains(only.as_str())) {
            bench(name, &config, seconds)?;
        }
    }
    Ok(())
}

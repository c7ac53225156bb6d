//! Scenes and recordings that the tests of effects share.

use evpose_core::{Event, Micros, Plane, SensorSize};
use evpose_sensor::{EffectConfig, SensorConfig, SensorModel, SensorRun};

/// The ideal threshold, ln.
pub(crate) const C: f64 = 0.2;
/// Offset that the ideal sensor adds to light, relative to white.
pub(crate) const DARK: f64 = 1e-3;

pub(crate) fn size(width: u16, height: u16) -> SensorSize {
    SensorSize { width, height }
}

pub(crate) fn effect(name: &str) -> EffectConfig {
    EffectConfig::new(name)
}

/// The ideal sensor with these effects beside or instead of its own.
pub(crate) fn sensor(effects: &[EffectConfig], size: SensorSize, seed: u64) -> SensorRun {
    let config = SensorConfig { effects: effects.to_vec() };
    SensorModel::from_config(&config).unwrap().start(size, seed)
}

/// Luminance at which the ideal sensor has this log voltage.
pub(crate) fn light(log: f64) -> f64 {
    log.exp() - DARK
}

/// Shows `steps` steps of `step_us` behind a first exposure at time zero. The scene gives light
/// at column, row and seconds.
pub(crate) fn record(
    run: &mut SensorRun,
    steps: i64,
    step_us: i64,
    scene: impl Fn(usize, usize, f64) -> f64,
) -> Vec<Event> {
    let width = usize::from(run.size().width);
    let mut events = Vec::new();
    for k in 0..=steps {
        let t = Micros(k * step_us);
        let mut plane = Plane::for_sensor(run.size(), 0.0);
        for (i, y) in plane.data_mut().iter_mut().enumerate() {
            *y = scene(i % width, i / width, t.as_seconds()) as f32;
        }
        events.extend(run.expose(&plane, t).unwrap().iter());
    }
    events
}

/// Times in seconds of the events of each pixel, row by row.
pub(crate) fn times_by_pixel(events: &[Event], size: SensorSize) -> Vec<Vec<f64>> {
    let mut times = vec![Vec::new(); size.pixels()];
    for event in events {
        let pixel = usize::from(event.y) * usize::from(size.width) + usize::from(event.x);
        times[pixel].push(event.t.as_seconds());
    }
    times
}

pub(crate) fn intervals(times: &[f64]) -> Vec<f64> {
    times.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

pub(crate) fn deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    mean(&values.iter().map(|v| (v - centre).powi(2)).collect::<Vec<_>>()).sqrt()
}

#[track_caller]
pub(crate) fn assert_near(actual: f64, expected: f64, tolerance: f64) {
    assert!((actual - expected).abs() <= tolerance, "{actual}, expected {expected} +- {tolerance}");
}

/// Of a Poisson count, four standard deviations.
#[track_caller]
pub(crate) fn assert_poisson(actual: usize, expected: f64) {
    assert_near(actual as f64, expected, 4.0 * expected.sqrt());
}

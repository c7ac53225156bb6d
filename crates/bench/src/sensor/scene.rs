//! Input and sensor models of the benchmark: frames in memory, and chains of effects.

use evpose_core::{Plane, SensorSize};
use evpose_sensor::{EffectConfig, SensorConfig};

/// The published sensor of EventHands.
pub(super) const SIZE: SensorSize = SensorSize::DAVIS240C;
/// Frames per second.
pub(super) const FPS: u32 = 1_000;
/// Frames of the sequence, which ends where it begins.
pub(super) const FRAMES: usize = 64;

/// A textured disc that moves over a textured ground, in code values of 0 to 255: edges of both
/// signs at all slopes.
pub(super) fn codes(index: usize) -> Vec<u8> {
    let width = usize::from(SIZE.width);
    // Back and forth, so that the sequence can be repeated without a jump.
    let half = FRAMES / 2;
    let way = if index < half { index } else { FRAMES - index } as f32;
    let (cx, cy) = (70.0 + 0.8 * way, 75.0 + 0.35 * way);
    let code = |i: usize| {
        let (px, py) = ((i % width) as f32, (i / width) as f32);
        let ground = 0.25 + 0.1 * (0.11 * px).sin() * (0.07 * py).cos();
        let (dx, dy) = (px - cx, py - cy);
        let disc = 0.55 + 0.2 * (0.35 * dx).sin() * (0.27 * dy).sin();
        // An edge two pixels wide, as a lens gives it.
        let inside = (0.5 * (45.0 - dx.hypot(dy)) + 0.5).clamp(0.0, 1.0);
        (255.0 * (ground + (disc - ground) * inside)).round() as u8
    };
    (0..SIZE.pixels()).map(code).collect()
}

/// The frames as the sensor sees them, relative to white.
pub(super) fn frames() -> Vec<Plane<f32>> {
    let light = |index| {
        let mut plane = Plane::for_sensor(SIZE, 0.0);
        for (y, code) in plane.data_mut().iter_mut().zip(codes(index)) {
            *y = f32::from(code) / 255.0;
        }
        plane
    };
    (0..FRAMES).map(light).collect()
}

/// The ideal sensor with thresholds that differ from pixel to pixel by a tenth.
pub(super) fn thresholds() -> SensorConfig {
    with(&[mismatch()])
}

/// All that the noisy model of v2e has, in physical form: events where thresholds are crossed.
pub(super) fn all() -> SensorConfig {
    with(&[mismatch(), lowpass(), leak(), shot(), refractory()])
}

/// The ideal sensor with these effects.
fn with(effects: &[EffectConfig]) -> SensorConfig {
    let mut config = SensorConfig::default();
    config.effects.extend_from_slice(effects);
    config
}

/// Thresholds of 0.2 differ by 0.02.
fn mismatch() -> EffectConfig {
    EffectConfig::new("threshold_mismatch").with("sigma", 0.02)
}

/// A bandwidth in proportion to light.
fn lowpass() -> EffectConfig {
    EffectConfig::new("photoreceptor_lowpass").with("cutoff_hz", 300.0).with("dark_light", 0.08)
}

/// A leak of its own in every pixel.
fn leak() -> EffectConfig {
    EffectConfig::new("leak_on").with("rate_hz", 0.1).with("spread_decades", 0.1)
}

/// Shot noise that is strongest in the dark.
fn shot() -> EffectConfig {
    let shot = EffectConfig::new("shot_noise_poisson").with("rate_hz", 5.0);
    shot.with("spread_decades", 0.1).with("light_slope", 0.75)
}

/// Half a millisecond behind each event.
fn refractory() -> EffectConfig {
    EffectConfig::new("refractory").with("period_us", 500.0)
}

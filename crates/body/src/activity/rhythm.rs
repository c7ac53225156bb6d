//! Functions of time that motions are made of.

use std::f32::consts::TAU;

use evpose_core::CounterRng;

/// 0 below 0, 1 above 1, and level at both ends.
pub(super) fn ease(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (x * (6.0 * x - 15.0) + 10.0)
}

/// The part of a period that has passed, 0 to 1.
pub(super) fn part(t_s: f32, period_s: f32, offset: f32) -> f32 {
    (t_s / period_s + offset).rem_euclid(1.0)
}

/// From 0 to 1 and back within a part of a period: begins to rise at `times[0]`, is up from
/// `times[1]` to `times[2]`, and down again at `times[3]`.
pub(super) fn pulse(part: f32, times: [f32; 4]) -> f32 {
    let [rise, up, fall, down] = times;
    if part < up {
        ease((part - rise) / (up - rise))
    } else {
        1.0 - ease((part - fall) / (down - fall))
    }
}

/// A slow irregular motion of standard deviation about one: four sines of incommensurable
/// frequencies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sway {
    waves: [(f32, f32); 4],
}

impl Sway {
    /// With frequencies up to `fastest_hz`.
    pub(super) fn draw(rng: &mut CounterRng, fastest_hz: f32) -> Self {
        let waves = std::array::from_fn(|k| {
            let share = 0.2 + 0.26 * k as f32;
            (TAU * fastest_hz * share * rng.uniform(0.8, 1.0), rng.uniform(0.0, TAU))
        });
        Self { waves }
    }

    /// Its value at a time.
    pub(super) fn at(&self, t_s: f32) -> f32 {
        let sum: f32 = self.waves.iter().map(|&(rate, phase)| (rate * t_s + phase).sin()).sum();
        sum * std::f32::consts::FRAC_1_SQRT_2
    }
}

/// 1 or -1, as a coin falls.
pub(super) fn side(rng: &mut CounterRng) -> f32 {
    if rng.chance(0.5) { 1.0 } else { -1.0 }
}

//! The change detector of DVS-Voltmeter: noise carries the pixel voltage over its thresholds.
//!
//! # Model
//! Between two exposures of code values `I_0` and `I_1` (0 to 255), `dt` microseconds apart, with
//! `A = (I_0 + I_1) / 2`, the voltage is a Brownian motion with drift
//! `mu = k1 (I_1 - I_0) / (dt (A + k2)) + k4 + k5 A` and diffusion
//! `s = k3 sqrt(A) / (A + k2) + k6`. From a residual `r` it leaves the interval (-1, 1) at the top
//! with probability `(exp(2 mu b / s²) - 1) / (exp(2 mu b / s²) - exp(-2 mu a / s²))`, `a = 1 - r`,
//! `b = 1 + r`, after an inverse Gaussian time of mean `e / mu'` and shape `(e / s)²`, `e` the
//! distance to that side and `mu'` the drift towards it. `r` is then zero; at the end of the step
//! it is as far towards that side as the step is long.
//!
//! Light is taken before the photoreceptor, whose law and filters are in `k1` to `k6`. The
//! thresholds, the leak and the noise are this stage's own; terms for thresholds do not act on it.
//!
//! # Source
//! Lin et al. 2022, equations 8 to 12. Inverse Gaussian: Michael, Schucany, Haas 1976.

use evpose_core::{Polarity, StageNoise};

use super::{Change, ChangeDetector, PixelStep};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Compares, Domain, NumberSpec, Parameter, StageSpec, Traits};

const K: NumberSpec = NumberSpec {
    name: "k1",
    // At the upper end of each there are some thousand events of a pixel in a millisecond.
    range: (1e-12, 500.0),
    typical: Some((1.0, 20.0)),
    doc: "contrast, as the number of events per e-fold of light",
    ..NumberSpec::LOG
};
const K1: Parameter = Parameter::Number(K);
const K2: Parameter = Parameter::Number(NumberSpec {
    name: "k2",
    unit: "codes",
    range: (0.01, 1e4),
    typical: Some((10.0, 50.0)),
    doc: "light at which the response is no longer logarithmic",
    ..K
});
const K3: Parameter = Parameter::Number(NumberSpec {
    name: "k3",
    unit: "/sqrt(us)",
    range: (1e-12, 0.05),
    typical: Some((5e-5, 5e-4)),
    doc: "photon shot noise",
    ..K
});
const K4: Parameter = Parameter::Number(NumberSpec {
    name: "k4",
    unit: "/us",
    range: (1e-12, 0.01),
    typical: Some((1e-8, 1e-6)),
    doc: "leak in the dark",
    ..K
});
const K5: Parameter = Parameter::Number(NumberSpec {
    name: "k5",
    unit: "/us",
    range: (1e-12, 1e-4),
    typical: Some((1e-9, 1e-7)),
    doc: "leak per light",
    ..K
});
const K6: Parameter = Parameter::Number(NumberSpec {
    name: "k6",
    unit: "/sqrt(us)",
    range: (1e-12, 0.1),
    typical: Some((1e-6, 1e-4)),
    doc: "noise in the dark",
    ..K
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "brownian_passage",
    domain: Domain::Detector,
    summary: "events where Brownian motion with drift reaches a threshold",
    formula: "mu = k1 dI / (dt (A + k2)) + k4 + k5 A; s = k3 sqrt(A) / (A + k2) + k6; |x| = 1",
    params: &[K1, K2, K3, K4, K5, K6],
    source: Citation {
        key: "Lin et al. 2022",
        text: "S. Lin, Y. Ma, Z. Guo, B. Wen: DVS-Voltmeter: Stochastic Process-Based Event \
               Simulator for Dynamic Vision Sensors, ECCV 2022",
    },
    signature: Signature {
        look_for: "a leak at rest whose intervals scatter with k3 and k6, and at the strong end \
                   noise of both signs; random times even of a steady change",
        probe: Probe::RestIntervals,
        strength: Strength::Rising(&["k3", "k6"]),
        beside: &[],
    },
    build: |settings| {
        let k = [&K1, &K2, &K3, &K4, &K5, &K6].map(|param| settings.number(param));
        Ok(Stage::Detector(Box::new(BrownianPassage { k })))
    },
};

const DRAWS: u32 = 64;

#[derive(Debug)]
struct BrownianPassage {
    k: [f64; 6],
}

impl ChangeDetector for BrownianPassage {
    fn thresholds(&self) -> [f32; 2] {
        [1.0, 1.0]
    }

    fn traits(&self) -> Traits {
        Traits { compares: Compares::Light, ..Traits::default() }
    }

    fn next(&self, pixel: &PixelStep, from_s: f64, noise: StageNoise) -> Option<Change> {
        let (step_us, left_us) =
            ((pixel.end_s - pixel.start_s) * 1e6, (pixel.end_s - from_s) * 1e6);
        if step_us <= 0.0 || left_us <= 0.0 || !pixel.threshold_on.is_finite() {
            return None;
        }
        let [k1, k2, k3, k4, k5, k6] = self.k;
        let light = 0.5 * (pixel.from + pixel.to);
        let drift = k1 * (pixel.to - pixel.from) / step_us / (light + k2) + k4 + k5 * light;
        let spread = k3 * light.sqrt() / (light + k2) + k6;
        // A fixed number of draws per event, so that one event does not shift those of the next.
        let mut draws =
            Draws { noise, pixel: pixel.pixel as usize, next: pixel.count.wrapping_mul(DRAWS) };
        // On a threshold the exit probability is 0/0.
        let residual = pixel.memory.clamp(-0.999_999, 0.999_999);
        let (up, down) = (1.0 - residual, 1.0 + residual);
        let is_on = draws.uniform() <= probability_up(drift, spread, up, down);
        let (polarity, way, towards) =
            if is_on { (Polarity::On, up, drift) } else { (Polarity::Off, down, -drift) };
        let hit_us = passage_time(way, towards, spread, &mut draws);
        if hit_us <= left_us {
            let t_s = from_s + hit_us * 1e-6;
            return Some(Change { t_s, polarity, count: 1, memory: 0.0 });
        }
        // The published simulator moves in a straight line towards the side drawn.
        let moved = way * left_us / hit_us;
        let memory = residual + if is_on { moved } else { -moved };
        Some(Change { t_s: pixel.end_s, polarity, count: 0, memory })
    }
}

/// Probability of leaving at the top, in a form that does not overflow.
fn probability_up(drift: f64, spread: f64, up: f64, down: f64) -> f64 {
    let rate = 2.0 * drift / (spread * spread);
    // Without drift, the shares of the distances; the formula below would be 0/0.
    if rate.abs() < 1e-12 {
        return down / (up + down);
    }
    if rate > 0.0 {
        // The mean of exp(-rate x) stays what it is until the exit.
        (-rate * down).exp_m1() / (-rate * (up + down)).exp_m1()
    } else {
        let all = (rate * (up + down)).exp();
        (all - (rate * up).exp()) / (all - 1.0)
    }
}

/// A time to the side at distance `way`, given that this side is reached.
fn passage_time(way: f64, drift: f64, spread: f64, draws: &mut Draws) -> f64 {
    let shape = (way / spread).powi(2);
    if drift == 0.0 {
        // Without drift the inverse Gaussian becomes the Levy distribution.
        let normal = draws.normal();
        return 2.0 * shape / (normal * normal).max(f64::MIN_POSITIVE);
    }
    let mean = way / drift;
    let normal = if drift > 0.0 {
        draws.normal()
    } else {
        // Against the drift the root below is real only beyond this value.
        draws.normal_beyond((-4.0 * way * drift).sqrt() / spread)
    };
    let y = normal * normal;
    let root = (4.0 * mean * shape * y + (mean * y).powi(2)).max(0.0).sqrt();
    let x = mean + mean / (2.0 * shape) * (mean * y - root);
    let time = if draws.uniform() <= mean / (mean + x) { x } else { mean * mean / x };
    if time.is_finite() { time.abs() } else { f64::MAX }
}

struct Draws {
    noise: StageNoise,
    pixel: usize,
    next: u32,
}

impl Draws {
    fn uniform(&mut self) -> f64 {
        self.next = self.next.wrapping_add(1);
        f64::from(self.noise.uniform(self.pixel, self.next))
    }

    fn normal(&mut self) -> f64 {
        let (radius, turn) = (self.uniform(), self.uniform());
        (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * turn).cos()
    }

    /// Normal, given that its size is above `limit`: Marsaglia's tail method, plain rejection
    /// where the tail is no tail.
    fn normal_beyond(&mut self, limit: f64) -> f64 {
        for _ in 0..DRAWS / 4 {
            // Marsaglia's method accepts less often than plain rejection there.
            if limit < 0.5 {
                let normal = self.normal();
                if normal.abs() >= limit {
                    return normal;
                }
            } else {
                let size = (limit * limit - 2.0 * self.uniform().ln()).sqrt();
                if self.uniform() * size <= limit {
                    return size;
                }
            }
        }
        limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exit_probability_has_its_limits() {
        assert!((probability_up(0.0, 1e-3, 0.7, 1.3) - 0.65).abs() < 1e-12);
        assert!((probability_up(1.0, 1e-3, 0.7, 1.3) - 1.0).abs() < 1e-12);
        assert!(probability_up(-1.0, 1e-3, 0.7, 1.3) < 1e-12);
        // The published form, where it does not overflow.
        let (mu, s, a, b) = (3e-7, 5e-4f64, 0.8, 1.2);
        let published = ((2.0 * mu * b / s / s).exp() - 1.0)
            / ((2.0 * mu * b / s / s).exp() - (-2.0 * mu * a / s / s).exp());
        assert!((probability_up(mu, s, a, b) - published).abs() < 1e-9);
    }

    #[test]
    fn passage_times_have_the_moments_of_the_inverse_gaussian() {
        let (way, drift, spread) = (1.0, 2e-3, 0.02);
        let n = 40_000;
        let times: Vec<f64> = (0..n)
            .map(|pixel| {
                let noise = StageNoise::new(4, SPEC.name, 1);
                passage_time(way, drift, spread, &mut Draws { noise, pixel, next: 0 })
            })
            .collect();
        let mean = times.iter().sum::<f64>() / n as f64;
        let variance = times.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / n as f64;
        let exact = (way / drift, way * spread * spread / drift.powi(3));
        assert!((mean - exact.0).abs() < 4.0 * (exact.1 / n as f64).sqrt(), "{mean}");
        assert!((variance / exact.1 - 1.0).abs() < 0.05, "{variance} {}", exact.1);
    }
}

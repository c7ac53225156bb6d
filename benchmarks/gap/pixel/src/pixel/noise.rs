//! Noise of the photodiode node: an Ornstein-Uhlenbeck voltage.
//!
//! Shot noise of the photocurrent and of the transistor that carries it away leave `k T / C` on the
//! node whatever the light; the light sets how fast it moves, `I / (C U_T)`. Steps and midpoints
//! are drawn from the process's exact transition and bridge, so that the first passage can be
//! followed down to a microsecond wherever the path comes near a threshold.

use crate::circuit::Circuit;
use crate::draw::{Purpose, Stream};
use crate::physics::{ELEMENTARY_CHARGE_C, FEMTO, node_rate_per_s, thermal_voltage_v};

/// Longest step in correlation times.
const LONGEST_STEP: f64 = 1.0;

/// Paths this unlikely to touch a threshold (natural logarithm) are not looked at closer.
const NEGLIGIBLE_LN: f64 = 16.0;

#[derive(Debug, Clone, Copy)]
pub(crate) struct NodeNoiseModel {
    variance: f64,
    white_per_s: f64,
    stream: Stream,
}

impl NodeNoiseModel {
    pub(crate) fn new(circuit: &Circuit, run_seed: u64, pixel: u32) -> Option<Self> {
        let noise = circuit.photoreceptor.noise?;
        let kelvin = circuit.temperature_k;
        Some(Self {
            variance: noise_variance(noise.excess_factor, noise.node_ff, kelvin),
            white_per_s: node_rate_per_s(
                circuit.photoreceptor.white_current_a,
                noise.node_ff,
                kelvin,
            ),
            stream: Stream::new(run_seed, Purpose::Photoreceptor, u64::from(pixel)),
        })
    }

    /// A value of the settled process, for the start.
    pub(crate) fn settled(&self) -> f64 {
        self.variance.sqrt() * self.stream.normal(u64::MAX)
    }

    /// Whether `dt_s` is too long a step at this logarithm of the current.
    pub(crate) fn is_coarse(&self, log_current: f64, dt_s: f64) -> bool {
        self.white_per_s * log_current.exp() * dt_s > LONGEST_STEP
    }

    /// The value at clock tick `tick`, `dt_s` after the value `from`.
    pub(crate) fn step(&self, from: f64, log_current: f64, dt_s: f64, tick: u64) -> f64 {
        let kept = (-self.white_per_s * log_current.exp() * dt_s).exp();
        from * kept + (self.variance * (1.0 - kept * kept)).sqrt() * self.stream.normal(tick)
    }

    /// The value at tick `tick`, in the middle of `dt_s` between two known values.
    pub(crate) fn midpoint(&self, ends: [f64; 2], log_current: f64, dt_s: f64, tick: u64) -> f64 {
        let half = 0.5 * self.white_per_s * log_current.exp() * dt_s;
        let mean = 0.5 * (ends[0] + ends[1]) / half.cosh();
        mean + (self.variance * half.tanh()).sqrt() * self.stream.normal(tick)
    }

    /// Whether a path with these distances to a threshold at its ends surely stays on this side:
    /// a Brownian bridge touches with probability `exp(-2 d0 d1 / (s^2 dt))`, `s^2 = 2 a sigma^2`.
    pub(crate) fn stays(&self, distances: [f64; 2], log_current: f64, dt_s: f64) -> bool {
        let spread = 2.0 * self.white_per_s * log_current.exp() * self.variance * dt_s;
        distances[0] > 0.0
            && distances[1] > 0.0
            && 2.0 * distances[0] * distances[1] > NEGLIGIBLE_LN * spread
    }
}

/// Variance of the node's voltage in squared e-folds: `excess (k T / C) / U_T^2`.
pub(crate) fn noise_variance(excess_factor: f64, node_ff: f64, temperature_k: f64) -> f64 {
    excess_factor * ELEMENTARY_CHARGE_C / (node_ff * FEMTO * thermal_voltage_v(temperature_k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circuit::NodeNoise;

    #[test]
    fn steps_and_midpoints_have_the_variance_and_the_memory_of_the_process() {
        let mut circuit = Circuit::ideal();
        circuit.photoreceptor.noise = Some(NodeNoise { node_ff: 100.0, excess_factor: 4.0 });
        let noise = NodeNoiseModel::new(&circuit, 3, 0).expect("the noise is on");
        let rate = 10e-12 / (100e-15 * thermal_voltage_v(300.0));
        let dt_s = 0.7 / rate;
        let n = 200_000_u64;
        let (mut before, mut square, mut product, mut middle) = (noise.settled(), 0.0, 0.0, 0.0);
        for k in 0..n {
            let after = noise.step(before, 0.0, dt_s, 2 * k);
            let mid = noise.midpoint([before, after], 0.0, dt_s, 2 * k + 1);
            square += after * after;
            product += after * before;
            middle += mid * before;
            before = after;
        }
        let variance = 4.0 * ELEMENTARY_CHARGE_C / (100e-15 * thermal_voltage_v(300.0));
        let share = |sum: f64| sum / n as f64 / variance;
        assert!((share(square) - 1.0).abs() < 0.02);
        assert!((share(product) - (-0.7_f64).exp()).abs() < 0.02);
        assert!((share(middle) - (-0.35_f64).exp()).abs() < 0.02);
    }
}

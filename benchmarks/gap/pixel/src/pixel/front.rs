//! The photoreceptor: light in, voltage out, in e-folds (multiples of `U_T / kappa`).
//!
//! The photocurrent charges the node, a subthreshold transistor discharges it:
//! `C dv/dt = I_ph(t) - I_0 e^v` in units of `U_T` (Lichtsteiner et al. 2008 give the small-signal
//! form). With `u = e^(-v)` this is linear, `du/dt = k (1 - i(t) u)`, where `i` is the current
//! relative to white and `k = I_white / (C U_T)`: the node follows a step up faster than a step
//! down, and its bandwidth is proportional to light. Over a short segment `1/i` is taken as linear
//! and the equation is solved exactly. The source follower and the slow feedback are linear poles
//! and are solved exactly for a linear input.

use crate::circuit::{Bend, Circuit};
use crate::physics::{FEMTO, KAPPA, node_rate_per_s, thermal_voltage_v};
use crate::scene::DARKEST_LN;

/// Constants of the photoreceptor: rates in 1/s.
#[derive(Debug, Clone)]
pub(crate) struct Front {
    added_share: f64,
    bend: Option<Bend>,
    node_white_per_s: Option<f64>,
    follower_per_s: Option<f64>,
    highpass_per_s: Option<f64>,
}

/// Voltages of the photoreceptor in e-folds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrontState {
    /// `e^(-v)` of the photodiode node.
    inverse: f64,
    node: f64,
    follower: f64,
    slow: f64,
}

impl FrontState {
    /// Voltage at the change amplifier's input.
    #[inline]
    pub(crate) fn output(&self) -> f64 {
        self.follower - self.slow
    }
}

impl Front {
    pub(crate) fn new(circuit: &Circuit) -> Self {
        let receptor = &circuit.photoreceptor;
        let kelvin = circuit.temperature_k;
        let white_a = receptor.white_current_a;
        Self {
            added_share: receptor.dark_current_fa * FEMTO / white_a + receptor.added_share,
            bend: receptor.bend,
            node_white_per_s: receptor.node_ff.map(|ff| node_rate_per_s(white_a, ff, kelvin)),
            follower_per_s: receptor
                .follower
                .map(|f| KAPPA * node_rate_per_s(f.bias_a, f.load_pf * 1e3, kelvin)),
            highpass_per_s: receptor
                .highpass
                .map(|h| h.bias_a / (h.coupling_pf * 1e-12 * thermal_voltage_v(kelvin))),
        }
    }

    /// Logarithm of the photocurrent and all that is added to it, for the logarithm of light.
    #[inline]
    pub(crate) fn log_current(&self, log_light: f64) -> f64 {
        if self.added_share > 0.0 { (log_light.exp() + self.added_share).ln() } else { log_light }
    }

    /// Voltage of the feedback transistor at a level of the node: its slope runs in a line from
    /// `1 - share` at the darkest light to `1 + share` at white.
    #[inline]
    fn bent(&self, node: f64) -> f64 {
        match self.bend {
            None => node,
            Some(Bend { share }) => {
                let middle = 0.5 * DARKEST_LN;
                node - 0.5 * share * (node - middle).powi(2) / middle
            }
        }
    }

    /// The photoreceptor after a long time at one light.
    pub(crate) fn settled(&self, log_current: f64) -> FrontState {
        let output = self.bent(log_current);
        FrontState {
            inverse: (-log_current).exp(),
            node: log_current,
            follower: output,
            slow: if self.highpass_per_s.is_some() { output } else { 0.0 },
        }
    }

    /// The state `dt_s` later, when the logarithm of the current went from `from` to `to`.
    #[inline]
    pub(crate) fn advance(&self, state: &FrontState, from: f64, to: f64, dt_s: f64) -> FrontState {
        let mut next = *state;
        next.node = to;
        if let Some(rate) = self.node_white_per_s {
            // The node is faster in more light.
            let mean_current = (0.5 * (from + to)).exp();
            let turns = rate * mean_current * dt_s;
            // In 1/current, its equation is linear.
            next.inverse = relax(state.inverse, (-from).exp(), (-to).exp(), turns);
            next.node = -next.inverse.ln();
        }
        next.follower = match self.follower_per_s {
            Some(rate) => {
                relax(state.follower, self.bent(state.node), self.bent(next.node), rate * dt_s)
            }
            None => self.bent(next.node),
        };
        if let Some(rate) = self.highpass_per_s {
            next.slow = relax(state.slow, state.follower, next.follower, rate * dt_s);
        }
        next
    }
}

/// A pole pulled along a straight line: `y' = a (x - y)`, `x` from `from` to `to` in `turns / a`.
#[inline]
fn relax(start: f64, from: f64, to: f64, turns: f64) -> f64 {
    if turns <= 0.0 {
        return start;
    }
    let left = (-turns).exp();
    // The quotient of a short step would lose its digits, so that its series stands in.
    let gone = if turns < 1e-5 { 1.0 - 0.5 * turns } else { (1.0 - left) / turns };
    start * left + to - from * left - (to - from) * gone
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circuit::{Follower, HighPass};

    #[test]
    fn the_node_answers_a_step_as_the_closed_form_says() {
        let mut circuit = Circuit::ideal();
        circuit.photoreceptor.node_ff = Some(60.0);
        let front = Front::new(&circuit);
        let rate = 10e-12 / (60e-15 * thermal_voltage_v(300.0));
        let (before, after, t_s) = (0.05_f64, 0.4_f64, 3e-4);
        let start = front.settled(before.ln());
        // In one segment and in many: the current is constant after the step.
        let once = front.advance(&start, after.ln(), after.ln(), t_s);
        let mut many = start;
        for _ in 0..50 {
            many = front.advance(&many, after.ln(), after.ln(), t_s / 50.0);
        }
        let inverse = 1.0 / after + (1.0 / before - 1.0 / after) * (-rate * after * t_s).exp();
        assert!((once.output() + inverse.ln()).abs() < 1e-9);
        assert!((many.output() + inverse.ln()).abs() < 1e-9);
    }

    #[test]
    fn the_follower_lags_a_ramp_by_its_time_constant() {
        let mut circuit = Circuit::ideal();
        circuit.photoreceptor.follower = Some(Follower { bias_a: 1e-9, load_pf: 5.0 });
        let front = Front::new(&circuit);
        let tau_s = 5e-12 * thermal_voltage_v(300.0) / (KAPPA * 1e-9);
        let slope = 20.0;
        let mut state = front.settled(0.0);
        let dt_s = 1e-4;
        for k in 0..200 {
            let t_s = f64::from(k) * dt_s;
            state = front.advance(&state, slope * t_s, slope * (t_s + dt_s), dt_s);
        }
        let lag = slope * 200.0 * dt_s - state.output();
        assert!((lag - slope * tau_s).abs() < 1e-9, "{lag}");
    }

    #[test]
    fn the_highpass_forgets_a_step_with_its_time_constant() {
        let mut circuit = Circuit::ideal();
        circuit.photoreceptor.highpass = Some(HighPass { bias_a: 1e-12, coupling_pf: 1.0 });
        let front = Front::new(&circuit);
        let tau_s = 1e-12 * thermal_voltage_v(300.0) / 1e-12;
        let mut state = front.advance(&front.settled(0.0), 1.0, 1.0, 0.0);
        assert!((state.output() - 1.0).abs() < 1e-12);
        state = front.advance(&state, 1.0, 1.0, tau_s);
        assert!((state.output() - (-1.0_f64).exp()).abs() < 1e-9);
    }
}

//! The labels of the benchmark: a circuit in the units of a catalogue of effects.
//!
//! Write `V_e = (C1 / C2) U_T / kappa` for the volts at the change amplifier's output that one
//! e-fold of light makes, and let currents be relative to the photocurrent at white, `I_w`.
//!
//! * Threshold: the comparator trips at `theta` volts, that is at a change of `ln I` by
//!   `C = theta / V_e`.
//! * `leak_on`: the junction moves the output by `I_leak / C2` volts per second towards ON. A
//!   quiet pixel fires each time it has gone one threshold: `rho = I_leak / (C2 theta_on)` Hz. The
//!   current doubles every few kelvins.
//! * `photoreceptor_lowpass`: the node's conductance is `I / U_T`, so its pole at white is
//!   `f_1 = I_w / (2 pi C_p U_T)` Hz and proportional to light. The source follower's
//!   transconductance is `kappa I_b / U_T`: `f_2 = kappa I_b / (2 pi C_L U_T)`.
//! * `photoreceptor_noise`: shot noise of two equal currents, `S_i = 4 q I`, on the conductance
//!   `I / U_T` and `C` integrates to `k T / C`; in e-folds `sigma = sqrt(F q / (C U_T))`, with
//!   bandwidth `I_w / (2 pi C U_T)` at white.
//! * `shot_noise_poisson`: the relative density of photon noise, `2 q / I`, over that of a floor
//!   `I_half`, makes the rate `R / (1 + I / I_half)`; `R` is the rate in darkness.
//! * `adaptive_highpass`: a transconductor `g = I_b / U_T` on the coupling capacitor forgets with
//!   `tau = C U_T / I_b`.
//! * `dark_current`: adds `I_d / I_w` to the luminance.
//! * `threshold_mismatch`: a log-normal spread `s` is `sigma_C = C sqrt(exp(s^2) - 1)` about the
//!   mean.
//! * `threshold_temporal_noise`: volts r.m.s. over `V_e`.
//! * `refractory`: `T_r = C dV / I`.
//! * `arbiter`: rows alone in a turn are served at `1 / (row + event)`, full rows at up to
//!   `1 / event`.
//! * `scanned_readout`: all columns take `T = W column`.
//! * Optics and clock are in catalogue units already.

mod stages;

use serde::Serialize;

use crate::circuit::Circuit;
use crate::effect::CameraStage;

/// Whether a term is an effect or only another value of what every camera has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TermKind {
    /// Something the ideal pixel does not do.
    Effect,
    /// Thresholds, background rates, zero of the clock.
    Parameter,
}

/// A value in catalogue units.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Name.
    pub name: &'static str,
    /// Value in `unit`.
    pub value: f64,
    /// Unit; `1` for a number without.
    pub unit: &'static str,
}

/// One thing in which a camera differs from its nominal description.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Term {
    /// Name in the catalogue, or of what no catalogue has.
    pub name: &'static str,
    /// Effect or parameter.
    pub kind: TermKind,
    /// Stage of the camera that the term belongs to.
    pub stage: CameraStage,
    /// Its values.
    pub parameters: Vec<Parameter>,
}

/// Nominal parameters of the camera, given beside every recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Nominal {
    /// ON threshold, `ln I`.
    #[serde(rename = "C_on")]
    pub c_on: f64,
    /// OFF threshold, `ln I`.
    #[serde(rename = "C_off")]
    pub c_off: f64,
    /// Spread of the thresholds over the pixels, `ln I`.
    #[serde(rename = "sigma_C")]
    pub sigma_c: f64,
    /// Rate of background ON events of a pixel, Hz.
    pub noise_on_hz: f64,
    /// Rate of background OFF events of a pixel, Hz.
    pub noise_off_hz: f64,
}

/// ON and OFF threshold of a circuit in `ln I`.
pub fn thresholds_ln(circuit: &Circuit) -> [f64; 2] {
    let efold_mv = circuit.output_volts_per_efold_v() * 1e3;
    [circuit.detector.threshold_on_mv / efold_mv, circuit.detector.threshold_off_mv / efold_mv]
}

/// Everything in which `circuit` differs from the ideal pixel with these nominal values.
pub fn terms(circuit: &Circuit, nominal: &Nominal) -> Vec<Term> {
    let mut terms = Vec::new();
    stages::optics(circuit, &mut terms);
    stages::photoreceptor(circuit, &mut terms);
    stages::detector(circuit, nominal, &mut terms);
    stages::background(circuit, nominal, &mut terms);
    stages::readout(circuit, &mut terms);
    stages::clock(circuit, &mut terms);
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{Purpose, Sequence};
    use crate::effect::{EFFECTS, STRENGTHS};

    fn nominal() -> Nominal {
        Nominal { c_on: 0.25, c_off: 0.25, sigma_c: 0.0, noise_on_hz: 0.0, noise_off_hz: 0.0 }
    }

    #[test]
    fn the_ideal_pixel_has_no_terms() {
        assert_eq!(terms(&Circuit::ideal(), &nominal()), []);
    }

    #[test]
    fn every_effect_is_one_term_under_its_name_and_stage_at_every_strength() {
        for effect in EFFECTS {
            for strength in 0..STRENGTHS {
                let mut circuit = Circuit::ideal();
                let mut draws = Sequence::new(1, Purpose::Plan, 2);
                effect.install(strength, &mut circuit, &mut draws);
                let terms = terms(&circuit, &nominal());
                assert_eq!(terms.len(), 1, "{}", effect.name());
                assert_eq!((terms[0].name, terms[0].stage), (effect.name(), effect.stage()));
                assert_eq!(terms[0].kind, TermKind::Effect);
            }
        }
    }

    #[test]
    fn thresholds_and_clock_are_parameters() {
        let mut circuit = Circuit::ideal();
        circuit.detector.threshold_on_mv *= 1.2;
        circuit.clock.offset_us = 2000.0;
        let terms = terms(&circuit, &nominal());
        assert_eq!(terms.len(), 2);
        assert!(terms.iter().all(|term| term.kind == TermKind::Parameter));
        assert!((terms[0].parameters[0].value - 0.3).abs() < 1e-9);
        assert!((terms[1].parameters[0].value - 0.002).abs() < 1e-12);
    }
}

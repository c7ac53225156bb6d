//! What a circuit means in the units of a catalogue of effects: the labels of the benchmark.
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
//!   `f_1 = I_w / (2 pi C_p U_T)` Hz and proportional to light. The source follower's transconductance
//!   is `kappa I_b / U_T`: `f_2 = kappa I_b / (2 pi C_L U_T)`.
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

use serde::Serialize;

use crate::circuit::{Access, Circuit, DetectorOddity, ReadoutOddity};
use crate::effect::Stage;
use crate::event::{HEIGHT, WIDTH};
use crate::physics::{FEMTO, KAPPA, node_rate_per_s, thermal_voltage_v};
use crate::pixel::noise_variance;

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
    /// Stage of the camera.
    pub stage: Stage,
    /// Its values.
    pub parameters: Vec<Parameter>,
}

/// What is nominal: told beside every recording.
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
    optics_terms(circuit, &mut terms);
    photoreceptor_terms(circuit, &mut terms);
    detector_terms(circuit, nominal, &mut terms);
    background_terms(circuit, nominal, &mut terms);
    readout_terms(circuit, &mut terms);
    clock_terms(circuit, &mut terms);
    terms
}

fn effect(name: &'static str, stage: Stage, parameters: Vec<Parameter>) -> Term {
    Term { name, kind: TermKind::Effect, stage, parameters }
}

fn value(name: &'static str, value: f64, unit: &'static str) -> Parameter {
    Parameter { name, value, unit }
}

fn optics_terms(circuit: &Circuit, terms: &mut Vec<Term>) {
    let optics = &circuit.optics;
    if let Some(lamp) = optics.lamp {
        let parameters = vec![
            value("frequency", lamp.ripple_hz, "Hz"),
            value("depth", lamp.ripple_share, "1"),
            value("phase", lamp.phase_rad, "rad"),
        ];
        terms.push(effect("lamp_flicker", Stage::Optics, parameters));
    }
    let single = [
        ("psf_blur", "sigma", optics.blur_sigma_px, "px"),
        ("lens_distortion", "k1", optics.distortion_k1, "1"),
        ("veiling_glare", "share", optics.scattered_share, "1"),
    ];
    for (name, parameter, number, unit) in single {
        if number != 0.0 {
            terms.push(effect(name, Stage::Optics, vec![value(parameter, number, unit)]));
        }
    }
}

fn photoreceptor_terms(circuit: &Circuit, terms: &mut Vec<Term>) {
    let (receptor, kelvin) = (&circuit.photoreceptor, circuit.temperature_k);
    let corner_hz = |ff| {
        node_rate_per_s(receptor.white_current_a, ff, kelvin) / std::f64::consts::TAU
    };
    let mut push = |name, parameters| terms.push(effect(name, Stage::Photoreceptor, parameters));
    if receptor.node_ff.is_some() || receptor.follower.is_some() {
        let mut parameters = Vec::new();
        if let Some(ff) = receptor.node_ff {
            parameters.push(value("corner_at_white", corner_hz(ff), "Hz"));
        }
        if let Some(follower) = receptor.follower {
            let rate = KAPPA * node_rate_per_s(follower.bias_a, follower.load_pf * 1e3, kelvin);
            parameters.push(value("second_pole", rate / std::f64::consts::TAU, "Hz"));
        }
        push("photoreceptor_lowpass", parameters);
    }
    if receptor.dark_current_fa > 0.0 {
        let share = receptor.dark_current_fa * FEMTO / receptor.white_current_a;
        push("dark_current", vec![value("equivalent_luminance", share, "1")]);
    }
    if let Some(noise) = receptor.noise {
        let sigma = noise_variance(noise.excess_factor, noise.node_ff, kelvin).sqrt();
        let bandwidth = value("bandwidth_at_white", corner_hz(noise.node_ff), "Hz");
        push("photoreceptor_noise", vec![value("sigma", sigma, "ln"), bandwidth]);
    }
    if let Some(highpass) = receptor.highpass {
        let tau_s = highpass.coupling_pf * 1e-12 * thermal_voltage_v(kelvin) / highpass.bias_a;
        push("adaptive_highpass", vec![value("tau", tau_s, "s")]);
    }
    if let Some(noise) = circuit.detector.photon_noise {
        let half = noise.half_current_a / receptor.white_current_a;
        let parameters = vec![
            value("rate_in_darkness", noise.dark_rate_hz, "Hz"),
            value("rate_at_white", noise.dark_rate_hz * half / (1.0 + half), "Hz"),
        ];
        push("shot_noise_poisson", parameters);
    }
}

fn detector_terms(circuit: &Circuit, nominal: &Nominal, terms: &mut Vec<Term>) {
    let detector = &circuit.detector;
    let efold_mv = circuit.output_volts_per_efold_v() * 1e3;
    let [on, off] = thresholds_ln(circuit);
    let mut push = |name, parameters| terms.push(effect(name, Stage::Detector, parameters));
    if let Some(junction) = detector.leak {
        let slope_v_s = junction.amperes(circuit.temperature_k) / (detector.feedback_ff * FEMTO);
        let rate_hz = slope_v_s / (detector.threshold_on_mv * 1e-3);
        let spread = value("spread", junction.spread_ln, "ln");
        push("leak_on", vec![value("rate", rate_hz, "Hz"), spread]);
    }
    if detector.offset_sigma_ln > 0.0 {
        let relative = (detector.offset_sigma_ln.powi(2).exp() - 1.0).sqrt();
        push("threshold_mismatch", vec![value("sigma_C", 0.5 * (on + off) * relative, "ln")]);
    }
    if detector.comparator_noise_mv > 0.0 {
        let sigma = detector.comparator_noise_mv / efold_mv;
        push("threshold_temporal_noise", vec![value("sigma", sigma, "ln")]);
    }
    if let Some(timer) = detector.refractory {
        push("refractory", vec![value("period", timer.seconds(), "s")]);
    }
    match detector.oddity {
        Some(DetectorOddity::OneSidedTimer(timer)) => {
            push("refractory_of_on_events", vec![value("period", timer.seconds(), "s")]);
        }
        Some(DetectorOddity::SmoothOffsets { sigma_ln, length_px }) => push(
            "spatially_correlated_thresholds",
            vec![value("sigma", sigma_ln, "1"), value("length", length_px, "px")],
        ),
        Some(DetectorOddity::DarkOffsets { sigma_ln }) => {
            push("light_dependent_mismatch", vec![value("sigma_in_darkness", sigma_ln, "1")]);
        }
        Some(DetectorOddity::Hysteresis { extra_mv }) => {
            push("hysteresis", vec![value("extra_threshold", extra_mv / efold_mv, "ln")]);
        }
        Some(DetectorOddity::ChargeInjection { charge_ac }) => {
            let step_mv = charge_ac * 1e-18 / (detector.feedback_ff * FEMTO) * 1e3;
            push("charge_injection", vec![value("step", step_mv / efold_mv, "ln")]);
        }
        None => {}
    }
    if differ(on, nominal.c_on) || differ(off, nominal.c_off) {
        terms.push(Term {
            name: "threshold_offset",
            kind: TermKind::Parameter,
            stage: Stage::Detector,
            parameters: vec![value("C_on", on, "ln"), value("C_off", off, "ln")],
        });
    }
}

fn background_terms(circuit: &Circuit, nominal: &Nominal, terms: &mut Vec<Term>) {
    let background = &circuit.background;
    if let Some(hot) = background.hot {
        let parameters = vec![
            value("share", hot.count / (WIDTH * HEIGHT) as f64, "1"),
            value("median_rate", hot.median_hz, "Hz"),
        ];
        terms.push(effect("hot_pixels", Stage::Background, parameters));
    }
    if differ(background.on_hz, nominal.noise_on_hz)
        || differ(background.off_hz, nominal.noise_off_hz)
    {
        terms.push(Term {
            name: "uniform_noise",
            kind: TermKind::Parameter,
            stage: Stage::Background,
            parameters: vec![
                value("rate_on", background.on_hz, "Hz"),
                value("rate_off", background.off_hz, "Hz"),
            ],
        });
    }
}

fn readout_terms(circuit: &Circuit, terms: &mut Vec<Term>) {
    let mut push = |name, parameters| terms.push(effect(name, Stage::Readout, parameters));
    match circuit.readout.access {
        Access::Direct => {}
        Access::Arbiter { row_ns, event_ns } => push(
            "arbiter",
            vec![
                value("rate_of_single_events", 1e9 / (row_ns + event_ns), "Hz"),
                value("rate_in_full_rows", 1e9 / event_ns, "Hz"),
            ],
        ),
        Access::Scan { column_ns } => {
            push("scanned_readout", vec![value("period", column_ns * 1e-9 * WIDTH as f64, "s")]);
        }
    }
    match circuit.readout.oddity {
        Some(ReadoutOddity::Echo { share, delay_s }) => {
            push("event_echo", vec![value("share", share, "1"), value("delay", delay_s, "s")]);
        }
        Some(ReadoutOddity::BurstLoss { share, bad_s, good_s }) => push(
            "correlated_loss",
            vec![value("share", share, "1"), value("bad", bad_s, "s"), value("good", good_s, "s")],
        ),
        Some(ReadoutOddity::NeighbourCopy { share, delay_s }) => {
            push("neighbour_copy", vec![value("share", share, "1"), value("delay", delay_s, "s")]);
        }
        None => {}
    }
}

fn clock_terms(circuit: &Circuit, terms: &mut Vec<Term>) {
    let clock = &circuit.clock;
    let single = [
        ("timestamp_jitter", "sigma", clock.jitter_us, 0.0),
        ("timestamp_quantisation", "period", clock.period_us, 1.0),
        ("pixel_latency", "delay", clock.latency_us, 0.0),
    ];
    for (name, parameter, number_us, ideal_us) in single {
        if number_us > ideal_us {
            let parameters = vec![value(parameter, number_us * 1e-6, "s")];
            terms.push(effect(name, Stage::Clock, parameters));
        }
    }
    if clock.offset_us != 0.0 {
        terms.push(Term {
            name: "clock_offset",
            kind: TermKind::Parameter,
            stage: Stage::Clock,
            parameters: vec![value("offset", clock.offset_us * 1e-6, "s")],
        });
    }
}

/// Whether two values differ by more than rounding.
fn differ(a: f64, b: f64) -> bool {
    (a - b).abs() > 1e-9
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

//! The terms of each stage of the camera; the derivations are in the parent module.

use super::{Nominal, Parameter, Term, TermKind, thresholds_ln};
use crate::circuit::{Access, Circuit, DetectorOddity, ReadoutOddity};
use crate::effect::CameraStage;
use crate::event::{HEIGHT, WIDTH};
use crate::physics::{FEMTO, KAPPA, node_rate_per_s, thermal_voltage_v};
use crate::pixel::noise_variance;

fn effect(name: &'static str, stage: CameraStage, parameters: Vec<Parameter>) -> Term {
    Term { name, kind: TermKind::Effect, stage, parameters }
}

fn parameter(name: &'static str, stage: CameraStage, parameters: Vec<Parameter>) -> Term {
    Term { name, kind: TermKind::Parameter, stage, parameters }
}

fn value(name: &'static str, value: f64, unit: &'static str) -> Parameter {
    Parameter { name, value, unit }
}

pub(super) fn optics(circuit: &Circuit, terms: &mut Vec<Term>) {
    let optics = &circuit.optics;
    if let Some(lamp) = optics.lamp {
        let parameters = vec![
            value("frequency", lamp.ripple_hz, "Hz"),
            value("depth", lamp.ripple_share, "1"),
            value("phase", lamp.phase_rad, "rad"),
        ];
        terms.push(effect("lamp_flicker", CameraStage::Optics, parameters));
    }
    let single = [
        ("psf_blur", "sigma", optics.blur_sigma_px, "px"),
        ("lens_distortion", "k1", optics.distortion_k1, "1"),
        ("veiling_glare", "share", optics.scattered_share, "1"),
    ];
    for (name, parameter, number, unit) in single {
        if number != 0.0 {
            terms.push(effect(name, CameraStage::Optics, vec![value(parameter, number, unit)]));
        }
    }
}

pub(super) fn photoreceptor(circuit: &Circuit, terms: &mut Vec<Term>) {
    let (receptor, kelvin) = (&circuit.photoreceptor, circuit.temperature_k);
    let corner_hz =
        |ff| node_rate_per_s(receptor.white_current_a, ff, kelvin) / std::f64::consts::TAU;
    let mut push =
        |name, parameters| terms.push(effect(name, CameraStage::Photoreceptor, parameters));
    if receptor.node_ff.is_some() || receptor.follower.is_some() {
        let mut parameters = Vec::new();
        if let Some(ff) = receptor.node_ff {
            parameters.push(value("corner_at_white", corner_hz(ff), "Hz"));
        }
        if let Some(follower) = receptor.follower {
            // The slope factor reduces the conductance of a transistor below threshold.
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
        // tau = C U_T / I: capacitance over the conductance of a transistor below threshold.
        let tau_s = highpass.coupling_pf * 1e-12 * thermal_voltage_v(kelvin) / highpass.bias_a;
        push("adaptive_highpass", vec![value("tau", tau_s, "s")]);
    }
    // The rate falls with light: to a half where the current is the half current.
    if let Some(noise) = circuit.detector.photon_noise {
        let half = noise.half_current_a / receptor.white_current_a;
        let parameters = vec![
            value("rate_in_darkness", noise.dark_rate_hz, "Hz"),
            value("rate_at_white", noise.dark_rate_hz * half / (1.0 + half), "Hz"),
        ];
        push("shot_noise_poisson", parameters);
    }
}

pub(super) fn detector(circuit: &Circuit, nominal: &Nominal, terms: &mut Vec<Term>) {
    let detector = &circuit.detector;
    let efold_mv = circuit.output_volts_per_efold_v() * 1e3;
    let [on, off] = thresholds_ln(circuit);
    let mut push = |name, parameters| terms.push(effect(name, CameraStage::Detector, parameters));
    if let Some(junction) = detector.leak {
        // Amperes over farads are volts per second.
        let slope_v_s = junction.amperes(circuit.temperature_k) / (detector.feedback_ff * FEMTO);
        // The slope reaches the threshold so often.
        let rate_hz = slope_v_s / (detector.threshold_on_mv * 1e-3);
        let spread = value("spread", junction.spread_ln, "ln");
        push("leak_on", vec![value("rate", rate_hz, "Hz"), spread]);
    }
    if detector.offset_sigma_ln > 0.0 {
        // The coefficient of variation of a log-normal distribution.
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
        let parameters = vec![value("C_on", on, "ln"), value("C_off", off, "ln")];
        terms.push(parameter("threshold_offset", CameraStage::Detector, parameters));
    }
}

pub(super) fn background(circuit: &Circuit, nominal: &Nominal, terms: &mut Vec<Term>) {
    let background = &circuit.background;
    if let Some(hot) = background.hot {
        let parameters = vec![
            value("share", hot.count / (WIDTH * HEIGHT) as f64, "1"),
            value("median_rate", hot.median_hz, "Hz"),
        ];
        terms.push(effect("hot_pixels", CameraStage::Background, parameters));
    }
    if differ(background.on_hz, nominal.noise_on_hz)
        || differ(background.off_hz, nominal.noise_off_hz)
    {
        let parameters = vec![
            value("rate_on", background.on_hz, "Hz"),
            value("rate_off", background.off_hz, "Hz"),
        ];
        terms.push(parameter("uniform_noise", CameraStage::Background, parameters));
    }
}

pub(super) fn readout(circuit: &Circuit, terms: &mut Vec<Term>) {
    let mut push = |name, parameters| terms.push(effect(name, CameraStage::Readout, parameters));
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

pub(super) fn clock(circuit: &Circuit, terms: &mut Vec<Term>) {
    let clock = &circuit.clock;
    let single = [
        ("timestamp_jitter", "sigma", clock.jitter_us, 0.0),
        ("timestamp_quantisation", "period", clock.period_us, 1.0),
        ("pixel_latency", "delay", clock.latency_us, 0.0),
    ];
    for (name, parameter, number_us, ideal_us) in single {
        if number_us > ideal_us {
            let parameters = vec![value(parameter, number_us * 1e-6, "s")];
            terms.push(effect(name, CameraStage::Clock, parameters));
        }
    }
    if clock.offset_us != 0.0 {
        let parameters = vec![value("offset", clock.offset_us * 1e-6, "s")];
        terms.push(parameter("clock_offset", CameraStage::Clock, parameters));
    }
}

/// Whether two values differ by more than rounding.
fn differ(a: f64, b: f64) -> bool {
    (a - b).abs() > 1e-9
}

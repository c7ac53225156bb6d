//! Change detector and comparators against closed forms in circuit units.

use gapbench_pixel::circuit::{DetectorOddity, Junction, PhotonNoise, Timer};
use gapbench_pixel::pixel::pixel_spikes;
use gapbench_pixel::{Circuit, Seeds};

const SEEDS: Seeds = Seeds { camera: 1, run: 2 };

fn times(circuit: &Circuit, pixel: u32, log_light: impl Fn(f64) -> f64) -> Vec<f64> {
    pixel_spikes(circuit, SEEDS, pixel, 1.0, log_light).iter().map(|spike| spike.t_s).collect()
}

fn assert_spacing(times_s: &[f64], expected_s: f64) {
    assert!(times_s.len() > 2);
    for pair in times_s.windows(2) {
        assert!((pair[1] - pair[0] - expected_s).abs() < 1e-6, "{pair:?} not {expected_s} apart");
    }
}

#[test]
fn a_leaking_junction_fires_a_quiet_pixel_each_time_it_has_moved_one_threshold() {
    let mut circuit = Circuit::ideal();
    circuit.detector.leak = Some(Junction { current_fa: 10.0, doubling_k: 8.0, spread_ln: 0.0 });
    let spikes = pixel_spikes(&circuit, SEEDS, 0, 1.0, |_| -1.0);
    assert!(spikes.iter().all(|spike| spike.on));
    // C2 theta / I with 5 fF.
    let period_s = 5e-15 * circuit.detector.threshold_on_mv * 1e-3 / 10e-15;
    let times_s: Vec<f64> = spikes.iter().map(|spike| spike.t_s).collect();
    assert!((times_s[0] - period_s).abs() < 1e-6);
    assert_spacing(&times_s, period_s);
}

#[test]
fn eight_kelvins_more_double_the_leak() {
    let junction = Junction { current_fa: 3.0, doubling_k: 8.0, spread_ln: 0.0 };
    assert!((junction.amperes(308.0) / junction.amperes(300.0) - 2.0).abs() < 1e-12);
}

#[test]
fn a_pixel_in_reset_takes_up_the_light_at_the_end_of_the_reset() {
    let mut circuit = Circuit::ideal();
    let timer = Timer { current_pa: 5.0, capacitance_ff: 20.0, swing_v: 0.5 };
    circuit.detector.refractory = Some(timer);
    let rate = 40.0;
    // C dV / I = 2 ms, then one threshold from there.
    assert!((timer.seconds() - 0.002).abs() < 1e-15);
    let times_s = times(&circuit, 0, |t_s| rate * t_s - 3.0);
    assert!((times_s[0] - 0.25 / rate).abs() < 1e-6);
    assert_spacing(&times_s, 0.002 + 0.25 / rate);
}

#[test]
fn a_step_during_reset_is_lost() {
    let mut circuit = Circuit::ideal();
    let timer = Timer { current_pa: 1.0, capacitance_ff: 20.0, swing_v: 0.5 };
    circuit.detector.refractory = Some(timer);
    // The first step fires once and holds for 10 ms; the second falls into that time.
    let light = |t_s: f64| {
        if t_s < 0.1 {
            -3.0
        } else if t_s < 0.105 {
            -2.0
        } else {
            -1.0
        }
    };
    assert_eq!(times(&circuit, 0, light).len(), 1);
}

#[test]
fn offsets_of_comparators_are_log_normal() {
    let mut circuit = Circuit::ideal();
    circuit.detector.offset_sigma_ln = 0.1;
    let n = 3000_u32;
    let (mut sum, mut square) = (0.0, 0.0);
    for pixel in 0..n {
        // The first event of a ramp comes after one threshold.
        let log = (times(&circuit, pixel, |t_s| 2.0 * t_s)[0] * 2.0 / 0.25).ln();
        sum += log;
        square += log * log;
    }
    let mean = sum / f64::from(n);
    let sigma = (square / f64::from(n) - mean * mean).sqrt();
    // Four standard errors each.
    assert!(mean.abs() < 4.0 * 0.1 / f64::from(n).sqrt(), "{mean}");
    assert!((sigma - 0.1).abs() < 4.0 * 0.1 / (2.0 * f64::from(n)).sqrt(), "{sigma}");
}

#[test]
fn comparator_noise_spreads_the_intervals_of_a_ramp_by_noise_over_rate() {
    let mut circuit = Circuit::ideal();
    circuit.detector.comparator_noise_mv = 0.1 * circuit.detector.threshold_on_mv;
    let rate = 500.0;
    let times_s = times(&circuit, 3, |t_s| rate * t_s);
    let intervals: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let n = intervals.len() as f64;
    let mean = intervals.iter().sum::<f64>() / n;
    let sigma = (intervals.iter().map(|i| (i - mean).powi(2)).sum::<f64>() / n).sqrt();
    assert!((mean - 0.25 / rate).abs() < 4.0 * 0.025 / rate / n.sqrt());
    assert!((sigma - 0.025 / rate).abs() < 4.0 * 0.025 / rate / (2.0 * n).sqrt());
}

#[test]
fn photon_noise_fires_at_the_dark_rate_over_one_plus_light() {
    let mut circuit = Circuit::ideal();
    let half_current_a = 0.5 * circuit.photoreceptor.white_current_a;
    circuit.detector.photon_noise = Some(PhotonNoise { dark_rate_hz: 30.0, half_current_a });
    for light in [0.02_f64, 0.5, 1.0] {
        let count: usize = (0..200).map(|pixel| times(&circuit, pixel, |_| light.ln()).len()).sum();
        let expected = 200.0 * 30.0 / (1.0 + light / 0.5);
        assert!((count as f64 - expected).abs() < 4.0 * expected.sqrt(), "{count} not {expected}");
    }
}

#[test]
fn injected_charge_shortens_every_interval_of_a_ramp_but_the_first() {
    let mut circuit = Circuit::ideal();
    // A tenth of a threshold: q = C2 theta / 10, 1 fF mV = 1 aC.
    let charge_ac = circuit.detector.feedback_ff * 0.1 * circuit.detector.threshold_on_mv;
    circuit.detector.oddity = Some(DetectorOddity::ChargeInjection { charge_ac });
    let times_s = times(&circuit, 0, |t_s| 4.0 * t_s);
    assert!((times_s[0] - 0.25 / 4.0).abs() < 1e-6);
    assert_spacing(&times_s, 0.9 * 0.25 / 4.0);
}

#[test]
fn hysteresis_delays_the_first_event_after_a_turn() {
    let mut circuit = Circuit::ideal();
    let extra_mv = 0.4 * circuit.detector.threshold_off_mv;
    circuit.detector.oddity = Some(DetectorOddity::Hysteresis { extra_mv });
    // Up by .3 (one event at .25), then down at 1 per second from .5 s on.
    let light = |t_s: f64| t_s.min(0.3) - (t_s - 0.5).max(0.0);
    let times_s = times(&circuit, 0, light);
    assert_eq!(times_s.len(), 2);
    // From .3 to .25 - 1.4 * .25 = -.1.
    assert!((times_s[1] - (0.5 + 0.4)).abs() < 1e-6);
}

#[test]
fn a_one_sided_timer_holds_after_on_events_only() {
    let mut circuit = Circuit::ideal();
    let timer = Timer { current_pa: 2.5, capacitance_ff: 20.0, swing_v: 0.5 };
    circuit.detector.oddity = Some(DetectorOddity::OneSidedTimer(timer));
    assert_spacing(&times(&circuit, 0, |t_s| 20.0 * t_s), 0.004 + 0.25 / 20.0);
    assert_spacing(&times(&circuit, 0, |t_s| -20.0 * t_s), 0.25 / 20.0);
}

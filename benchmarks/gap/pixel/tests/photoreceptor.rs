//! The photoreceptor in front of the detector, against closed forms in circuit units.

use gapbench_pixel::circuit::{HighPass, NodeNoise};
use gapbench_pixel::physics::{ELEMENTARY_CHARGE_C, thermal_voltage_v};
use gapbench_pixel::pixel::pixel_spikes;
use gapbench_pixel::{Circuit, Seeds};

const SEEDS: Seeds = Seeds { camera: 1, run: 2 };

fn times(circuit: &Circuit, pixel: u32, log_light: impl Fn(f64) -> f64) -> Vec<f64> {
    pixel_spikes(circuit, SEEDS, pixel, 1.0, log_light).iter().map(|spike| spike.t_s).collect()
}

#[test]
fn a_step_through_the_photodiode_node_fires_when_the_closed_form_passes_each_threshold() {
    let mut circuit = Circuit::ideal();
    circuit.photoreceptor.node_ff = Some(400.0);
    let (before, after, step_s) = (0.05_f64, 0.3_f64, 0.2);
    let found = times(&circuit, 0, |t_s| if t_s < step_s { before.ln() } else { after.ln() });
    let rate = 10e-12 / (400e-15 * thermal_voltage_v(300.0)) * after;
    let count = ((after / before).ln() / 0.25).floor() as usize;
    assert_eq!(found.len(), count);
    for (k, found_s) in (1..).zip(found) {
        let inverse = (0.25 * -f64::from(k)).exp() / before;
        let share = (inverse - 1.0 / after) / (1.0 / before - 1.0 / after);
        let expected_s = step_s - share.ln() / rate;
        assert!((found_s - expected_s).abs() < 2e-6, "{found_s} instead of {expected_s}");
    }
}

#[test]
fn dark_current_hides_a_ramp_until_light_outweighs_it() {
    let mut circuit = Circuit::ideal();
    circuit.photoreceptor.dark_current_fa = 100.0;
    let (start, rate, dark) = (1e-3_f64, 6.0, 100e-15 / 10e-12);
    let found = times(&circuit, 0, |t_s| start.ln() + rate * t_s);
    for (k, found_s) in (1..).zip(&found) {
        let light = (start + dark) * (0.25 * f64::from(k)).exp() - dark;
        assert!((found_s - (light / start).ln() / rate).abs() < 1e-6);
    }
    let last = start * rate.exp();
    assert_eq!(found.len(), (((last + dark) / (start + dark)).ln() / 0.25).floor() as usize);
}

#[test]
fn a_ramp_behind_the_slow_feedback_saturates_at_rate_times_time_constant() {
    let mut circuit = Circuit::ideal();
    let tau_s = 0.05;
    let bias_a = 1e-12 * thermal_voltage_v(300.0) / tau_s;
    circuit.photoreceptor.highpass = Some(HighPass { bias_a, coupling_pf: 1.0 });
    // 4.9 per second saturate at .245, below the threshold; 12 at .6, two thresholds.
    assert!(times(&circuit, 0, |t_s| 4.9 * t_s).is_empty());
    let found = times(&circuit, 0, |t_s| 12.0 * t_s);
    assert_eq!(found.len(), 2);
    for (k, found_s) in (1..).zip(found) {
        let expected_s = -tau_s * (1.0 - 0.25 * f64::from(k) / (12.0 * tau_s)).ln();
        assert!((found_s - expected_s).abs() < 2e-6);
    }
}

#[test]
fn slow_strong_noise_leaves_the_thresholds_as_often_as_brownian_motion_does() {
    // Where the node is slow and its noise large, noise is a Brownian motion of s^2 = 2 a sigma^2
    // per second, and the mean time to leave +-theta from the middle is theta^2 / s^2. A path
    // looked at on a coarse grid would leave late.
    let mut circuit = Circuit::ideal();
    let (rate, variance) = (0.125, 25.0);
    let thermal_v = thermal_voltage_v(300.0);
    let node_ff = 10e-12 / (rate * thermal_v) * 1e15;
    let excess_factor = variance * node_ff * 1e-15 * thermal_v / ELEMENTARY_CHARGE_C;
    circuit.photoreceptor.noise = Some(NodeNoise { node_ff, excess_factor });
    let pixels = 60;
    let count: usize = (0..pixels).map(|pixel| times(&circuit, pixel, |_| 0.0).len()).sum();
    let mean_s = 0.25 * 0.25 / (2.0 * rate * variance);
    let expected = f64::from(pixels) / mean_s;
    // The time to leave has variance 2/3 of its squared mean.
    let sigma = (expected * 2.0 / 3.0).sqrt();
    assert!((count as f64 - expected).abs() < 4.0 * sigma, "{count} instead of {expected}");
}

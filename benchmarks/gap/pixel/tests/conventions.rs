//! Conventions of a camera against closed forms.

use gapbench_pixel::circuit::{Bend, Clock, NoiseAddress};
use gapbench_pixel::clock::stamp;
use gapbench_pixel::event::Spike;
use gapbench_pixel::pixel::pixel_spikes;
use gapbench_pixel::{Circuit, Seeds};

const SEEDS: Seeds = Seeds { camera: 1, run: 2 };
const THRESHOLD: f64 = 0.25;

fn times_s(circuit: &Circuit, duration_s: f64, log_light: impl Fn(f64) -> f64) -> Vec<f64> {
    let spikes = pixel_spikes(circuit, SEEDS, 0, duration_s, log_light);
    spikes.into_iter().map(|spike| spike.t_s).collect()
}

#[test]
fn a_reset_that_opens_early_shortens_all_steps_of_a_ramp_but_the_first() {
    let (rate, share) = (5.0, 0.1);
    let mut circuit = Circuit::ideal();
    circuit.detector.unsettled_share = share;
    let found = times_s(&circuit, 0.49, |t_s| -3.0 + rate * t_s);
    for (k, t_s) in found.iter().enumerate() {
        let expected = (THRESHOLD + k as f64 * THRESHOLD * (1.0 - share)) / rate;
        assert!((t_s - expected).abs() < 1e-6, "{t_s} instead of {expected}");
    }
    assert_eq!(found.len(), 10);
}

#[test]
fn a_bent_logarithm_has_its_slopes_at_white_and_in_darkness() {
    let (share, rate) = (0.1, 0.6);
    let mut circuit = Circuit::ideal();
    circuit.photoreceptor.bend = Some(Bend { share });
    let darkest = 0.02_f64.ln();
    // Over a range of .48 the slope changes by about a hundredth.
    let up = times_s(&circuit, 0.8, |t_s| -0.48 + rate * t_s);
    let dark = times_s(&circuit, 0.8, |t_s| darkest + rate * t_s);
    let slope = |times: &[f64]| THRESHOLD / (rate * times[0]);
    assert!((slope(&up) - (1.0 + share)).abs() < 0.025, "{}", slope(&up));
    assert!((slope(&dark) - (1.0 - share)).abs() < 0.025, "{}", slope(&dark));
}

#[test]
fn a_current_that_is_added_is_as_good_as_dark_current() {
    let mut added = Circuit::ideal();
    added.photoreceptor.added_share = 0.015;
    let mut dark = Circuit::ideal();
    dark.photoreceptor.dark_current_fa = 150.0;
    let light = |t_s: f64| -3.5 + 3.0 * t_s;
    let (added, dark) = (times_s(&added, 1.0, light), times_s(&dark, 1.0, light));
    assert_eq!(added.len(), dark.len());
    // Instants are narrowed to 1e-8 s.
    assert!(added.iter().zip(&dark).all(|(a, b)| (a - b).abs() < 2e-8));
}

#[test]
fn every_pixel_has_its_own_latency_in_every_run() {
    let (latency_us, spread) = (1000.0, 0.4);
    let clock = Clock { latency_us, latency_spread_ln: spread, ..Circuit::ideal().clock };
    let pixels = 4000;
    let delays = |run| -> Vec<f64> {
        (0..pixels)
            .map(|pixel| {
                let spike = Spike { t_s: 0.1, pixel, on: true };
                let seeds = Seeds { camera: 3, run };
                stamp(&clock, NoiseAddress::Time, seeds, &[spike], 1.0)[0].t_us as f64 - 1e5
            })
            .collect()
    };
    let first = delays(1);
    assert_eq!(first, delays(2));
    let logs: Vec<f64> = first.iter().map(|delay| (delay / latency_us).ln()).collect();
    let mean = logs.iter().sum::<f64>() / f64::from(pixels);
    let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / f64::from(pixels);
    // Four standard errors of each.
    assert!(mean.abs() < 4.0 * spread / f64::from(pixels).sqrt(), "{mean}");
    let deviation = variance.sqrt();
    assert!(
        (deviation - spread).abs() < 4.0 * spread / f64::from(2 * pixels).sqrt(),
        "{deviation}"
    );
}

#[test]
fn jitter_by_time_does_not_depend_on_events_of_other_pixels() {
    let clock = Clock { jitter_us: 300.0, ..Circuit::ideal().clock };
    let spike = |t_s, pixel| Spike { t_s, pixel, on: true };
    let stamps = |spikes: &[Spike]| stamp(&clock, NoiseAddress::Time, SEEDS, spikes, 1.0);
    let few = stamps(&[spike(0.2, 5), spike(0.5, 5)]);
    let more = stamps(&[spike(0.1, 9), spike(0.2, 5), spike(0.3, 9), spike(0.5, 5)]);
    assert!(few.iter().all(|event| more.contains(event)));
    assert_eq!((few.len(), more.len()), (2, 4));
}

//! The ideal pixel against closed forms.

use gapbench_pixel::pixel::pixel_spikes;
use gapbench_pixel::{Circuit, Seeds};

const SEEDS: Seeds = Seeds { camera: 1, run: 2 };
const THRESHOLD: f64 = 0.25;

fn events(duration_s: f64, log_light: impl Fn(f64) -> f64) -> Vec<(f64, bool)> {
    let spikes = pixel_spikes(&Circuit::ideal(), SEEDS, 0, duration_s, log_light);
    spikes.into_iter().map(|spike| (spike.t_s, spike.on)).collect()
}

fn assert_events(actual: &[(f64, bool)], expected: &[(f64, bool)]) {
    assert_eq!(actual.len(), expected.len());
    for (actual, expected) in actual.iter().zip(expected) {
        assert!((actual.0 - expected.0).abs() < 1e-6, "{actual:?} instead of {expected:?}");
        assert_eq!(actual.1, expected.1);
    }
}

#[test]
fn an_exponential_ramp_of_light_fires_every_threshold_over_rate_seconds() {
    for (rate, on) in [(13.0, true), (-9.0, false), (1800.0, true)] {
        let found = events(0.9001, |t_s| -2.0 + rate * t_s);
        let count = (0.9001 * rate.abs() / THRESHOLD).floor() as usize;
        let expected: Vec<(f64, bool)> =
            (1..=count).map(|k| (k as f64 * THRESHOLD / rate.abs(), on)).collect();
        assert_events(&found, &expected);
    }
}

#[test]
fn a_sine_of_the_logarithm_fires_where_it_passes_multiples_of_the_threshold() {
    let (amplitude, frequency_hz) = (0.9, 7.0);
    let omega = std::f64::consts::TAU * frequency_hz;
    let found = events(0.999, |t_s| amplitude * (omega * t_s).sin());
    // Up to .75 on the rise, then down to -.75 and up again, half a turn each.
    let asin = |level: f64| (level / amplitude).asin() / omega;
    let half_s = 0.5 / frequency_hz;
    let mut expected: Vec<(f64, bool)> =
        (1..=3).map(|k| (asin(f64::from(k) * THRESHOLD), true)).collect();
    for half in 1..15 {
        let on = half % 2 == 0;
        let levels = (-2..=3).map(|k| f64::from(k) * THRESHOLD);
        expected.extend(levels.map(|level| (f64::from(half) * half_s + asin(level), on)));
    }
    expected.retain(|event| event.0 < 0.999);
    assert_events(&found, &expected);
}

#[test]
fn a_step_fires_as_many_events_as_whole_thresholds_fit_at_its_instant() {
    let instant_s = 0.123_456_7;
    for step in [0.24_f64, 0.26, 1.1, -0.77, 3.3] {
        let found = events(0.5, |t_s| if t_s < instant_s { -1.5 } else { -1.5 + step });
        let count = (step.abs() / THRESHOLD).floor() as usize;
        assert_events(&found, &vec![(instant_s, step > 0.0); count]);
    }
}

#[test]
fn still_light_is_silent() {
    assert_eq!(events(1.0, |_| -3.0), []);
    assert_eq!(events(1.0, |t_s| 0.24 * (40.0 * t_s).sin()), []);
}

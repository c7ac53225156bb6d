//! Effects on how pixels detect changes, against closed forms.

use evpose_core::Polarity;
use evpose_sensor::Origin;

use crate::support::*;

/// Events of one pixel on a ramp of log voltage that stops after `ramp_s`.
fn ramp(effects: &[evpose_sensor::EffectConfig], per_s: f64, ramp_s: f64, steps: i64) -> Vec<f64> {
    let mut run = sensor(effects, size(1, 1), 1);
    let events = record(&mut run, steps, 1_000, |_, _, t| light(-3.0 + per_s * t.min(ramp_s)));
    events.iter().map(|e| e.t.as_seconds()).collect()
}

#[track_caller]
fn assert_spaced(times: &[f64], interval_s: f64) {
    for found in intervals(times) {
        assert_near(found, interval_s, 3e-6);
    }
}

#[test]
fn a_leak_is_regular_and_on_only_with_a_phase_per_pixel() {
    let leak = effect("leak_on").with("rate_hz", 20.0);
    let mut run = sensor(&[leak], size(16, 16), 5);
    let events = record(&mut run, 1_000, 1_000, |_, _, _| 0.3);
    assert!(events.iter().all(|e| e.polarity.is_on()));
    let times = times_by_pixel(&events, run.size());
    for pixel in &times {
        assert!((20..=21).contains(&pixel.len()), "{}", pixel.len());
        // Rounding up to microseconds, and single precision of the memory.
        assert_spaced(pixel, 0.05);
    }
    // First events are spread evenly over an interval.
    let phases: Vec<f64> = times.iter().map(|t| t[0] / 0.05).collect();
    assert_near(mean(&phases), 0.5, 4.0 / (12.0 * 256f64).sqrt());
    assert_near(deviation(&phases), (1.0 / 12f64).sqrt(), 0.04);
}

#[test]
fn a_leak_does_not_depend_on_the_length_of_steps_nor_fade_over_minutes() {
    let times = |steps, step_us| {
        let leak = effect("leak_on").with("rate_hz", 0.7).with("phase", "aligned");
        let mut run = sensor(&[leak], size(1, 1), 5);
        let events = record(&mut run, steps, step_us, |_, _, _| 0.3);
        events.iter().map(|e| e.t.as_seconds()).collect::<Vec<_>>()
    };
    let (fine, coarse) = (times(59_500, 1_000), times(595, 100_000));
    assert_eq!((fine.len(), coarse.len()), (41, 41));
    for (k, (a, b)) in fine.iter().zip(&coarse).enumerate() {
        // A millionth of the voltage is 7 us of this leak; errors of anchors add up.
        let exact = (k + 1) as f64 / 0.7;
        assert_near(*a, exact, 2e-5 * exact.max(1.0));
        assert_near(*b, exact, 2e-5 * exact.max(1.0));
    }
}

#[test]
fn intervals_and_rates_of_a_leak_scatter_as_asked() {
    let leak = effect("leak_on").with("rate_hz", 50.0).with("jitter", 0.2);
    let mut run = sensor(std::slice::from_ref(&leak), size(8, 8), 5);
    let events = record(&mut run, 1_000, 1_000, |_, _, _| 0.3);
    let times = times_by_pixel(&events, run.size());
    let all: Vec<f64> = times.iter().flat_map(|t| intervals(t)).collect();
    assert_near(mean(&all), 0.02, 4.0 * 0.004 / (all.len() as f64).sqrt());
    assert_near(deviation(&all) / 0.02, 0.2, 0.01);

    let spread = leak.with("spread_decades", 0.1).with("jitter", 0.0);
    let mut run = sensor(&[spread], size(32, 32), 5);
    let events = record(&mut run, 500, 1_000, |_, _, _| 0.3);
    let times = times_by_pixel(&events, run.size());
    let decades: Vec<f64> =
        times.iter().map(|t| (1.0 / mean(&intervals(t)) / 50.0).log10()).collect();
    assert_near(mean(&decades), 0.0, 4.0 * 0.1 / 32.0);
    assert_near(deviation(&decades), 0.1, 0.01);
}

#[test]
fn a_leak_adds_to_a_rise_and_takes_from_a_fall() {
    let leak = || effect("leak_on").with("rate_hz", 10.0).with("phase", "aligned");
    // 2 ln/s of leak and 6 ln/s of light.
    assert_spaced(&ramp(&[leak()], 6.0, 1.0, 500), C / 8.0);
    assert_spaced(&ramp(&[leak()], -6.0, 1.0, 400), C / 4.0);
}

#[test]
fn jitter_from_frame_to_frame_averages_out() {
    let leak = effect("leak_on").with("rate_hz", 20.0).with("frame_jitter", 1.0);
    let mut run = sensor(&[leak], size(16, 16), 5);
    let events = record(&mut run, 1_000, 1_000, |_, _, _| 0.3);
    let times = times_by_pixel(&events, run.size());
    let all: Vec<f64> = times.iter().flat_map(|t| intervals(t)).collect();
    // Fifty steps per interval, each with a deviation of 1 ms.
    assert_near(mean(&all), 0.05, 0.05 * 0.01);
    assert_near(deviation(&all) / 0.05, 1.0 / 50f64.sqrt(), 0.02);
}

#[test]
fn a_photo_leak_is_in_proportion_to_light() {
    let leak = effect("parasitic_photo_leak").with("hz_per_white", 40.0);
    let mut run = sensor(&[leak], size(2, 1), 5);
    let events = record(&mut run, 1_000, 1_000, |x, _, _| if x == 0 { 0.8 } else { 0.2 });
    let times = times_by_pixel(&events, run.size());
    assert_spaced(&times[0], 1.0 / 32.0);
    assert_spaced(&times[1], 1.0 / 8.0);
    assert!(events.iter().all(|e| e.polarity.is_on()));
}

#[test]
fn pixels_do_not_leak_in_step() {
    for leak in [
        effect("leak_on").with("rate_hz", 10.0),
        effect("parasitic_photo_leak").with("hz_per_white", 20.0),
    ] {
        let mut run = sensor(&[leak], size(20, 20), 5);
        let events = record(&mut run, 1_000, 1_000, |_, _, _| 0.5);
        let times = times_by_pixel(&events, run.size());
        let first: Vec<f64> = times.iter().map(|times| times[0]).collect();
        // Anywhere in the first interval of 100 ms.
        assert_near(mean(&first), 0.05, 0.006);
        assert_near(deviation(&first), 0.1 / 12f64.sqrt(), 0.003);
    }
}

#[test]
fn dead_times_and_resets_change_the_distance_of_events() {
    // 20 ln/s: a threshold in 10 ms, then the dead time, or a reset that is late or short.
    for (term, interval_s) in [
        (effect("refractory").with("period_us", 3_300.0), 0.01 + 0.0033),
        (effect("reset_overshoot").with("delay_us", 500.0), 0.0105),
        (effect("reset_overshoot").with("fraction", 0.25), 0.0075),
    ] {
        let times = ramp(&[term], 20.0, 1.0, 300);
        assert!(times.len() > 20);
        assert_spaced(&times, interval_s);
    }
    // 100 ln/s for 40 ms: twenty events, 2 ms apart without the dead time. Deferred ones are late,
    // and of those that are dropped every second one comes through.
    for (mode, count, interval_s) in [("defer", 20, 0.003), ("drop", 10, 0.004)] {
        let dead_time = effect("refractory").with("period_us", 3_000.0).with("mode", mode);
        let times = ramp(&[dead_time], 100.0, 0.0401, 300);
        assert_eq!(times.len(), count, "{mode}");
        assert_near(times[0], 0.002, 2e-6);
        assert_spaced(&times, interval_s);
    }
}

#[test]
fn hysteresis_silences_small_waves() {
    // A triangle of 0.3 about the first level: with equal thresholds it goes to and fro.
    let wave = |t: f64| {
        let turn = (t * 20.0).fract();
        light(-2.0 + 0.3 * (1.0 - (2.0 * turn - 1.0).abs()))
    };
    let count = |effects: &[evpose_sensor::EffectConfig]| {
        let mut run = sensor(effects, size(1, 1), 1);
        record(&mut run, 500, 1_000, |_, _, t| wave(t)).len()
    };
    assert!(count(&[]) >= 19);
    assert!(count(&[effect("hysteresis").with("fraction", 1.0)]) <= 1);
}

#[test]
fn mismatch_is_a_fixed_pattern_and_temporal_noise_is_none() {
    // Time of the first event on each of two ramps determines the threshold of a pixel.
    let thresholds = |effects: &[evpose_sensor::EffectConfig]| {
        let mut run = sensor(effects, size(24, 24), 9);
        // Up for 60 ms, down for 60 ms, and the same again.
        let scene = |_, _, t: f64| {
            let turn = (t / 0.12).fract();
            light(-3.0 + 0.9 * (1.0 - (2.0 * turn - 1.0).abs()))
        };
        let events = record(&mut run, 240, 1_000, scene);
        let times = times_by_pixel(&events, run.size());
        let count = |from: f64, to: f64| -> Vec<f64> {
            times
                .iter()
                .map(|t| t.iter().filter(|t| (from..to).contains(*t)).count() as f64)
                .collect()
        };
        (count(0.0, 0.12), count(0.12, 0.24), times)
    };
    let correlation = |a: &[f64], b: &[f64]| {
        let (ma, mb) = (mean(a), mean(b));
        let products: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).collect();
        mean(&products) / (deviation(a) * deviation(b))
    };
    let (first, second, times) = thresholds(&[effect("threshold_mismatch").with("sigma", 0.03)]);
    // Counts of eight or nine are coarse measures of a threshold.
    assert!(correlation(&first, &second) > 0.5);
    let on: Vec<f64> = times.iter().map(|t| t[0] * 15.0).collect();
    assert_near(mean(&on), C, 0.01);
    assert_near(deviation(&on), 0.03, 0.004);

    let (first, second, times) =
        thresholds(&[effect("threshold_temporal_noise").with("sigma", 0.03)]);
    assert!(correlation(&first, &second).abs() < 4.0 / 24.0);
    let on: Vec<f64> = times.iter().map(|t| t[0] * 15.0).collect();
    assert_near(deviation(&on), 0.03, 0.004);
}

#[test]
fn dead_pixels_are_silent_whatever_happens() {
    let dead = effect("dead_pixels").with("fraction", 0.25);
    let noise = effect("uniform_noise").with("on_hz", 200.0);
    let shot = effect("shot_noise_poisson").with("rate_hz", 200.0);
    let mut run = sensor(&[dead, noise, shot], size(40, 40), 2);
    let events = record(&mut run, 200, 1_000, |_, _, t| light(-2.0 + 2.0 * (20.0 * t).sin()));
    let silent = times_by_pixel(&events, run.size()).iter().filter(|t| t.is_empty()).count();
    assert_near(silent as f64, 400.0, 4.0 * (400.0 * 0.75f64).sqrt());
}

#[test]
fn labels_distinguish_signal_leak_shot_and_hot() {
    let effects = [
        effect("leak_on").with("rate_hz", 5.0),
        effect("shot_noise_poisson").with("rate_hz", 5.0),
        effect("hot_pixels").with("fraction", 0.01).with("median_hz", 100.0).with("on_share", 0.5),
    ];
    let mut run = sensor(&effects, size(30, 30), 2);
    let mut plain = sensor(&effects, size(30, 30), 2);
    run.label_origins(true);
    let mut counts = std::collections::BTreeMap::new();
    for k in 0..500i64 {
        // The right half brightens by one threshold in half a second.
        let mut plane = evpose_core::Plane::for_sensor(run.size(), light(-1.0) as f32);
        for (i, y) in plane.data_mut().iter_mut().enumerate() {
            if i % 30 >= 15 {
                *y = light(-1.0 + 4.0 * k as f64 * 1e-3) as f32;
            }
        }
        let t = evpose_core::Micros(k * 1_000);
        let events: Vec<_> = run.expose(&plane, t).unwrap().iter().collect();
        let unlabelled: Vec<_> = plain.expose(&plane, t).unwrap().iter().collect();
        assert_eq!(events, unlabelled, "labels change nothing");
        let origins = run.origins().unwrap();
        assert_eq!(origins.len(), events.len());
        for (event, origin) in events.iter().zip(origins) {
            *counts.entry((event.x >= 15, *origin)).or_insert(0usize) += 1;
            if matches!(origin, Origin::Leak | Origin::Signal) {
                assert_eq!(event.polarity, Polarity::On);
            }
        }
    }
    let of = |right, origin| counts.get(&(right, origin)).copied().unwrap_or(0);
    // Pixels that are reset by noise start their interval again: fewer than 5 Hz.
    assert!((450..1_130).contains(&of(false, Origin::Leak)), "{counts:?}");
    assert_eq!((of(false, Origin::Signal), of(true, Origin::Leak)), (0, 0));
    assert!(of(true, Origin::Signal) > 2_000);
    assert_poisson(of(false, Origin::Shot) + of(true, Origin::Shot), 5.0 * 900.0 * 0.499);
    assert!(of(false, Origin::Hot) + of(true, Origin::Hot) > 100);
    assert!(plain.origins().is_none());
}

#[test]
fn counts_of_a_frame_are_spread_by_the_busiest_pixel() {
    let count = effect("frame_count").with("threshold_on", 0.2).with("threshold_off", 0.2);
    let mut run = sensor(std::slice::from_ref(&count), size(3, 1), 1);
    // Rises of 0.71, 0.31 and -0.45: three, one and two events, N = 3.
    let change = [0.71, 0.31, -0.45];
    let scene = |x: usize, _, t: f64| light(-2.0 + if t > 0.0 { change[x] } else { 0.0 });
    let events = record(&mut run, 1, 3_000, scene);
    let expected = [
        (1_000, 0, Polarity::On),
        (1_000, 1, Polarity::On),
        (1_000, 2, Polarity::Off),
        (2_000, 0, Polarity::On),
        (2_000, 2, Polarity::Off),
        (3_000, 0, Polarity::On),
    ];
    assert_eq!(events.iter().map(|e| (e.t.0, e.x, e.polarity)).collect::<Vec<_>>(), expected);

    // 1.5 ms of refractory period: the second of three is dropped and comes with a later frame.
    let defer = effect("refractory").with("period_us", 1_500.0).with("mode", "defer");
    let mut run = sensor(&[count, defer], size(3, 1), 1);
    let times = times_by_pixel(&record(&mut run, 2, 3_000, scene), run.size());
    let stamps =
        |pixel: usize| times[pixel].iter().map(|t| (t * 1e6).round() as i64).collect::<Vec<_>>();
    assert_eq!(stamps(0), [1_000, 3_000, 6_000]);
    assert_eq!(stamps(2), [1_000, 6_000]);
}

#[test]
fn brownian_passages_have_the_mean_rates_of_their_drift() {
    let k = [("k1", 5.265), ("k2", 20.0), ("k3", 1e-4), ("k4", 1e-7), ("k5", 5e-9), ("k6", 1e-5)];
    let voltmeter =
        k.iter().fold(effect("brownian_passage"), |e, (key, value)| e.with(key, *value));
    let mut run = sensor(std::slice::from_ref(&voltmeter), size(20, 20), 4);
    // At rest: the leak of 1e-7 + 5e-9 * 127.5 per microsecond is 0.7375 per second, and half a
    // threshold is on its way at the end.
    let events = record(&mut run, 16_000, 1_000, |_, _, _| 0.5);
    let on = events.iter().filter(|e| e.polarity.is_on()).count() as f64;
    let off = events.len() as f64 - on;
    assert_near((on - off) / (400.0 * 16.0), 0.7375 - 0.5 / 16.0, 0.02);

    // Rising from 51 to 102 codes: k1 times the integral of dI / (I + k2) = 5.265 ln(122 / 71).
    let mut run = sensor(&[voltmeter], size(20, 20), 4);
    let events = record(&mut run, 50, 1_000, |_, _, t| 0.2 + 0.2 * t / 0.05);
    let on = events.iter().filter(|e| e.polarity.is_on()).count() as f64;
    let net = (2.0 * on - events.len() as f64) / 400.0;
    assert_near(net, 5.265 * (122.0 / 71.0f64).ln() - 0.5, 0.7);
}

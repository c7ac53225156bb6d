//! Events without a cause in the light, against closed forms.

use evpose_core::Event;
use evpose_sensor::STAGES;

use crate::support::*;

fn still(effects: &[evpose_sensor::EffectConfig], level: f64, steps: i64) -> Vec<Event> {
    let mut run = sensor(effects, size(40, 30), 3);
    record(&mut run, steps, 1_000, |_, _, _| level)
}

#[test]
fn shot_noise_falls_with_light_and_has_both_signs() {
    let shot = effect("shot_noise_poisson").with("rate_hz", 4.0).with("light_slope", 0.75);
    for level in [0.0, 0.4, 1.0] {
        let events = still(std::slice::from_ref(&shot), level, 1_000);
        let expected = 4.0 * (1.0 - 0.75 * level) * 1_200.0;
        assert_poisson(events.len(), expected);
        assert_poisson(events.iter().filter(|e| e.polarity.is_on()).count(), expected / 2.0);
    }
}

#[test]
fn a_lower_rate_of_shot_noise_has_some_of_the_events_of_a_higher() {
    let at = |rate_hz: f64| -> Vec<(i64, u16, u16, bool)> {
        let shot = effect("shot_noise_poisson").with("rate_hz", rate_hz).with("light_slope", 0.5);
        let events = still(&[shot], 0.3, 1_000);
        events.iter().map(|e| (e.t.0, e.x, e.y, e.polarity.is_on())).collect()
    };
    let high: std::collections::HashSet<_> = at(5.0).into_iter().collect();
    for rate_hz in [4.9, 4.0, 3.0, 0.3] {
        let low = at(rate_hz);
        assert!(low.iter().all(|event| high.contains(event)), "{rate_hz} Hz");
        assert_poisson(low.len(), rate_hz * (1.0 - 0.5 * 0.3) * 1_200.0);
    }
}

#[test]
fn shot_noise_is_poisson_in_time() {
    let events = still(&[effect("shot_noise_poisson").with("rate_hz", 40.0)], 0.5, 1_000);
    let times = times_by_pixel(&events, size(40, 30));
    let all: Vec<f64> = times.iter().flat_map(|t| intervals(t)).collect();
    // An exponential: deviation equals mean. Windows of one second cut long intervals.
    let (m, d) = (mean(&all), deviation(&all));
    assert_near(m, 0.025, 0.001);
    assert_near(d / m, 1.0, 0.05);
    let short = all.iter().filter(|&&t| t < 0.0025).count() as f64 / all.len() as f64;
    assert_near(short, 1.0 - (-0.1f64).exp(), 0.01);
}

#[test]
fn every_spread_in_decades_is_the_deviation_of_decimal_logarithms_of_rates() {
    let mut tried = Vec::new();
    for spec in STAGES.iter() {
        let Some(spread) = spec.number_params().find(|param| param.unit == "decades") else {
            continue;
        };
        tried.push(spec.name);
        let mut stage = effect(spec.name).with(spread.name, 0.2);
        for param in spec.number_params() {
            stage = match param.name {
                "rate_hz" | "median_hz" => stage.with(param.name, 200.0),
                "fraction" | "on_share" => stage.with(param.name, 0.5),
                _ => stage,
            };
        }
        let events = still(&[stage], 0.0, 1_000);
        let counts = times_by_pixel(&events, size(40, 30));
        let rates = counts.iter().filter(|times| !times.is_empty());
        let decades: Vec<f64> = rates.map(|times| (times.len() as f64 / 200.0).log10()).collect();
        assert!(decades.len() > 500, "{}: {}", spec.name, decades.len());
        assert_near(mean(&decades), 0.0, 0.03);
        // Poisson counts themselves scatter by 1 / sqrt(200) = 0.031 decades, regular ones less.
        assert_near(deviation(&decades), 0.2, 0.025);
    }
    for name in ["leak_on", "shot_noise_poisson", "hot_pixels"] {
        assert!(tried.contains(&name), "{name}");
    }
}

#[test]
fn noise_prefers_pixels_of_low_threshold_where_asked() {
    let mismatch = effect("threshold_mismatch").with("sigma", 0.06).with("correlation", 1.0);
    let shot = |law| effect("shot_noise_poisson").with("rate_hz", 300.0).with("threshold", law);
    for (law, expected) in [("inverse", 1.0), ("ignored", 0.0)] {
        let events = still(&[mismatch.clone(), shot(law)], 0.0, 500);
        let counts: Vec<f64> =
            times_by_pixel(&events, size(40, 30)).iter().map(|t| t.len() as f64).collect();
        // Thresholds of 0.2 with a deviation of 0.06 scatter rates by about a third.
        let excess = (deviation(&counts) / mean(&counts)).powi(2) - 1.0 / mean(&counts);
        assert!((excess > 0.05) == (expected > 0.5), "{law}: {excess}");
    }
}

#[test]
fn a_noise_event_resets_its_pixel() {
    // 2 ln/s make ten events per second; a reset every 25 ms leaves few of them.
    let shot = effect("shot_noise_poisson").with("rate_hz", 40.0);
    let mut run = sensor(&[shot], size(20, 20), 3);
    run.label_origins(true);
    let mut signal = 0;
    for k in 0..=1_000i64 {
        let level = light(-3.0 + 2.0 * k as f64 * 1e-3) as f32;
        let plane = evpose_core::Plane::for_sensor(run.size(), level);
        run.expose(&plane, evpose_core::Micros(k * 1_000)).unwrap();
        signal += run
            .origins()
            .unwrap()
            .iter()
            .filter(|origin| **origin == evpose_sensor::Origin::Signal)
            .count();
    }
    // Renewal: intervals without noise for 100 ms. Signal rate = r / (exp(r T) - 1), with T = 0.1.
    let expected = 40.0 / (4f64.exp() - 1.0) * 400.0;
    assert_near(signal as f64, expected, 6.0 * expected.sqrt());
}

#[test]
fn hot_pixels_are_few_and_busy() {
    let hot = effect("hot_pixels")
        .with("fraction", 0.02)
        .with("median_hz", 300.0)
        .with("spread_decades", 0.2)
        .with("on_share", 0.75);
    let events = still(&[hot], 0.5, 1_000);
    let counts: Vec<f64> = times_by_pixel(&events, size(40, 30))
        .iter()
        .filter(|t| !t.is_empty())
        .map(|t| t.len() as f64)
        .collect();
    assert_near(counts.len() as f64, 24.0, 4.0 * 24f64.sqrt());
    let decades: Vec<f64> = counts.iter().map(|c| c.log10()).collect();
    assert_near(mean(&decades), 300f64.log10(), 4.0 * 0.2 / (counts.len() as f64).sqrt());
    let on = events.iter().filter(|e| e.polarity.is_on()).count() as f64;
    assert_near(on / events.len() as f64, 0.75, 0.03);
}

//! Whole sensors against closed forms.

use evpose_core::{Event, Micros, Plane, Polarity, SensorSize};
use evpose_sensor::{EffectConfig, SensorConfig, SensorError, SensorModel, SensorRun};
use proptest::prelude::*;

const ONE: SensorSize = SensorSize { width: 1, height: 1 };
const DARK: f64 = 1e-3;

fn plane(value: f64) -> Plane<f32> {
    Plane::for_sensor(ONE, value as f32)
}

/// Luminance at which a pixel of the ideal sensor has this log voltage.
fn luminance(log: f64) -> f64 {
    log.exp() - DARK
}

fn ideal(threshold_on: f64, threshold_off: f64) -> SensorRun {
    let mut config = SensorConfig::default();
    config.set("level_crossing", "threshold_on", threshold_on).unwrap();
    config.set("level_crossing", "threshold_off", threshold_off).unwrap();
    SensorModel::from_config(&config).unwrap().start(ONE, 0)
}

/// The published sensor without noise, on one pixel.
fn eventhands() -> (SensorConfig, SensorRun) {
    let mut config = SensorConfig::preset("eventhands").unwrap();
    config.set("uniform_noise", "on_hz", 0.0).unwrap();
    config.set("uniform_noise", "off_hz", 0.0).unwrap();
    let run = SensorModel::from_config(&config).unwrap().start(ONE, 0);
    (config, run)
}

fn expose(run: &mut SensorRun, value: f64, t_us: i64) -> Vec<Event> {
    run.expose(&plane(value), Micros(t_us)).unwrap().iter().collect()
}

proptest! {
    #[test]
    fn a_monotone_change_makes_one_event_per_threshold(
        // Three less is still light: below 1e-3 the logarithm is that of darkness.
        from in -3.8..0.0f64, change in -3.0..3.0f64, on in 0.05..0.8f64, off in 0.05..0.8f64,
        steps in 1..20i64,
    ) {
        let mut run = ideal(on, off);
        let (threshold, polarity) =
            if change > 0.0 { (on, Polarity::On) } else { (off, Polarity::Off) };
        // Within a millionth of a level the count is that of the rounding of the voltage.
        let levels = change.abs() / threshold;
        prop_assume!((levels - levels.round()).abs() * threshold > 1e-5);
        expose(&mut run, luminance(from), 0);
        let mut events = Vec::new();
        for k in 1..=steps {
            let log = from + change * k as f64 / steps as f64;
            events.extend(expose(&mut run, luminance(log), k * 1_000));
        }
        prop_assert_eq!(events.len(), levels as usize);
        prop_assert!(events.iter().all(|event| event.polarity == polarity));
    }

    #[test]
    fn on_a_log_ramp_every_event_is_on_time(
        from in -4.0..0.0f64, slope_per_s in 2.0..200.0f64, threshold in 0.05..0.5f64,
        step_us in 100..5_000i64,
    ) {
        let mut run = ideal(threshold, threshold);
        expose(&mut run, luminance(from), 0);
        for k in 1..=10 {
            let log = from + slope_per_s * (k * step_us) as f64 * 1e-6;
            for event in expose(&mut run, luminance(log), k * step_us) {
                // The nearest level is the one crossed; stamps wait for the next microsecond, and
                // two voltages within 2e-6 shift the time by that over the slope.
                let crossing_us = event.t.0 as f64;
                let count = (slope_per_s * crossing_us * 1e-6 / threshold).round();
                let exact_us = count * threshold / slope_per_s * 1e6;
                let tolerance_us = 1.0 + 4e-6 / slope_per_s * 1e6;
                prop_assert!((crossing_us - exact_us).abs() <= tolerance_us);
            }
        }
    }
}

#[test]
fn a_still_scene_makes_no_events() {
    let mut run = ideal(0.2, 0.2);
    for k in 0..100 {
        assert!(expose(&mut run, 0.3, k * 1_000).is_empty());
    }
}

/// Code values 0, 1, 3, 10, 255 and 12 have L = ln(code + 1) = 0, 0.693, 1.386, 2.398, 5.545,
/// 2.565.
#[test]
fn counts_are_those_of_eventhands() {
    let (_, mut run) = eventhands();
    for (step, (code, count, polarity)) in [
        (3.0, 2, Polarity::On),   // cold memory 0, d = 1.386: 2, memory 1.0
        (3.0, 0, Polarity::On),   // d = 0.386
        (10.0, 2, Polarity::On),  // d = 1.398: 2, memory 2.0
        (12.0, 1, Polarity::On),  // d = 0.565: 1, memory 2.5
        (255.0, 6, Polarity::On), // d = 3.045: 6, memory 5.5
        (0.0, 11, Polarity::Off), // d = -5.5: 11, memory 0.0
        (1.0, 1, Polarity::On),   // d = 0.693: 1, memory 0.5
        (0.0, 0, Polarity::On),   // d = -0.5: not strictly below
    ]
    .into_iter()
    .enumerate()
    {
        let t = Micros(step as i64 * 1_000);
        let events = expose(&mut run, code / 255.0, t.0);
        assert_eq!(events.len(), count, "code {code}");
        let same = |e: &Event| e.polarity == polarity && e.t == t;
        assert!(events.iter().all(same), "code {code}");
    }
}

#[test]
fn a_settled_start_is_quiet_where_a_cold_one_bursts() {
    let (mut config, mut cold) = eventhands();
    assert_eq!(expose(&mut cold, 1.0, 0).len(), 11);
    config.set("frame_difference", "start", "settled").unwrap();
    let mut settled = SensorModel::from_config(&config).unwrap().start(ONE, 0);
    assert!(expose(&mut settled, 1.0, 0).is_empty());
}

#[test]
fn a_new_threshold_meets_the_old_memory() {
    let (mut config, mut run) = eventhands();
    expose(&mut run, 3.0 / 255.0, 0); // memory 1.0, voltage 1.386
    config.set("frame_difference", "threshold_on", 0.3).unwrap();
    run.retune(&SensorModel::from_config(&config).unwrap()).unwrap();
    assert_eq!(expose(&mut run, 3.0 / 255.0, 1_000).len(), 1); // d = 0.386 > 0.3
}

#[test]
fn a_run_cannot_become_another_chain() {
    let (_, mut run) = eventhands();
    let refused = run.retune(&SensorModel::from_config(&SensorConfig::default()).unwrap());
    assert!(matches!(refused, Err(SensorError::OtherChain { .. })));
    assert_eq!(expose(&mut run, 3.0 / 255.0, 0).len(), 2);
}

#[test]
fn an_event_stamped_late_is_delivered_with_a_later_exposure() {
    let mut config = SensorConfig::default();
    config.effects.push(EffectConfig::new("timestamp_quantisation").with("period_us", 1_000.0));
    let mut run = SensorModel::from_config(&config).unwrap().start(ONE, 0);
    expose(&mut run, luminance(-1.0), 0);
    assert!(expose(&mut run, luminance(-0.5), 400).is_empty());
    assert!(expose(&mut run, luminance(-0.5), 999).is_empty());
    let late = expose(&mut run, luminance(-0.5), 1_300);
    assert_eq!(late.iter().map(|event| event.t.0).collect::<Vec<_>>(), [1_000, 1_000]);
}

#[test]
fn what_is_no_light_is_darkness_and_counted() {
    let mut run = ideal(0.2, 0.2);
    expose(&mut run, 0.0, 0);
    for (k, value) in [f64::NAN, f64::INFINITY, -1.0].into_iter().enumerate() {
        assert!(expose(&mut run, value, 1_000 * (k as i64 + 1)).is_empty());
    }
    assert_eq!(run.repaired_pixels(), 3);
}

#[test]
fn exposures_must_fit_and_follow() {
    let mut run = ideal(0.2, 0.2);
    let wide = Plane::filled(2, 1, 0.5);
    assert!(matches!(run.expose(&wide, Micros(0)), Err(SensorError::PlaneSize { .. })));
    expose(&mut run, 0.5, 7);
    let again = run.expose(&plane(0.5), Micros(7)).map(|_| ());
    assert_eq!(again, Err(SensorError::NotLater { t: Micros(7), previous: Micros(7) }));
}

#[test]
fn contradicting_effects_are_refused_by_name() {
    let with = |effects: &[&str]| {
        let text: String = effects.iter().map(|e| format!("[[effect]]\n{e}\n")).collect();
        SensorModel::from_config(&SensorConfig::from_toml(&text).unwrap()).unwrap_err().to_string()
    };
    let crossing = "name = 'level_crossing'\nthreshold_on = 0.2\nthreshold_off = 0.2";
    let frames = "name = 'frame_difference'\nthreshold_on = 0.2\nthreshold_off = 0.2";
    assert_eq!(
        with(&[crossing, frames]),
        "`level_crossing` and `frame_difference` are both a change detector, of which a sensor has one"
    );
    assert_eq!(
        with(&[crossing, crossing]),
        "effect `level_crossing` is listed twice; one entry holds all its parameters"
    );
    assert!(
        with(&["name = 'lens'"]).starts_with("unknown effect `lens`; there are: adaptive_steps")
    );
    assert_eq!(
        with(&["name = 'quantisation'\nlevels = 'many'"]),
        "effect `quantisation`: `levels` = \"many\", expected a number in 1..=65535 steps or inf (no effect)"
    );
}

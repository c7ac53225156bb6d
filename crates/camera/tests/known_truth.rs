//! Calibration of simulated recordings with known parameters.

#![expect(clippy::unwrap_used, reason = "a test fails where something is missing")]

use evpose_camera::calibrate::CalibrateError;
use evpose_camera::calibrate::noise::{HotPixelRate, noise};
use evpose_camera::calibrate::threshold::{FLOOR, ThresholdRun, Thresholds};
use evpose_core::stats::interval::Interval;
use evpose_core::{
    CounterRng, Event, EventStream, Micros, Plane, Polarity, SensorSize, TimeWindow,
};
use evpose_sensor::{EffectConfig, SensorConfig, SensorModel};

const SIZE: SensorSize = SensorSize { width: 64, height: 48 };
const FPS: f64 = 1_000.0;

/// A pattern of a factor of seven between dark and bright that moves to and fro.
fn frame(k: usize) -> Plane<f32> {
    let t = k as f32 / FPS as f32;
    let shift = 14.0 * (7.0 * t).sin();
    let value = |x: usize, y: usize| {
        let wave = (0.35 * (x as f32 - shift)).sin() * (0.27 * y as f32 + 3.0 * t).cos();
        0.3 * (0.97 * wave).exp()
    };
    let pixels = (0..usize::from(SIZE.height))
        .flat_map(|y| (0..usize::from(SIZE.width)).map(move |x| (x, y)));
    let data = pixels.map(|(x, y)| value(x, y)).collect();
    Plane::from_vec(usize::from(SIZE.width), usize::from(SIZE.height), data).unwrap()
}

/// Calibrates a camera with `effects` from every `every`-th frame.
fn calibrated(effects: Vec<EffectConfig>, every: usize) -> Result<Thresholds, CalibrateError> {
    let mut config = SensorConfig::from_toml("").unwrap();
    config.effects = effects;
    let mut run = SensorModel::from_config(&config).unwrap().start(SIZE, 3);
    let mut events = EventStream::empty(SIZE);
    let frames: Vec<Plane<f32>> = (0..=1_000).map(frame).collect();
    for (k, frame) in frames.iter().enumerate() {
        let t = Micros::from_seconds(k as f64 / FPS);
        for event in run.expose(frame, t).unwrap().iter() {
            events.push(event).unwrap();
        }
    }
    let mut run = ThresholdRun::new(SIZE, FPS / every as f64, FLOOR, &events)?;
    for frame in frames.iter().step_by(every) {
        run.push(frame)?;
    }
    run.finish(1)
}

fn pixel(on: f64, off: f64) -> Vec<EffectConfig> {
    vec![
        EffectConfig::new("logarithmic").with("dark_offset", 1e-6),
        EffectConfig::new("level_crossing").with("threshold_on", on).with("threshold_off", off),
    ]
}

fn holds(interval: Interval, truth: f64) -> bool {
    interval.low.unwrap() <= truth && truth <= interval.high.unwrap()
}

#[test]
fn steps_of_an_ideal_pixel_are_its_thresholds() {
    let found = calibrated(pixel(0.2, 0.3), 1).unwrap();
    for (interval, truth) in [(found.by_steps_on, 0.2), (found.by_steps_off, 0.3)] {
        assert!((interval.estimate / truth - 1.0).abs() < 0.01, "{interval:?}");
    }
    // A part of a threshold is left in every pixel at each turn, which totals cannot know.
    assert!(found.by_totals_on.estimate > 0.2 && found.by_totals_on.estimate < 0.26, "{found:?}");
    assert!(found.by_totals_off.estimate > 0.3, "{found:?}");
    let both = found.by_totals.estimate;
    assert!(found.by_totals_on.estimate < both && both < found.by_totals_off.estimate);
}

#[test]
fn totals_come_nearer_the_smaller_the_threshold() {
    let excess = |threshold: f64| {
        let found = calibrated(pixel(threshold, threshold), 1).unwrap();
        found.by_totals.estimate / threshold - 1.0
    };
    let [large, middle, small] = [0.3, 0.1, 0.03].map(excess);
    // What is left at every turn is in proportion to the threshold.
    for (excess, threshold) in [(large, 0.3), (middle, 0.1), (small, 0.03)] {
        let part = excess / threshold;
        assert!((0.8..1.5).contains(&part), "{large} {middle} {small}");
    }
}

#[test]
fn steps_do_not_mind_noise_and_mismatch() {
    let mut effects = pixel(0.2, 0.2);
    effects.push(EffectConfig::new("threshold_mismatch").with("sigma", 0.02));
    effects.push(EffectConfig::new("uniform_noise").with("on_hz", 2.0).with("off_hz", 0.5));
    let found = calibrated(effects, 1).unwrap();
    for interval in [found.by_steps_on, found.by_steps_off] {
        assert!((interval.estimate / 0.2 - 1.0).abs() < 0.03, "{interval:?}");
        assert!(interval.high.unwrap() - interval.low.unwrap() < 0.02, "{interval:?}");
    }
}

#[test]
fn frames_of_an_ordinary_camera_are_enough_for_slow_motion() {
    // 100 frames per second: light runs in a line in between.
    let found = calibrated(pixel(0.2, 0.2), 10).unwrap();
    assert!((found.by_steps_on.estimate / 0.2 - 1.0).abs() < 0.05, "{found:?}");
}

#[test]
fn what_says_nothing_is_refused() {
    let error = calibrated(pixel(3.0, 3.0), 1).unwrap_err();
    assert!(matches!(error, CalibrateError::TooFewEvents { actual: 0, .. }), "{error}");
    let events = EventStream::empty(SIZE);
    let still = |frames: usize| {
        let mut run = ThresholdRun::new(SIZE, FPS, FLOOR, &events).unwrap();
        (0..frames).for_each(|_| run.push(&frame(0)).unwrap());
        run.finish(1).unwrap_err()
    };
    assert!(matches!(still(1), CalibrateError::TooFewFrames(1)));
    assert!(matches!(still(3), CalibrateError::NoChange));
    let other = SensorSize { width: 9, height: 9 };
    assert!(ThresholdRun::new(other, FPS, FLOOR, &events).is_err());
}

/// Events at rates per pixel and second, ON and OFF, over ten seconds.
fn at_rest(rates: impl Fn(usize) -> [f64; 2]) -> EventStream {
    let mut events = Vec::new();
    for pixel in 0..SIZE.pixels() {
        for (polarity, rate) in [Polarity::On, Polarity::Off].into_iter().zip(rates(pixel)) {
            let mut rng =
                CounterRng::new(7, "rest", 2 * pixel as u64 + u64::from(polarity.is_on()));
            let mut t_s = 0.0_f64;
            loop {
                // Intervals of a Poisson process are exponential.
                t_s -= f64::from(rng.unit()).ln() / rate;
                if t_s >= 10.0 {
                    break;
                }
                let (x, y) = ((pixel % 64) as u16, (pixel / 64) as u16);
                events.push(Event { t: Micros::from_seconds(t_s), x, y, polarity });
            }
        }
    }
    events.sort_by_key(|event| event.t);
    EventStream::from_events(SIZE, events).unwrap()
}

const TEN_S: TimeWindow = TimeWindow { start: Micros(0), end: Micros(10_000_000) };

#[test]
fn rates_at_rest_are_found_beside_hot_pixels() {
    let hot = [77, 1_500, 2_999];
    let events = at_rest(|pixel| match hot.iter().position(|p| *p == pixel) {
        Some(i) => [40.0 * (i + 1) as f64, 3.0],
        None => [0.6, 0.05],
    });
    let found = noise(&events, TEN_S, 1).unwrap();
    assert!(holds(found.on_hz, 0.6), "{:?}", found.on_hz);
    assert!(holds(found.off_hz, 0.05), "{:?}", found.off_hz);
    let places: Vec<usize> = found
        .hot
        .iter()
        .map(|HotPixelRate { x, y, .. }| usize::from(*y) * 64 + usize::from(*x))
        .collect();
    assert_eq!(places, [2_999, 1_500, 77]);
    assert!((found.hot[0].on_hz / 120.0 - 1.0).abs() < 0.1, "{:?}", found.hot[0]);
    assert!(found.unrest < 1.3, "{}", found.unrest);
    let all = 0.6 * f64::from(3_072 - 3) + 240.0;
    assert!((found.all_on_hz / all - 1.0).abs() < 0.05, "{}", found.all_on_hz);
}

#[test]
fn even_noise_has_no_hot_pixels_and_motion_is_noticed() {
    let even = at_rest(|_| [1.0, 1.0]);
    assert!(noise(&even, TEN_S, 1).unwrap().hot.is_empty());
    // Everything in one second of ten.
    let early = even.iter().map(|event| Event { t: Micros(event.t.0 / 10), ..event });
    let early = EventStream::from_events(SIZE, early).unwrap();
    assert!(noise(&early, TEN_S, 1).unwrap().unrest > 5.0);
    let short = TimeWindow { start: Micros(0), end: Micros(10_000) };
    assert!(matches!(noise(&even, short, 1), Err(CalibrateError::TooShort(..))));
}

#[test]
fn nothing_at_all_is_a_rate_of_zero() {
    let found = noise(&EventStream::empty(SIZE), TEN_S, 1).unwrap();
    assert_eq!((found.on_hz.estimate, found.off_hz.estimate), (0.0, 0.0));
    assert!(found.hot.is_empty());
}

//! Calibrations whose results are known by hand: light that goes up and down between two levels,
//! and scenes at rest in which every pixel has so many events.

#![expect(clippy::unwrap_used, reason = "a test fails where something is missing")]

use evpose_camera::calibrate::CalibrateError;
use evpose_camera::calibrate::noise::{Noise, noise};
use evpose_camera::calibrate::threshold::{FLOOR, ThresholdRun, Thresholds};
use evpose_core::stats::interval::Interval;
use evpose_core::{Event, EventStream, Micros, Plane, Polarity, SensorSize, TimeWindow};

fn stream(size: SensorSize, mut events: Vec<Event>) -> EventStream {
    events.sort_by_key(|event| event.t);
    EventStream::from_events(size, events).unwrap()
}

fn pixels(size: SensorSize) -> impl Iterator<Item = (u16, u16)> {
    (0..size.height).flat_map(move |y| (0..size.width).map(move |x| (x, y)))
}

const SMALL: SensorSize = SensorSize { width: 3, height: 2 };
/// Time from frame to frame.
const STEP_US: i64 = 10_000;

/// Light that goes up and down `cycles` times between `low` and `high` of a pixel's number and up once
/// more, with `on` and `off` events of every pixel at even times of each rise and fall.
fn swings(
    low: f32,
    high: impl Fn(usize) -> f32,
    counts: [i64; 2],
    (cycles, floor): (usize, f32),
) -> Result<Thresholds, CalibrateError> {
    swings_at(&|frame| STEP_US * frame, low, high, counts, cycles, &|events| {
        ThresholdRun::new(SMALL, 1e6 / STEP_US as f64, floor, events)
    })
}

/// As [`swings`], with frames at times of their own in microseconds.
fn swings_at(
    at_us: &dyn Fn(i64) -> i64,
    low: f32,
    high: impl Fn(usize) -> f32,
    [on, off]: [i64; 2],
    cycles: usize,
    begin: &dyn Fn(&EventStream) -> Result<ThresholdRun<'_>, CalibrateError>,
) -> Result<Thresholds, CalibrateError> {
    let mut events = Vec::new();
    for change in 0..=2 * cycles as i64 {
        let (polarity, count) =
            if change % 2 == 0 { (Polarity::On, on) } else { (Polarity::Off, off) };
        for (x, y) in pixels(SMALL) {
            let step_us = at_us(change + 1) - at_us(change);
            let t = |k: i64| Micros(at_us(change) + step_us * k / count);
            events.extend((1..=count).map(|k| Event { t: t(k), x, y, polarity }));
        }
    }
    // After the last frame: of no use.
    let late = Micros(at_us(2 * cycles as i64 + 1) + 1);
    events.extend((0..300).map(|_| Event { t: late, x: 0, y: 0, polarity: Polarity::On }));
    let events = stream(SMALL, events);
    let mut run = begin(&events)?;
    for frame in 0..2 * cycles + 2 {
        let light = |pixel: usize| if frame % 2 == 0 { low } else { high(pixel) };
        run.push(&Plane::from_vec(3, 2, (0..6).map(light).collect()).unwrap())?;
    }
    run.finish(1)
}

fn near(interval: Interval, wanted: f64, tolerance: f64) {
    for end in [Some(interval.estimate), interval.low, interval.high] {
        assert!((end.unwrap() - wanted).abs() < tolerance, "{interval:?}, not {wanted}");
    }
}

#[test]
fn thresholds_are_the_change_of_log_light_over_the_events_above_the_floor() {
    for (low, high, floor, change) in [
        (0.1, 0.8, FLOOR, 8f64.ln()),
        (0.0, 0.8, FLOOR, (0.8 / f64::from(FLOOR)).ln()),
        (0.02, 0.8, FLOOR, (0.8 / f64::from(FLOOR)).ln()),
        (0.1, 0.8, 0.3, (0.8f64 / 0.3).ln()),
    ] {
        let found = swings(low, |_| high, [4, 10], (20, floor)).unwrap();
        near(found.by_totals_on, change / 4.0, 1e-5);
        near(found.by_totals_off, change / 10.0, 1e-5);
        near(found.by_totals, 41.0 * change / (21.0 * 4.0 + 20.0 * 10.0), 1e-5);
        // Medians are as fine as the bins that heights are counted in.
        near(found.by_steps_on, change / 4.0, 6e-4);
        near(found.by_steps_off, change / 10.0, 6e-4);
        assert_eq!((found.on, found.off, found.frames), (21 * 6 * 4, 20 * 6 * 10, 42));
    }
}

#[test]
fn frames_may_be_at_times_of_their_own() {
    let at_us = |frame: i64| STEP_US * (frame * frame + frame) / 2;
    let times_s: Vec<f64> = (0..42).map(|frame| 1e-6 * at_us(frame) as f64).collect();
    let found = swings_at(&at_us, 0.1, |_| 0.8, [4, 10], 20, &|events| {
        Ok(ThresholdRun::new(SMALL, 100.0, FLOOR, events)?.at_times(times_s.clone()))
    });
    let found = found.unwrap();
    near(found.by_steps_on, 8f64.ln() / 4.0, 6e-4);
    near(found.by_steps_off, 8f64.ln() / 10.0, 6e-4);
    assert_eq!((found.on, found.off, found.frames), (21 * 6 * 4, 20 * 6 * 10, 42));
    // At a constant rate most events come behind the last frame.
    let found = swings_at(&at_us, 0.1, |_| 0.8, [40, 100], 20, &|events| {
        ThresholdRun::new(SMALL, 100.0, FLOOR, events)
    });
    assert!(found.is_ok_and(|found| found.on < 21 * 6 * 40 / 2));
}

#[test]
fn tiles_that_differ_widen_the_interval_around_their_common_ratio() {
    let found = swings(0.1, |pixel| 0.1 * (pixel + 2) as f32, [4, 5], (20, FLOOR)).unwrap();
    let mean = (2..8).map(|n| f64::from(n).ln()).sum::<f64>() / 6.0;
    for (interval, events) in [(found.by_totals_on, 4.0), (found.by_totals_off, 5.0)] {
        assert!((interval.estimate - mean / events).abs() < 1e-5, "{interval:?}");
        let (low, high) = (interval.low.unwrap(), interval.high.unwrap());
        let (least, most) = (2f64.ln() / events, 7f64.ln() / events);
        assert!(least < low && low < interval.estimate, "{interval:?}");
        assert!(interval.estimate < high && high < most, "{interval:?}");
    }
}

#[test]
fn two_hundred_events_of_each_polarity_are_enough_and_fewer_are_not() {
    // Two rises and a fall of 6 pixels: 17 x 12 = 204 and 16 x 12 = 192, 34 x 6 = 204 and 33 x 6 = 198.
    assert!(swings(0.1, |_| 0.8, [17, 34], (1, FLOOR)).is_ok());
    for (events, missing) in [([16, 34], "192 ON events"), ([17, 33], "198 OFF events")] {
        let error = swings(0.1, |_| 0.8, events, (1, FLOOR)).unwrap_err();
        assert!(error.to_string().starts_with(missing), "{error}");
    }
    let nothing = swings(0.8, |_| 0.8, [34, 34], (1, FLOOR));
    assert!(matches!(nothing, Err(CalibrateError::NoChange)));
    let none = EventStream::empty(SMALL);
    let mut run = ThresholdRun::new(SMALL, 1.0, FLOOR, &none).unwrap();
    let other = run.push(&Plane::filled(2, 3, 0.5));
    assert!(matches!(other, Err(CalibrateError::Size { .. })));
    let exactly = stream(
        SMALL,
        (0..400)
            .map(|k| Event { t: Micros(k), x: 0, y: 0, polarity: Polarity::from_on(k % 2 > 0) })
            .collect(),
    );
    let mut run = ThresholdRun::new(SMALL, 1.0, FLOOR, &exactly).unwrap();
    [0.2, 0.4].iter().for_each(|light| run.push(&Plane::filled(3, 2, *light)).unwrap());
    assert!(run.finish(1).is_ok(), "200 and 200");
}

const LARGE: SensorSize = SensorSize { width: 64, height: 48 };
/// Two seconds, not from zero on.
const WINDOW: TimeWindow = TimeWindow { start: Micros(1_000_000), end: Micros(3_000_000) };

/// Pixels with so many ON and OFF events at even times of a part of the window, and some before
/// and after it.
fn at_rest(counts: impl Fn(u16, u16) -> [i64; 2], part: i64) -> Noise {
    let mut events = Vec::new();
    for (x, y) in pixels(LARGE) {
        for (polarity, count) in [Polarity::On, Polarity::Off].into_iter().zip(counts(x, y)) {
            let t = |k: i64| {
                WINDOW.start + Micros((2 * k + 1) * WINDOW.length().0 / (2 * count * part))
            };
            events.extend((0..count).map(|k| Event { t: t(k), x, y, polarity }));
            // Events just before and behind the window must not count.
            let outside = [WINDOW.start - Micros(1), WINDOW.end];
            events.extend(outside.map(|t| Event { t, x, y, polarity }));
        }
    }
    noise(&stream(LARGE, events), WINDOW, 1).unwrap()
}

#[test]
fn rates_are_events_a_second_of_each_polarity_without_hot_pixels() {
    let found = at_rest(|x, y| if (x, y) == (63, 0) { [60_000, 40_000] } else { [20, 60] }, 1);
    near(found.on_hz, 10.0, 1e-9);
    near(found.off_hz, 30.0, 1e-9);
    let hot: Vec<_> = found.hot.iter().map(|hot| (hot.x, hot.y, hot.on_hz, hot.off_hz)).collect();
    assert_eq!(hot, [(63, 0, 30_000.0, 20_000.0)]);
    assert_eq!(found.all_on_hz, (3_071.0 * 20.0 + 60_000.0) / 2.0);
    assert_eq!(found.all_off_hz, (3_071.0 * 60.0 + 40_000.0) / 2.0);
    assert_eq!((found.unrest, found.seconds), (1.0, 2.0));
}

#[test]
fn a_pixel_is_hot_beyond_what_poisson_counts_of_five_times_the_mean_reach() {
    // Of mean 100, a count above 148 has a probability of 2.9e-6, below 0.01 / 3072; one above 147
    // of 4.1e-6. The pixel itself is in the mean at first, 20.04, which leaves the limit where it is.
    for (count, is_hot) in [(148, false), (149, true)] {
        let found = at_rest(|x, y| if (x, y) == (7, 9) { [40, count - 40] } else { [20, 0] }, 1);
        assert_eq!(found.hot.len(), usize::from(is_hot), "{count}");
    }
}

#[test]
fn hot_pixels_hide_behind_hotter_ones_until_those_are_left_out() {
    // 100,000 events raise the mean to 52.5: the limit is 339 at first.
    let found = at_rest(
        |x, y| match (x, y) {
            (3, 3) => [0, 100_000],
            (9, 9) => [0, 200],
            (12, 12) => [300, 0],
            _ => [20, 0],
        },
        1,
    );
    let places: Vec<_> = found.hot.iter().map(|hot| (hot.x, hot.y)).collect();
    assert_eq!(places, [(3, 3), (12, 12), (9, 9)]);
}

#[test]
fn unrest_is_the_busiest_twentieth_over_the_mean() {
    for part in [1, 2, 4, 20] {
        let found = at_rest(|_, _| [20, 20], part);
        assert!((found.unrest - part as f64).abs() < 1e-12, "{part}: {}", found.unrest);
        assert_eq!(found.on_hz.estimate, 10.0);
        let is_even = found.on_hz.low == found.on_hz.high;
        assert_eq!(is_even, part == 1, "{:?}", found.on_hz);
    }
}

#[test]
fn a_tenth_of_a_second_is_long_enough() {
    let events = EventStream::empty(LARGE);
    for (length_us, is_enough) in [(100_000, true), (99_999, false)] {
        let window = TimeWindow { start: Micros(0), end: Micros(length_us) };
        assert_eq!(noise(&events, window, 1).is_ok(), is_enough);
    }
    let nothing = noise(&events, WINDOW, 1).unwrap();
    assert_eq!((nothing.unrest, nothing.all_on_hz), (0.0, 0.0));
}

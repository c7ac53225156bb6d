//! Pixels that wait for the readout, and a bus that reads rows, against closed forms.

use std::collections::BTreeMap;

use evpose_core::{Event, Micros, Plane};
use evpose_sensor::{EffectConfig, SensorConfig, SensorModel};

use crate::support::*;

const WAITING: [&str; 3] = ["reset", "kept", "free"];

/// A bus of 20 us per event and 100 us per row.
fn rows(waiting: &str) -> EffectConfig {
    let bus = effect("arbiter").with("rate_hz", 50_000.0).with("row_ns", 100_000.0);
    bus.with("order", "rows").with("waiting", waiting)
}

fn model(effects: &[EffectConfig]) -> SensorModel {
    SensorModel::from_config(&SensorConfig { effects: effects.to_vec() }).unwrap()
}

/// Events of one pixel whose light rises by four thresholds and a half in the first millisecond,
/// in milliseconds. It reaches them at 2/9, 4/9, 6/9 and 8/9.
fn rise_of_four(readout: EffectConfig) -> Vec<f64> {
    let mut run = sensor(&[readout], size(1, 1), 1);
    let events = record(&mut run, 80, 1_000, |_, _, t| light(-2.0 + 4.5 * C * t.min(1e-3) / 1e-3));
    events.iter().map(|event| event.t.0 as f64 * 1e-3).collect()
}

#[track_caller]
fn assert_times(actual: &[f64], expected: &[f64]) {
    let are_near = actual.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2.1e-3);
    assert!(actual.len() == expected.len() && are_near, "{actual:?}, expected {expected:?}");
}

#[test]
fn a_scan_sees_one_change_of_many_or_one_a_visit_or_all_at_once() {
    for period_us in [10_000.0, 9_130.0, 7_777.0] {
        let visit = |k: usize| (k as f64 + 0.5) * period_us * 1e-3;
        let scan = |waiting| {
            effect("scanned_readout").with("period_us", period_us).with("waiting", waiting)
        };
        assert_times(&rise_of_four(scan("reset")), &[visit(0)]);
        assert_times(&rise_of_four(scan("kept")), &[0, 1, 2, 3].map(visit));
        assert_times(&rise_of_four(scan("free")), &[0, 0, 0, 0].map(visit));
        assert_times(&rise_of_four(scan("latched")), &[visit(0)]);
    }
}

#[test]
fn a_bus_serves_one_change_of_many_or_all_in_turn() {
    let bus = |order, waiting| {
        let bus = effect("arbiter").with("rate_hz", 100.0).with("row_ns", 100_000.0);
        bus.with("order", order).with("waiting", waiting)
    };
    // In order of arrival only the first event is one of another row.
    let first = 2.0 / 9.0 + 10.1;
    let in_turn = [0.0, 10.0, 20.0, 30.0].map(|late| first + late);
    assert_times(&rise_of_four(bus("arrival", "reset")), &[first]);
    assert_times(&rise_of_four(bus("arrival", "kept")), &in_turn);
    assert_times(&rise_of_four(bus("arrival", "free")), &in_turn);
    // In order of rows each turn has one, or the second all that have come in the meantime.
    assert_times(&rise_of_four(bus("rows", "reset")), &[first]);
    assert_times(&rise_of_four(bus("rows", "kept")), &[0.0, 10.1, 20.2, 30.3].map(|l| first + l));
    assert_times(&rise_of_four(bus("rows", "free")), &[0.0, 10.1, 20.1, 30.1].map(|l| first + l));
}

/// Times of the events of 6 by 5 pixels while a wave passes, until 45 ms.
fn times_of_wave(effects: &[EffectConfig]) -> Vec<Vec<f64>> {
    let mut run = sensor(effects, size(6, 5), 1);
    let wave = |x: usize, t: f64| 0.9 * (t * 300.0 + x as f64).sin();
    let events = record(&mut run, 100, 500, |x, _, t| light(-2.0 + wave(x, t.min(0.045))));
    times_by_pixel(&events, size(6, 5))
}

#[test]
fn a_pixel_that_goes_on_has_every_event_at_the_next_visit() {
    let scan = effect("scanned_readout").with("period_us", 2_000.0).with("waiting", "free");
    let (ideal, scanned) = (times_of_wave(&[]), times_of_wave(&[scan]));
    for (pixel, (ideal, scanned)) in ideal.iter().zip(&scanned).enumerate() {
        assert!(ideal.len() > 20 && ideal.len() == scanned.len(), "{pixel}");
        let phase = ((pixel / 6) as f64 + 0.5) / 5.0;
        for (asked_s, served_s) in ideal.iter().zip(scanned) {
            let visit_s = ((asked_s / 0.002 - phase).ceil() + phase) * 0.002;
            assert_near(*served_s, visit_s, 1.1e-6);
        }
    }
}

#[test]
fn a_latch_keeps_the_first_event_of_every_visit() {
    let scan = effect("scanned_readout").with("period_us", 9_000.0);
    let [free, latched] =
        ["free", "latched"].map(|waiting| times_of_wave(&[scan.clone().with("waiting", waiting)]));
    for (mut free, latched) in free.into_iter().zip(latched) {
        let all = free.len();
        free.dedup();
        assert!(free.len() < all, "several events a visit");
        assert_eq!(free, latched);
    }
}

/// The leak goes on in the level that a pixel keeps, beyond the second after which leaks are taken
/// into memories.
#[test]
fn a_pixel_that_keeps_its_level_loses_no_leak() {
    let leak = effect("leak_on").with("rate_hz", 0.9);
    for order in ["arrival", "rows"] {
        let bus = effect("arbiter").with("rate_hz", 1.0).with("order", order);
        let interval_with = |waiting| {
            let mut run =
                sensor(&[leak.clone(), bus.clone().with("waiting", waiting)], size(1, 1), 1);
            let events = record(&mut run, 1_500, 10_000, |_, _, _| 0.5);
            let times: Vec<f64> = events.iter().map(|e| e.t.as_seconds()).collect();
            intervals(&times)
        };
        let (kept, reset) = (interval_with("kept"), interval_with("reset"));
        assert!(kept.len() > 10 && reset.len() > 4);
        kept.iter().for_each(|interval| assert_near(*interval, 1.0 / 0.9, 1e-4));
        reset.iter().for_each(|interval| assert_near(*interval, 1.0 / 0.9 + 1.0, 1e-4));
    }
}

/// A flash of one and a half thresholds in the first half of a millisecond.
fn flash(_: usize, _: usize, t: f64) -> f64 {
    light(-2.0 + if t > 0.0 { 0.3 } else { 0.0 })
}

/// When pixels ask in a flash, in microseconds.
const ASKED_US: f64 = 500.0 * 0.2 / 0.3;

#[test]
fn a_flash_leaves_row_by_row() {
    for waiting in WAITING {
        let mut run = sensor(&[rows(waiting)], size(10, 4), 1);
        let events = record(&mut run, 20, 500, flash);
        assert_eq!(events.len(), 40);
        for (k, event) in events.iter().enumerate() {
            let (row, column) = (k / 10, k % 10);
            assert_eq!((usize::from(event.y), usize::from(event.x)), (row, column));
            let late_us = 100.0 * (row + 1) as f64 + 20.0 * (k + 1) as f64;
            assert_near(event.t.0 as f64, ASKED_US + late_us, 1.1);
        }
    }
}

#[test]
fn a_detector_that_does_not_wait_asks_for_rows_as_well() {
    let frames = effect("frame_count").with("threshold_on", C).with("threshold_off", C);
    let mut run = sensor(&[frames, rows("reset")], size(10, 4), 1);
    let events = record(&mut run, 20, 500, flash);
    assert_eq!(events.len(), 40);
    for (k, event) in events.iter().enumerate() {
        let late_us = 100.0 * (k / 10 + 1) as f64 + 20.0 * (k + 1) as f64;
        assert_near(event.t.0 as f64, 500.0 + late_us, 1.1);
    }
}

#[test]
fn rows_that_have_waited_too_long_are_lost() {
    for waiting in WAITING {
        // The third row has waited for 600 us when the first two have been read.
        let mut run = sensor(&[rows(waiting).with("max_wait_us", 350.0)], size(10, 4), 1);
        let events = record(&mut run, 20, 500, flash);
        assert_eq!(events.len(), 20);
        assert!(events.iter().all(|event| event.y < 2));
    }
}

/// Pixels whose requests are lost are reset then, and see what comes later.
#[test]
fn a_pixel_whose_request_is_lost_goes_on() {
    let mut run = sensor(&[rows("reset").with("max_wait_us", 350.0)], size(10, 4), 1);
    let events = record(&mut run, 40, 500, |x, y, t| {
        let step = if t > 0.0095 && y == 3 { 0.3 } else { 0.0 };
        flash(x, y, t) * f64::exp(step)
    });
    assert_eq!(events.iter().filter(|event| event.y == 3).count(), 10);
}

#[test]
fn noise_takes_its_turn_in_its_row() {
    let noise = effect("uniform_noise").with("on_hz", 200.0).with("off_hz", 200.0);
    let hot =
        effect("hot_pixels").with("fraction", 0.2).with("median_hz", 300.0).with("on_share", 0.7);
    for waiting in WAITING {
        let bus = effect("arbiter").with("rate_hz", 2_000.0).with("order", "rows");
        let bus = bus.with("waiting", waiting);
        let mut run = sensor(&[noise.clone(), hot.clone(), bus], size(8, 6), 1);
        let events = record(&mut run, 300, 1_000, |_, _, _| 0.5);
        let times: Vec<i64> = events.iter().map(|event| event.t.0).collect();
        assert!((580..=600).contains(&times.len()), "{waiting}: {}", times.len());
        assert!(times.windows(2).all(|pair| pair[1] - pair[0] >= 499), "{waiting}");
    }
}

/// Events of a scene that moves on until 20 ms, shown every `step_us`, in order of pixels. No two
/// pixels ask at the same times, whose order would be one of rounding.
fn moving(readout: EffectConfig, step_us: i64) -> Vec<Event> {
    let mut run = sensor(&[readout], size(5, 4), 1);
    let mut events = record(&mut run, 60_000 / step_us, step_us, |x, y, t| {
        light(-4.0 + (101.3 + 17.7 * x as f64 + 4.3 * y as f64) * t.min(0.02))
    });
    events.sort_by_key(|event| (event.y, event.x, event.t));
    events
}

#[test]
fn it_does_not_matter_how_time_is_divided() {
    for waiting in WAITING {
        let whole = moving(rows(waiting), 1_000);
        assert!(whole.len() > 100);
        for step_us in [250, 500, 2_000, 10_000] {
            let parts = moving(rows(waiting), step_us);
            assert_eq!(parts.len(), whole.len(), "{waiting} {step_us}");
            for (a, b) in parts.iter().zip(&whole) {
                assert!((a.t.0 - b.t.0).abs() <= 1 && (a.x, a.y) == (b.x, b.y), "{a:?} {b:?}");
            }
        }
    }
}

/// Waves and noise, a millisecond apart.
fn waves(model: &SensorModel, seed: u64) -> Vec<Vec<Event>> {
    let mut run = model.start(size(27, 17), seed);
    let mut show = |step: i64| -> Vec<Event> {
        let mut plane = Plane::for_sensor(run.size(), 0.0);
        for (i, y) in plane.data_mut().iter_mut().enumerate() {
            *y = 0.02 + 0.5 * (1.0 + (i as f32 * 0.37 + step as f32 * 0.6).sin());
        }
        run.expose(&plane, Micros(step * 1_000)).unwrap().iter().collect()
    };
    (0..20).map(&mut show).collect()
}

#[test]
fn blocks_do_not_matter_and_events_come_in_order_whatever_is_chosen() {
    let noise = effect("uniform_noise").with("on_hz", 30.0).with("off_hz", 20.0);
    for (waiting, max_wait_us) in WAITING.into_iter().flat_map(|w| [(w, f64::INFINITY), (w, 900.0)])
    {
        let bus = rows(waiting).with("rate_hz", 100_000.0).with("max_wait_us", max_wait_us);
        let model = model(&[noise.clone(), bus]);
        let expected = waves(&model, 7);
        let count = expected.concat().len();
        assert!(count > 300, "{waiting} {max_wait_us}: {count}");
        for (step, events) in expected.iter().enumerate() {
            let (end, key) = (step as i64 * 1_000, |e: &Event| (e.t, e.y, e.x));
            assert!(events.is_sorted_by_key(key));
            assert!(events.iter().all(|e| e.t.0 > end - 1_000 && e.t.0 <= end));
        }
        for block in [1, 16, 333, 8_192] {
            assert_eq!(waves(&model.clone().with_block_pixels(block), 7), expected, "{waiting}");
        }
    }
}

/// A request that waits for its row is served even if the bus then takes requests as they come.
#[test]
fn a_bus_that_changes_its_order_forgets_nobody() {
    let frames = effect("frame_count").with("threshold_on", C).with("threshold_off", C);
    for detector in
        [effect("level_crossing").with("threshold_on", C).with("threshold_off", C), frames]
    {
        let model = |bus| model(&[detector.clone(), bus]);
        let mut run = model(rows("reset")).start(size(10, 4), 1);
        let mut pixels = BTreeMap::new();
        for k in 0..20_i64 {
            let t = Micros(k * 500);
            if k == 3 {
                run.retune(&model(rows("reset").with("order", "arrival"))).unwrap();
            }
            let plane = Plane::for_sensor(run.size(), flash(0, 0, t.as_seconds()) as f32);
            for event in run.expose(&plane, t).unwrap().iter() {
                *pixels.entry((event.x, event.y)).or_insert(0) += 1;
            }
        }
        assert!(pixels.len() == 40 && pixels.values().all(|count| *count == 1));
    }
}

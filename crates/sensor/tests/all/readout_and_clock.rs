//! Order of service and time stamps, against closed forms.

use std::collections::BTreeMap;

use crate::support::*;

/// A flash of one and a half thresholds within a microsecond: all pixels at once.
fn flash(
    effects: &[evpose_sensor::EffectConfig],
    width: u16,
    height: u16,
) -> Vec<evpose_core::Event> {
    let mut run = sensor(effects, size(width, height), 1);
    record(&mut run, 40, 500, |_, _, t| light(-2.0 + if t > 0.0 { 0.3 } else { 0.0 }))
}

#[test]
fn a_flash_leaves_an_arbiter_at_its_rate() {
    let arbiter = effect("arbiter").with("rate_hz", 50_000.0);
    let events = flash(&[arbiter], 20, 10);
    assert_eq!(events.len(), 200);
    // All request at 2/3 of the first step; 20 us each.
    let first = 1e6 * 0.0005 * (0.2 / 0.3);
    for (k, event) in events.iter().enumerate() {
        assert_near(event.t.0 as f64, first + 20.0 * (k + 1) as f64, 2.0);
    }
}

#[test]
fn a_pixel_that_waits_is_reset_when_it_is_served() {
    // 40 ln/s: a threshold every 5 ms. An event takes 3 ms on the bus, in which the pixel is blind.
    let arbiter = effect("arbiter").with("rate_hz", 1.0 / 0.003);
    let mut run = sensor(&[arbiter], size(1, 1), 1);
    let events = record(&mut run, 150, 1_000, |_, _, t| light(-5.0 + 40.0 * t));
    let times: Vec<f64> = events.iter().map(|e| e.t.as_seconds()).collect();
    assert!(times.len() > 15);
    for interval in intervals(&times) {
        assert_near(interval, 0.008, 3e-6);
    }
}

/// A visit behind the end of a step has a stamp before it on a clock that is behind, and the next
/// step has visits with earlier stamps.
#[test]
fn a_clock_that_is_behind_keeps_events_in_order_from_step_to_step() {
    let scan = effect("scanned_readout").with("period_us", 240.0);
    let late = effect("clock_offset_drift").with("offset_us", -7.0);
    let mut run = sensor(&[scan, late], size(16, 12), 1);
    let events = record(&mut run, 100, 1_000, |x, y, t| {
        light(-3.0 + (40.0 + x as f64) * t + 0.01 * y as f64)
    });
    assert!(events.len() > 1_000);
    assert!(events.is_sorted_by_key(|event| event.t));
}

#[test]
fn rows_are_served_together() {
    let arbiter = effect("arbiter").with("rate_hz", 1e6).with("row_ns", 10_000.0);
    let events = flash(&[arbiter], 10, 5);
    let times: Vec<i64> = events.iter().map(|e| e.t.0).collect();
    for (k, pair) in times.windows(2).enumerate() {
        let expected = if (k + 1) % 10 == 0 { 11 } else { 1 };
        assert!((pair[1] - pair[0] - expected).abs() <= 1, "{k}");
    }
}

#[test]
fn a_scan_locks_times_to_columns_and_gives_one_event_per_visit() {
    let scan = |axis, direction| {
        effect("scanned_readout")
            .with("period_us", 2_000.0)
            .with("axis", axis)
            .with("direction", direction)
    };
    for (axis, direction) in
        [("rows", "forward"), ("rows", "backward"), ("columns", "forward"), ("columns", "backward")]
    {
        let mut run = sensor(&[scan(axis, direction)], size(10, 8), 1);
        // 400 ln/s would be two events per ms without the scan.
        let events = record(&mut run, 20, 500, |_, _, t| light(-5.0 + 400.0 * t.min(0.01)));
        let mut by_pixel = BTreeMap::new();
        for e in &events {
            let (line, lines) = if axis == "rows" { (e.y, 8) } else { (e.x, 10) };
            let line = if direction == "backward" { lines - 1 - line } else { line };
            let phase = (f64::from(line) + 0.5) / f64::from(lines) * 2_000.0;
            let late = (e.t.0 as f64 - phase).rem_euclid(2_000.0);
            assert!(!(1.01..1_999.9).contains(&late), "{axis} {direction}: {e:?}");
            by_pixel.entry((e.x, e.y)).or_insert_with(Vec::new).push(e.t.0);
        }
        assert_eq!(by_pixel.len(), 80);
        for times in by_pixel.values() {
            assert!((4..=5).contains(&times.len()), "{times:?}");
            // A visit at an exposure can be stamped a microsecond behind it.
            let is_a_period = |pair: &[i64]| (pair[1] - pair[0] - 2_000).abs() <= 1;
            assert!(times.windows(2).all(is_a_period), "{axis} {times:?}");
        }
    }
}

#[test]
fn rate_control_caps_without_delay() {
    let control = effect("event_rate_control").with("rate_hz", 40_000.0).with("window_us", 1_000.0);
    let scene = |x: usize, _, t: f64| light(-3.0 + 60.0 * t + 0.004 * x as f64);
    let record_with = |effects: &[evpose_sensor::EffectConfig]| {
        let mut run = sensor(effects, size(50, 10), 1);
        record(&mut run, 60, 1_000, scene)
    };
    let (capped, free) = (record_with(&[control]), record_with(&[]));
    let mut windows = BTreeMap::new();
    for e in &capped {
        *windows.entry((e.t.0 - 1).div_euclid(1_000)).or_insert(0) += 1;
    }
    assert!(windows.values().all(|&n| n <= 40) && windows.values().any(|&n| n == 40));
    let mut left = free.iter();
    assert!(capped.len() < free.len() / 2);
    assert!(capped.iter().all(|e| left.any(|f| f == e)), "what comes through is as it was");
}

#[test]
fn latency_moves_all_events_and_drift_moves_late_ones_more() {
    let scene = |x: usize, _, t: f64| light(-3.0 + (20.0 + x as f64) * t);
    let times = |effects: &[evpose_sensor::EffectConfig]| {
        let mut run = sensor(effects, size(5, 1), 1);
        let mut events = record(&mut run, 120, 1_000, scene);
        events.retain(|e| e.t.0 <= 105_000);
        events
    };
    let plain = times(&[]);
    let late = times(&[effect("pixel_latency").with("delay_us", 700.0)]);
    for (a, b) in plain.iter().zip(&late) {
        assert_eq!((a.t.0 + 700, a.x, a.polarity), (b.t.0, b.x, b.polarity));
    }
    let clock = effect("clock_offset_drift").with("offset_us", -250.0).with("drift_ppm", 10_000.0);
    let drifting = times(&[clock]);
    for (a, b) in plain.iter().zip(&drifting) {
        assert_near(b.t.0 as f64, a.t.0 as f64 * 1.01 - 250.0, 2.1);
    }
}

#[test]
fn only_a_frame_grid_puts_events_on_exposures() {
    let scene = |x: usize, _, t: f64| light(-3.0 + (33.0 + x as f64) * t);
    for (effects, is_on_grid) in
        [(vec![], false), (vec![effect("frame_grid").with("pull", 1.0)], true)]
    {
        let mut run = sensor(&effects, size(9, 1), 1);
        let events = record(&mut run, 100, 1_000, scene);
        assert!(events.len() > 100);
        let on_grid = events.iter().filter(|e| e.t.0 % 1_000 == 0).count();
        assert_eq!(on_grid == events.len(), is_on_grid);
    }
}

#[test]
fn stamps_count_the_ticks_of_a_coarse_clock() {
    let clock = effect("timestamp_quantisation").with("period_us", 250.0);
    let mut run = sensor(&[clock], size(1, 1), 1);
    let events = record(&mut run, 100, 1_000, |_, _, t| light(-3.0 + 33.0 * t));
    for (k, e) in events.iter().enumerate() {
        let exact_us = (k + 1) as f64 * C / 33.0 * 1e6;
        assert_eq!(e.t.0 % 250, 0);
        assert!((-1.0..251.0).contains(&(e.t.0 as f64 - exact_us)));
    }
}

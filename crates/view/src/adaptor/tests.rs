#![allow(clippy::unwrap_used, reason = "tests")]

use evpose_core::{CounterRng, Distortion, Micros};
use proptest::prelude::*;

use super::*;

const fn size(width: u16, height: u16) -> SensorSize {
    SensorSize { width, height }
}

/// Every pixel of a band of columns has so many ON events, one after another.
fn edge(sensor: SensorSize, columns: std::ops::Range<u16>, events: usize) -> EventStream {
    let mut stream = EventStream::empty(sensor);
    let mut t = Micros(0);
    for x in columns {
        for _ in 0..events {
            for y in 0..sensor.height {
                stream.push(Event { t, x, y, polarity: Polarity::On }).unwrap();
            }
            t = t + Micros(10);
        }
    }
    stream
}

fn seen(camera: &Calibration, view: &CanonicalView, events: &EventStream) -> EventStream {
    let mut out = EventStream::empty(view.sensor);
    ViewAdaptor::new(camera, view).push(events, &mut out);
    out
}

#[test]
fn a_sensor_that_is_the_view_keeps_its_events() {
    let camera = Calibration::guessed(size(346, 260));
    let adaptor = ViewAdaptor::new(&camera, &CanonicalView::for_bodies(&camera));
    assert!(adaptor.is_identity());
    let events = edge(camera.sensor, 10..12, 2);
    assert_eq!(seen(&camera, adaptor.view(), &events), events);
}

#[test]
fn an_edge_makes_as_many_events_per_pixel_for_every_resolution() {
    let view = CanonicalView::with_vertical_fov(size(96, 72), 45.0);
    for sensor in [size(96, 72), size(192, 144), size(240, 180), size(640, 480)] {
        let camera = Calibration::from_vertical_fov(sensor, 45.0);
        let half = sensor.width / 2;
        let got = seen(&camera, &view, &edge(sensor, 0..half, 3)).len();
        let want = 3 * 48 * 72;
        assert!(got.abs_diff(want) <= want / 50, "{sensor}: {got} for {want}");
    }
}

#[test]
fn a_coarser_sensor_fills_the_pixels_that_each_of_its_own_covers() {
    let view = CanonicalView::with_vertical_fov(size(96, 72), 45.0);
    let camera = Calibration::from_vertical_fov(size(32, 24), 45.0);
    let events = edge(camera.sensor, 4..5, 1);
    assert_eq!(seen(&camera, &view, &events).len(), 9 * events.len());
}

#[test]
fn opposite_events_cancel_and_independent_noise_is_thinned() {
    let camera = Calibration::from_vertical_fov(size(192, 144), 45.0);
    let view = CanonicalView::with_vertical_fov(size(96, 72), 45.0);
    let mut rng = CounterRng::new(1, "noise", 0);
    let mut events = EventStream::empty(camera.sensor);
    for k in 0..200_000 {
        let (x, y) = (rng.below(192) as u16, rng.below(144) as u16);
        let polarity = if rng.chance(0.5) { Polarity::On } else { Polarity::Off };
        events.push(Event { t: Micros(k), x, y, polarity }).unwrap();
    }
    let per_pixel = events.len() as f64 / (192.0 * 144.0);
    let per_cell = seen(&camera, &view, &events).len() as f64 / (96.0 * 72.0);
    // A quarter of the rate in the limit of many events per pixel; at the start less.
    assert!(per_cell < 0.3 * per_pixel, "{per_cell} {per_pixel}");
}

#[test]
fn a_smaller_field_of_view_is_seen_in_the_middle() {
    let view = CanonicalView::with_vertical_fov(size(96, 72), 60.0);
    let camera = Calibration::from_vertical_fov(size(320, 240), 30.0);
    let events = edge(camera.sensor, 0..320, 1);
    let got = seen(&camera, &view, &events);
    let inside = (0.5 * 30f64.to_radians()).tan() / (0.5 * 60f64.to_radians()).tan();
    let (low, high) = (got.x().iter().min().unwrap(), got.x().iter().max().unwrap());
    let half = 48.0 * inside;
    assert!((f64::from(*low) - (48.0 - half)).abs() < 1.5, "{low}");
    assert!((f64::from(*high) - (47.0 + half)).abs() < 1.5, "{high}");
}

proptest! {
    // An adaptor is a table of its sensor: few and small ones.
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn positions_return_to_where_they_were(
        x in 4.0..124.0_f32, y in 4.0..92.0_f32, k1 in -0.2..0.1, fov in 30.0..70.0,
    ) {
        let mut camera = Calibration::from_vertical_fov(size(128, 96), fov);
        camera.camera.distortion = Distortion::from_opencv(&[k1, 0.0, 1e-3, -1e-3]).unwrap();
        let view = CanonicalView::with_vertical_fov(size(96, 72), 45.0);
        let adaptor = ViewAdaptor::new(&camera, &view);
        if let Some(there) = adaptor.view_from_sensor(Vec2::new(x, y)) {
            let back = adaptor.sensor_from_view(there);
            prop_assert!(back.distance(Vec2::new(x, y)) < 0.6, "{back}");
        }
    }

    #[test]
    fn there_are_never_more_events_than_pixels_of_the_view_saw(seed in 0..1000_u64) {
        let camera = Calibration::from_vertical_fov(size(64, 48), 45.0);
        let view = CanonicalView::with_vertical_fov(size(24, 18), 45.0);
        let mut rng = CounterRng::new(seed, "events", 0);
        let mut events = EventStream::empty(camera.sensor);
        for k in 0..500 {
            let (x, y) = (rng.below(64) as u16, rng.below(48) as u16);
            let polarity = if rng.chance(0.7) { Polarity::On } else { Polarity::Off };
            events.push(Event { t: Micros(k), x, y, polarity }).unwrap();
        }
        let out = seen(&camera, &view, &events);
        prop_assert!(out.len() <= events.len());
        prop_assert!(out.t().is_sorted());
    }
}

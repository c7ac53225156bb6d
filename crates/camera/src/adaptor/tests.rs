use evpose_core::{CounterRng, Distortion, Micros, TimeWindow};
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

/// Events at any pixels, half of them ON.
fn random_events(sensor: SensorSize, count: i64, seed: u64) -> EventStream {
    let mut rng = CounterRng::new(seed, "events", 0);
    let mut below = |side: u16| rng.below(side.into()) as u16;
    let event = |k| {
        let (x, y, polarity) = (below(sensor.width), below(sensor.height), below(2) > 0);
        Event { t: Micros(1_000 * k), x, y, polarity: Polarity::from_on(polarity) }
    };
    EventStream::from_events(sensor, (0..count).map(event)).unwrap()
}

/// The same with polarities that `of` makes of true ones.
fn with_polarities(events: &EventStream, mut of: impl FnMut(Polarity) -> Polarity) -> EventStream {
    let other = |event: Event| Event { polarity: of(event.polarity), ..event };
    EventStream::from_events(events.sensor(), events.iter().map(other)).unwrap()
}

/// Bars of both polarities in turn, which pass a sensor at 2000 pixels a second.
fn bars(sensor: SensorSize, steps: i64) -> EventStream {
    let column = |step: i64| {
        let x = (step % i64::from(sensor.width)) as u16;
        let polarity = Polarity::from_on(step / 40 % 2 == 0);
        (0..sensor.height).map(move |y| Event { t: Micros(500 * step), x, y, polarity })
    };
    EventStream::from_events(sensor, (0..steps).flat_map(column)).unwrap()
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
        events.push(Event { t: Micros(2 * k), x, y, polarity }).unwrap();
    }
    let per_pixel = events.len() as f64 / (192.0 * 144.0);
    let per_cell = seen(&camera, &view, &events).len() as f64 / (96.0 * 72.0);
    // Noise that is added up does not come back to where it was for long: half of the rate.
    assert!(per_cell < 0.5 * per_pixel, "{per_cell} {per_pixel}");
}

#[test]
fn edges_stay_where_polarities_are_lost() {
    let camera = Calibration::from_vertical_fov(size(192, 144), 45.0);
    let view = CanonicalView::with_vertical_fov(size(48, 36), 45.0);
    let events = bars(camera.sensor, 8_000);
    let pooled = |events: &EventStream| {
        let mut adaptor = ViewAdaptor::new(&camera, &view);
        let mut out = EventStream::empty(view.sensor);
        // However the recording is cut.
        let pieces = (0..40)
            .map(|k| TimeWindow { start: Micros(100_000 * k), end: Micros(100_000 * (k + 1)) });
        let counts = pieces.map(|piece| {
            adaptor.push(&events.slice(piece), &mut out);
            out.len()
        });
        (counts.sum::<usize>() as f64, adaptor.has_lost_polarities())
    };
    let (normal, is_lost) = pooled(&events);
    assert!(!is_lost);
    let mut rng = CounterRng::new(5, "polarities", 0);
    for share_on in [1.0, 0.0, 0.5, 0.7] {
        let drawn = with_polarities(&events, |_| Polarity::from_on(rng.chance(share_on)));
        let (got, is_lost) = pooled(&drawn);
        // The first ten thousand pairs still cancel.
        assert!(is_lost && (got / normal - 1.0).abs() < 0.02, "{share_on}: {got} for {normal}");
    }
}

#[test]
fn few_events_of_a_large_sensor_stay_where_polarities_are_lost() {
    let camera = Calibration::from_vertical_fov(size(1280, 90), 45.0);
    let view = CanonicalView::with_vertical_fov(size(320, 22), 45.0);
    let mut rng = CounterRng::new(7, "polarities", 0);
    // An edge to the left at 100 pixels a second, and events anywhere in a broad bar, 7 Hz a pixel.
    let edge = |step: i64, y: i64| (10_000 * step, 1_279 - step % 1_280, y);
    let edge: Vec<_> = (0..800).flat_map(|step| (0..90).map(move |y| edge(step, y))).collect();
    let bar = |k: i64, x: usize, y: usize| (40 * k, k / 2_000 + x as i64, y as i64);
    let bar = (0..600_000).map(|k| bar(k, rng.below(40), rng.below(90))).collect();
    for (name, places) in [("edge", edge), ("bar", bar)] {
        let at = |t, x, y, polarity| Event { t: Micros(t), x, y, polarity };
        let draw = |(t, x, y)| at(t, x as u16, y as u16, Polarity::from_on(rng.chance(0.5)));
        let events = EventStream::from_events(camera.sensor, places.into_iter().map(draw)).unwrap();
        let mut adaptor = ViewAdaptor::new(&camera, &view);
        let mut out = EventStream::empty(view.sensor);
        let window = |start, end| TimeWindow { start: Micros(start), end: Micros(end) };
        adaptor.push(&events.slice(window(0, 4_000_000)), &mut out);
        assert!(adaptor.has_lost_polarities(), "{name}");
        let later = events.slice(window(4_000_000, i64::MAX));
        adaptor.push(&later, &mut out);
        // One of the sixteen that cover a pixel of the view.
        let share = out.len() as f64 / later.len() as f64;
        assert!((0.055..0.065).contains(&share), "{name}: {share}");
    }
}

#[test]
fn noise_of_a_sensor_alone_does_not_speak_against_its_polarities() {
    let camera = Calibration::from_vertical_fov(size(192, 144), 45.0);
    let view = CanonicalView::with_vertical_fov(size(48, 36), 45.0);
    let mut adaptor = ViewAdaptor::new(&camera, &view);
    // 18 Hz a pixel, for two seconds.
    let noise = random_events(camera.sensor, 1_000_000, 3);
    let noise = noise.iter().map(|event| Event { t: Micros(event.t.0 / 500), ..event });
    let noise = EventStream::from_events(camera.sensor, noise).unwrap();
    adaptor.push(&noise, &mut EventStream::empty(view.sensor));
    assert!(!adaptor.has_lost_polarities());
}

#[test]
fn pixels_of_the_sensor_divide_those_of_the_view_among_them() {
    let view = CanonicalView::with_vertical_fov(size(24, 18), 45.0);
    for sensor in [size(24, 18), size(64, 48), size(50, 40), size(12, 9)] {
        let adaptor = ViewAdaptor::new(&Calibration::from_vertical_fov(sensor, 45.0), &view);
        let mut sums = vec![0.0; view.sensor.pixels()];
        adaptor.covered.iter().for_each(|(cell, share)| sums[*cell as usize] += share);
        // What is dropped of a share is rounding; a sensor of another shape shows less of a row.
        let columns = if sensor == size(50, 40) { 1..23 } else { 0..24 };
        for (cell, sum) in
            sums.iter().enumerate().filter(|(cell, _)| columns.contains(&(cell % 24)))
        {
            assert!((sum - 1.0).abs() < 4e-3, "{sensor}: {sum} of {cell}");
        }
        assert_eq!(adaptor.starts.len(), sensor.pixels() + 1);
        assert_eq!(adaptor.is_identity(), sensor == view.sensor);
        assert_eq!((adaptor.sensor(), adaptor.calibration().sensor), (sensor, sensor));
    }
}

#[test]
fn a_position_goes_where_its_direction_does_and_back() {
    // Half the field of view, twice the resolution: four times the focal length about.
    let camera = Calibration::from_vertical_fov(size(192, 144), 30.0);
    let view = CanonicalView::with_vertical_fov(size(96, 72), 60.0);
    let adaptor = ViewAdaptor::new(&camera, &view);
    let zoom = 2.0 * (30f32.to_radians().tan() / 15f32.to_radians().tan());
    for offset in [Vec2::ZERO, Vec2::new(30.0, -20.0), Vec2::new(-96.0, 72.0)] {
        let sensor_px = Vec2::new(96.0, 72.0) + offset;
        let view_px = Vec2::new(48.0, 36.0) + offset / zoom;
        let there = adaptor.view_from_sensor(sensor_px).unwrap();
        assert!(there.distance(view_px) < 1e-3, "{there} {view_px}");
        assert!(adaptor.sensor_from_view(view_px).distance(sensor_px) < 1e-3);
    }
    let mut barrel = camera;
    barrel.camera.distortion = Distortion::from_opencv(&[-5.0, 0.0, 0.0, 0.0]).unwrap();
    let adaptor = ViewAdaptor::new(&barrel, &view);
    assert!(adaptor.view_from_sensor(Vec2::new(96.0, 72.0)).is_some());
    assert_eq!(adaptor.view_from_sensor(Vec2::ZERO), None, "beyond what the lens shows");
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

    /// The share of an event is a quarter: three of one sign make one, then four each, and opposite ones cancel.
    #[test]
    fn pooled_by_two_a_pixel_counts_to_four(seed in 0..1000_u64) {
        let camera = Calibration::from_vertical_fov(size(16, 12), 45.0);
        let view = CanonicalView::with_vertical_fov(size(8, 6), 45.0);
        let events = random_events(camera.sensor, 3_000, seed);
        let mut quarters = [0i32; 48];
        let expected = events.iter().filter_map(|event| {
            let (x, y) = (event.x / 2, event.y / 2);
            let quarter = &mut quarters[usize::from(y * 8 + x)];
            let sign = if event.polarity.is_on() { 1 } else { -1 };
            *quarter += sign;
            (*quarter == 3 * sign).then(|| {
                *quarter -= 4 * sign;
                Event { x, y, ..event }
            })
        });
        prop_assert_eq!(&seen(&camera, &view, &events).iter().collect::<Vec<_>>(), &expected.collect::<Vec<_>>());
    }

    #[test]
    fn exchanged_polarities_stay_exchanged_and_a_reset_adaptor_is_a_new_one(seed in 0..1000_u64) {
        let camera = Calibration::from_vertical_fov(size(64, 48), 45.0);
        let view = CanonicalView::with_vertical_fov(size(24, 18), 45.0);
        let events = random_events(camera.sensor, 8_000, seed);
        let exchanged = |events: &EventStream| with_polarities(events, Polarity::flipped);
        let got = seen(&camera, &view, &events);
        let off = got.polarity().iter().filter(|polarity| !polarity.is_on()).count();
        prop_assert!(off > 0 && off < got.len());
        prop_assert_eq!(&seen(&camera, &view, &exchanged(&events)), &exchanged(&got));
        let mut adaptor = ViewAdaptor::new(&camera, &view);
        let mut out = EventStream::empty(view.sensor);
        adaptor.push(&events, &mut out);
        adaptor.reset();
        adaptor.push(&events, &mut out);
        prop_assert_eq!(&out, &got);
    }

    #[test]
    fn there_are_never_more_events_than_pixels_of_the_view_saw(seed in 0..1000_u64) {
        let camera = Calibration::from_vertical_fov(size(64, 48), 45.0);
        let view = CanonicalView::with_vertical_fov(size(24, 18), 45.0);
        let events = random_events(camera.sensor, 500, seed);
        let out = seen(&camera, &view, &events);
        prop_assert!(out.len() <= events.len());
        prop_assert!(out.t().is_sorted());
    }
}

//! Every statistic and every rule of the evaluation against what it is by hand.

use super::*;
use crate::evaluation::Spread;

/// A recording of a sensor by times in microseconds, columns, rows and polarities.
fn recording(sensor: SensorSize, events: &[(i64, u16, u16, bool)]) -> EventStream {
    let mut events = events.to_vec();
    events.sort_by_key(|event| event.0);
    let event = |(t, x, y, on)| Event { t: Micros(t), x, y, polarity: Polarity::from_on(on) };
    EventStream::from_events(sensor, events.into_iter().map(event)).unwrap()
}

/// Asserts that a distance is none between recordings of one event each where `class` says that
/// they are of one kind, and the largest relative difference, 2, where they are not.
fn distinguishes<T: Copy + std::fmt::Debug, K: PartialEq>(
    all: &[T],
    distance: impl Fn(&EventStream, &EventStream) -> f64,
    one_event: impl Fn(T) -> EventStream,
    class: impl Fn(T) -> K,
) {
    let recordings: Vec<EventStream> = all.iter().map(|at| one_event(*at)).collect();
    for (a, first) in all.iter().zip(&recordings) {
        for (b, second) in all.iter().zip(&recordings) {
            let wanted = if class(*a) == class(*b) { 0.0 } else { 2.0 };
            assert_eq!(distance(first, second), wanted, "{a:?} and {b:?}");
        }
    }
}

#[test]
fn every_pixel_polarity_and_block_is_one_of_its_own() {
    let sensor = SensorSize { width: 19, height: 11 };
    let pixels: Vec<(u16, u16)> =
        (0..sensor.height).flat_map(|y| (0..sensor.width).map(move |x| (x, y))).collect();
    for on in [true, false] {
        let one_event = |(x, y)| recording(sensor, &[(5, x, y, on)]);
        distinguishes(&pixels, |a, b| counts::per_pixel(a, b, on), one_event, |pixel| pixel);
        distinguishes(&pixels, |a, b| counts::per_pixel(a, b, !on), one_event, |_| ());
        distinguishes(&pixels, |a, b| counts::total(a, b, on), one_event, |_| ());
        distinguishes(&pixels, image_blocks::distance, one_event, |(x, y)| (x / 8, y / 8));
    }
    // A pixel has no interval to the event of another one, wherever the two are.
    let gap = recording(sensor, &[(0, 6, 4, true), (50, 6, 4, true)]);
    for (x, y) in pixels {
        let other = recording(sensor, &[(0, 6, 4, true), (50, x, y, true)]);
        let wanted = if (x, y) == (6, 4) { 0.0 } else { 1.0 };
        assert_eq!(intervals::distance(&gap, &other), wanted, "({x}, {y})");
    }
}

#[test]
fn steps_of_the_rate_are_five_milliseconds_long_before_and_after_zero() {
    let times = [-10_001, -10_000, -5_001, -5_000, -1, 0, 1, 4_999, 5_000, 9_999, 10_000, 31_000];
    let one_event = |t| recording(SIZE, &[(t, 3, 3, true)]);
    distinguishes(&times, rate::distance, one_event, |t| t.div_euclid(5_000));
}

#[test]
fn planes_are_those_of_the_time_of_an_event_and_classes_hold_as_many_pixels_each() {
    // One of 61 values is in the sample: one of each plane here. Plane `k` is `k` everywhere, so
    // that two planes are one of eight classes.
    let sensor = SensorSize { width: 61, height: 1 };
    let planes: Vec<_> = (0..16u8).map(|k| Plane::filled(61, 1, f32::from(k))).collect();
    let frames = Frames { planes: &planes, fps: 100.0 };
    let classes = brightness::Classes::new(frames, sensor).unwrap();
    let times: Vec<i64> = (-1..20).flat_map(|k| [10_000 * k + 1, 10_000 * k + 9_999]).collect();
    let one_event = |t| recording(sensor, &[(t, 60, 0, true)]);
    let plane = |t: i64| t.div_euclid(10_000).clamp(0, 15);
    distinguishes(&times, |a, b| classes.distance(a, b), one_event, |t| plane(t) / 2);

    // Row `y` is `y`: one of the sample each.
    let sensor = SensorSize { width: 61, height: 8 };
    let rows = (0..8u8).flat_map(|y| [f32::from(y); 61]).collect();
    let planes = [Plane::from_vec(61, 8, rows).unwrap()];
    let classes = brightness::Classes::new(Frames { planes: &planes, fps: 1.0 }, sensor).unwrap();
    let pixels: Vec<(u16, u16)> = (0..8).flat_map(|y| [(0, y), (y, y), (60, y)]).collect();
    let one_event = |(x, y)| recording(sensor, &[(0, x, y, true)]);
    distinguishes(&pixels, |a, b| classes.distance(a, b), one_event, |(_, y)| y);

    let none = brightness::Classes::new(Frames { planes: &[], fps: 1.0 }, sensor).unwrap();
    assert_eq!(none.distance(&one_event((0, 0)), &one_event((0, 7))), 0.0);
}

#[test]
fn intervals_are_distinguished_by_fifths_of_a_decade() {
    // Powers of 10^0.2: 1, 1.58, 2.51, 3.98, 6.31.
    let fifths = [[10, 15], [16, 25], [26, 39], [40, 63], [64, 99]];
    let decades = [1, 10, 100, 1_000, 10_000, 100_000];
    let mut bins: Vec<Vec<i64>> = vec![vec![0], vec![1], vec![2], vec![3], vec![4, 6], vec![7, 9]];
    bins.extend(
        decades.iter().flat_map(|scale| fifths.map(|ends| ends.map(|us| us * scale).to_vec())),
    );
    // From 10 s on all are alike.
    bins.push(vec![10_000_000, 90_000_000]);
    let recorded = |us: &i64| recording(SIZE, &[(7, 2, 1, true), (7 + us, 2, 1, false)]);
    for (i, a) in bins.iter().enumerate() {
        for (j, b) in bins.iter().enumerate() {
            for (a, b) in a.iter().flat_map(|a| b.iter().map(move |b| (a, b))) {
                let wanted = if i == j { 0.0 } else { 1.0 };
                let distance = intervals::distance(&recorded(a), &recorded(b));
                assert_eq!(distance, wanted, "{a} and {b} us");
            }
        }
    }
    // Two thirds and one third of either: a third has to move.
    let thirds = |steps: [i64; 3]| {
        let times = steps.iter().scan(0, |t, step| {
            *t += step;
            Some((*t, 0, 0, true))
        });
        recording(SIZE, &std::iter::once((0, 0, 0, true)).chain(times).collect::<Vec<_>>())
    };
    let distance = intervals::distance(&thirds([20, 20, 500]), &thirds([20, 500, 500]));
    assert!((distance - 1.0 / 3.0).abs() < 1e-12);
}

#[test]
fn every_delay_up_to_sixty_milliseconds_is_found_and_none_beyond() {
    let early = run(Effects::default(), 1);
    for delay_us in [200, -400, 5_000, -31_400, 59_800, 60_000, -60_000, 60_200, -90_000] {
        let late = early.iter().map(|event| Event { t: event.t + Micros(delay_us), ..event });
        let late = EventStream::from_events(SIZE, late).unwrap();
        let wanted = (delay_us.abs() as f64 * 1e-3).min(60.0);
        assert!((rate::lag_ms(&early, &late) - wanted).abs() < 1e-9, "{delay_us}");
    }
    // Of equal overlaps the shortest lag counts: here all are zero.
    let once = recording(SIZE, &[(70, 0, 0, true)]);
    assert_eq!(rate::lag_ms(&once, &once), 0.0);
}

#[test]
fn rates_are_smoothed_over_two_milliseconds_to_either_side() {
    for (length, at) in [(50, 25), (50, 3), (50, 49), (15, 7), (1, 0)] {
        let mut counts = vec![0.0; length];
        counts[at] = 1.0;
        for (k, value) in rate::smoothed(&counts).into_iter().enumerate() {
            let window = (k + 11).min(length) - k.saturating_sub(10);
            let inside = if k.abs_diff(at) <= 10 { 1.0 / window as f64 } else { 0.0 };
            assert!((value - (inside - 1.0 / length as f64)).abs() < 1e-12, "{k} of {length}");
        }
    }
}

#[test]
fn spreads_have_the_textbook_mean_and_deviation() {
    let spread = |distances: &[f64]| Spread::from_distances(distances);
    assert_eq!(spread(&[1.0, 2.0, 3.0]), Spread { mean: 2.0, sd: 1.0, n: 3 });
    assert_eq!(spread(&[3.0, 7.0]), Spread { mean: 5.0, sd: 8f64.sqrt(), n: 2 });
    assert_eq!(spread(&[4.0]), Spread { mean: 4.0, sd: 0.0, n: 1 });
}

/// The answer where the distance of two recordings is the difference of their numbers of events.
fn answer(measured: usize, before: &[usize], after: &[usize]) -> (Option<bool>, bool) {
    let of = |n: usize| recording(SIZE, &vec![(0, 0, 0, true); n]);
    let all = |runs: &[usize]| runs.iter().map(|n| of(*n)).collect::<Vec<_>>();
    let distance: Distance<'_> = Box::new(|a, b| a.len().abs_diff(b.len()) as f64);
    let row = Row::new("events", "", &distance, &of(measured), &all(before), &all(after));
    (row.came_closer, row.is_closed)
}

#[test]
fn chance_reaches_three_deviations_of_the_distances_between_runs() {
    // Distances between the runs: 2, 6 and 4, mean 4, deviation 2: chance reaches 10.
    let runs = [0, 2, 6];
    // Mean distances to the recording: 9.33 and 10.33, after a change from far away.
    assert_eq!(answer(12, &[200, 200], &runs), (Some(true), true));
    assert_eq!(answer(13, &[200, 200], &runs), (Some(true), false));
    // The same before: what was chance and stayed so is no answer.
    assert_eq!(answer(12, &runs, &runs), (None, true));
    assert_eq!(answer(13, &runs, &runs), (Some(false), false));
    assert_eq!(answer(12, &runs, &[200, 200]), (Some(false), false));
    // A distance that is that between runs exactly.
    assert_eq!(answer(5, &[0, 10], &[0, 10]), (None, true));
    assert!(!answer(14, &[0, 4], &[0, 4]).1);
}

#[test]
fn closer_is_by_more_than_two_standard_errors() {
    // Before 10 and 14, after 4 and 8 or 5 and 9: standard error of the difference 2.83.
    assert_eq!(answer(100, &[90, 86], &[96, 92]), (Some(true), false));
    assert_eq!(answer(100, &[90, 86], &[95, 91]), (Some(false), false));
    // Beyond chance before by a little and within it after: no evidence either way.
    assert_eq!(answer(20, &[0, 3], &[1, 30]), (None, true));
}

#[test]
fn rows_are_the_statistics_in_their_order_and_brightness_is_one_where_there_are_frames() {
    let events = run(Effects::default(), 1);
    let (two, planes) = ([events.clone(), events.clone()], planes());
    let names = |frames| -> Vec<(&str, &str)> {
        let rows = evaluate(&events, &two, &two, frames).unwrap().rows;
        rows.iter().map(|row| (row.name, row.unit)).collect()
    };
    let mut wanted = vec![
        ("ON events", ""),
        ("OFF events", ""),
        ("ON events per pixel", ""),
        ("OFF events per pixel", ""),
        ("intervals", ""),
        ("lag of the rate", "ms"),
        ("rate", ""),
        ("events by place", ""),
    ];
    assert_eq!(names(None), wanted);
    wanted.insert(7, ("events by brightness", ""));
    assert_eq!(names(Some(Frames { planes: &planes, fps: 10.0 })), wanted);
    assert_eq!(relative_difference(&[0.0], &[0.0]), 0.0);
}

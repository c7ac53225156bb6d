use evpose_core::{CounterRng, Event, EventStream, Micros, Plane, Polarity, SensorSize};

mod closed_forms;

use super::*;

const SIZE: SensorSize = SensorSize { width: 24, height: 16 };

#[derive(Clone, Copy, Default)]
struct Effects {
    delay_us: i64,
    /// ON noise of the dark left half, events a pixel.
    dark_noise: f32,
    /// Events closer than this to the one before in the pixel are lost.
    dead_us: i64,
}

/// An edge that sweeps over the image twice a second, with three events per pixel and noise, and
/// half as many OFF as ON events.
fn run(effects: Effects, seed: u64) -> EventStream {
    let mut events = Vec::new();
    for pixel in 0..SIZE.pixels() {
        let (x, y) = ((pixel % 24) as u16, (pixel / 24) as u16);
        let mut rng = CounterRng::new(seed, "run", pixel as u64);
        for sweep in 0..2 {
            let t = sweep * 500_000 + 15_000 * i64::from(x) + 50_000;
            for k in 0..3 {
                let t = Micros(t + k * 700 + (1_500.0 * rng.normal()) as i64 + effects.delay_us);
                events.push(Event { t, x, y, polarity: Polarity::from_on(rng.chance(0.67)) });
            }
        }
        if x < 12 && rng.chance(effects.dark_noise) {
            let t = Micros(rng.below(1_000_000) as i64);
            events.push(Event { t, x, y, polarity: Polarity::On });
        }
    }
    events.sort_by_key(|event| event.t);
    let mut last = vec![i64::MIN / 2; SIZE.pixels()];
    events.retain(|event| {
        let pixel = usize::from(event.y) * 24 + usize::from(event.x);
        let passes = event.t.0 - last[pixel] >= effects.dead_us;
        if passes {
            last[pixel] = event.t.0;
        }
        passes
    });
    EventStream::from_events(SIZE, events).unwrap()
}

fn runs(effects: Effects, first: u64) -> Vec<EventStream> {
    (first..first + 6).map(|seed| run(effects, seed)).collect()
}

/// Dark on the left.
fn planes() -> Vec<Plane<f32>> {
    let mut plane = Plane::for_sensor(SIZE, 0.0);
    for (i, light) in plane.data_mut().iter_mut().enumerate() {
        *light = (1 + i % 24) as f32 / 24.0;
    }
    vec![plane; 10]
}

fn evaluated(measured: Effects, before: Effects, after: Effects) -> Evaluation {
    let planes = planes();
    let frames = Some(Frames { planes: &planes, fps: 10.0 });
    evaluate(&run(measured, 1_000), &runs(before, 0), &runs(after, 100), frames).unwrap()
}

fn row<'a>(evaluation: &'a Evaluation, name: &str) -> &'a Row {
    evaluation.rows.iter().find(|row| row.name == name).unwrap()
}

#[test]
fn a_run_of_the_simulator_itself_is_as_close_as_chance() {
    for effects in [Effects::default(), Effects { dark_noise: 0.5, ..Effects::default() }] {
        let evaluation = evaluated(effects, effects, effects);
        assert_eq!(evaluation.verdict, EvaluationVerdict::Chance, "{evaluation}");
    }
}

#[test]
fn chance_is_hardly_ever_taken_for_a_difference() {
    let none = Effects::default();
    let (before, after) = (runs(none, 0), runs(none, 100));
    let of = |seed| evaluate(&run(none, seed), &before, &after, None).unwrap().rows;
    let rows: Vec<Row> = (1_000..1_015).flat_map(of).collect();
    let significant = rows.iter().filter(|row| row.came_closer.is_some()).count();
    assert!(20 * significant <= rows.len(), "{significant} of {}", rows.len());
}

#[test]
fn the_same_events_are_at_no_distance() {
    let events = run(Effects::default(), 1);
    let same = [events.clone(), events.clone()];
    let evaluation = evaluate(&events, &same, &same, None).unwrap();
    assert_eq!(evaluation.verdict, EvaluationVerdict::Chance);
    assert!(evaluation.rows.iter().all(|row| row.before.mean == 0.0 && row.after.mean == 0.0));
}

#[test]
fn an_effect_that_is_added_comes_closer_where_it_shows() {
    let none = Effects::default();
    let delay = Effects { delay_us: 4_000, ..none };
    let noise = Effects { dark_noise: 1.0, ..none };
    let dead = Effects { dead_us: 900, ..none };
    for (effects, shown) in [
        (delay, &["lag of the rate", "rate"][..]),
        (noise, &["ON events", "events by brightness", "events by place"]),
        (dead, &["ON events", "OFF events", "intervals"]),
    ] {
        let evaluation = evaluated(effects, none, effects);
        assert_eq!(evaluation.verdict, EvaluationVerdict::Closer, "{evaluation}");
        for name in shown {
            let row = row(&evaluation, name);
            assert!(row.came_closer == Some(true) && row.is_closed, "{evaluation}");
        }
        // And the other way round.
        assert_eq!(evaluated(none, effects, none).verdict, EvaluationVerdict::Closer);
    }
}

#[test]
fn an_effect_that_is_not_there_takes_the_simulator_away() {
    let none = Effects::default();
    let noise = Effects { dark_noise: 1.0, ..none };
    let evaluation = evaluated(none, none, noise);
    assert_eq!(evaluation.verdict, EvaluationVerdict::NotCloser, "{evaluation}");
    assert_eq!(row(&evaluation, "ON events").came_closer, Some(false));
    assert_eq!(row(&evaluation, "lag of the rate").came_closer, None);
}

#[test]
fn one_of_two_effects_is_a_part() {
    let none = Effects::default();
    let both = Effects { delay_us: 4_000, dead_us: 900, ..none };
    let evaluation = evaluated(both, none, Effects { dead_us: 900, ..none });
    assert_eq!(evaluation.verdict, EvaluationVerdict::Partly, "{evaluation}");
    assert_eq!(row(&evaluation, "intervals").came_closer, Some(true));
    assert_eq!(row(&evaluation, "lag of the rate").came_closer, Some(false));
}

#[test]
fn distances_have_their_closed_form() {
    let events = |steps: &[(i64, u16, bool)]| {
        let event = |&(t, x, on): &(i64, u16, bool)| Event {
            t: Micros(t),
            x,
            y: 0,
            polarity: Polarity::from_on(on),
        };
        EventStream::from_events(SIZE, steps.iter().map(event)).unwrap()
    };
    let a = events(&[(0, 0, true), (100, 0, true), (10_000, 0, true), (10_100, 9, false)]);
    let b = events(&[(0, 0, true), (100, 9, true)]);
    // 3 against 2 ON events.
    assert!((counts::total(&a, &b, true) - 1.0 / 2.5).abs() < 1e-12);
    assert!((counts::total(&a, &b, false) - 2.0).abs() < 1e-12);
    // Pixel 0: 3 and 1; pixel 9: 0 and 1.
    assert!((counts::per_pixel(&a, &b, true) - 3.0 / 2.5).abs() < 1e-12);
    // Blocks 0 and 1: 3, 1 and 1, 1.
    assert!((image_blocks::distance(&a, &b) - 2.0 / 3.0).abs() < 1e-12);
    // Steps of 5 ms: 2, 0, 2 and 2, 0, 0.
    assert!((rate::distance(&a, &b) - 2.0 / 3.0).abs() < 1e-12);
    // Intervals of 100 us and 9.9 ms against none.
    assert!((intervals::distance(&a, &b) - 1.0).abs() < 1e-12);
    let shares = events(&[(0, 0, true), (100, 0, true), (200, 0, true)]);
    assert!((intervals::distance(&a, &shares) - 0.5).abs() < 1e-12);
}

#[test]
fn a_delay_is_measured_to_a_fifth_of_a_millisecond() {
    let early = run(Effects::default(), 1);
    for delay_us in [0, 3_000, -7_400] {
        let late = run(Effects { delay_us, ..Effects::default() }, 1);
        let expected = delay_us.abs() as f64 * 1e-3;
        assert!((rate::lag_ms(&early, &late) - expected).abs() < 0.2 + 1e-9);
    }
}

#[test]
fn invalid_inputs_are_refused() {
    let events = run(Effects::default(), 1);
    let two = [events.clone(), events.clone()];
    let refused = evaluate(&events, &two, &two[..1], None).unwrap_err();
    assert_eq!(refused.to_string(), "1 runs of the simulator after: at least two are needed");
    let other = EventStream::empty(SensorSize { width: 2, height: 2 });
    assert!(matches!(evaluate(&other, &two, &two, None), Err(EvalError::Sensor(..))));
    assert_eq!(evaluate(&EventStream::empty(SIZE), &two, &two, None), Err(EvalError::Empty));
    let planes = [Plane::filled(2, 2, 1.0f32)];
    let frames = Some(Frames { planes: &planes, fps: 1.0 });
    assert!(matches!(evaluate(&events, &two, &two, frames), Err(EvalError::Frames(2, 2, _))));
}

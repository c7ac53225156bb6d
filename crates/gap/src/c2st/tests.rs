use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity, SensorSize, TimeWindow};

use super::two_sample;

const SIZE: SensorSize = SensorSize { width: 128, height: 96 };
const LENGTH_US: usize = 400_000;

fn window() -> TimeWindow {
    TimeWindow { start: Micros(0), end: Micros(LENGTH_US as i64) }
}

/// Events of chance, crowded towards the left; one polarity follows the other with `alternation`.
fn stream(seed: u64, count: usize, alternation: f32) -> EventStream {
    let mut rng = CounterRng::new(seed, "stream", 0);
    let mut events: Vec<Event> = Vec::with_capacity(count);
    while events.len() < count {
        let x = rng.below(128) * (1 + rng.below(128)) / 128;
        let (y, t) = (rng.below(96), rng.below(LENGTH_US - 2_000));
        let is_on = rng.chance(0.5);
        let at = |t: usize, is_on| Event {
            t: Micros(t as i64),
            x: x as u16,
            y: y as u16,
            polarity: Polarity::from_on(is_on),
        };
        events.push(at(t, is_on));
        let changes = rng.chance(alternation);
        events.push(at(t + 200 + rng.below(1_500), is_on != changes));
    }
    events.sort_by_key(|event| event.t);
    EventStream::from_events(SIZE, events).unwrap()
}

#[test]
fn streams_of_one_kind_are_not_separated() {
    let simulated = [stream(100, 20_000, 0.3), stream(101, 20_000, 0.3)];
    let small = (0..8)
        .map(|seed| two_sample(&stream(seed, 20_000, 0.3), &simulated, window(), seed))
        .inspect(|found| assert!((found.auc - 0.5).abs() < 0.1, "{found:?}"))
        .filter(|found| found.p < 0.05)
        .count();
    assert!(small <= 2, "{small} of 8");
}

#[test]
fn another_alternation_of_polarities_is_noticed() {
    let simulated = [stream(100, 20_000, 0.3), stream(101, 20_000, 0.3)];
    let found = two_sample(&stream(1, 20_000, 0.6), &simulated, window(), 7);
    assert!(found.auc > 0.8 && found.p < 0.02, "{found:?}");
    assert_eq!(found, two_sample(&stream(1, 20_000, 0.6), &simulated, window(), 7));
}

#[test]
fn too_few_patches_say_nothing() {
    let few = stream(1, 30, 0.3);
    let found = two_sample(&few, &[stream(2, 30, 0.3)], window(), 1);
    assert_eq!((found.auc, found.p), (0.5, 1.0));
    assert_eq!(two_sample(&few, &[], window(), 1), found);
}

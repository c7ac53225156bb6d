//! A small scene for tests of probes: a moving pattern beside one at rest.

use std::sync::OnceLock;

use evpose_core::{
    CounterRng, Event, EventStream, Micros, Plane, Polarity, SensorSize, TimeWindow,
};
use evpose_sensor::{SensorConfig, SensorModel};

use crate::probe::interface::StatisticProbe;
use crate::view::Expected;
use crate::{Classes, LightSequence, ReferenceScene, View};

/// Columns from here on are at rest.
pub(crate) const REST_FROM: u16 = 64;
const SIZE: SensorSize = SensorSize { width: 96, height: 72 };
const FPS: f64 = 1_000.0;
const PLANES: usize = 601;
const PX_PER_S: f32 = 40.0;

fn luminance(x: usize, y: usize, t_s: f32) -> f32 {
    let moved = if x < usize::from(REST_FROM) { PX_PER_S * t_s } else { 0.0 };
    let (x, y) = (x as f32 - moved, y as f32);
    (-1.5 + 0.6 * (0.35 * x + 0.1 * y).sin() + 0.4 * (0.15 * x - 0.3 * y).cos()).exp()
}

fn example() -> &'static (ReferenceScene, EventStream) {
    static EXAMPLE: OnceLock<(ReferenceScene, EventStream)> = OnceLock::new();
    EXAMPLE.get_or_init(|| {
        let (width, height) = (usize::from(SIZE.width), usize::from(SIZE.height));
        let plane = |k: usize| {
            let t_s = (k as f64 / FPS) as f32;
            let pixels = (0..width * height).map(|p| luminance(p % width, p / width, t_s));
            Plane::from_vec(width, height, pixels.collect()).unwrap()
        };
        let scene = LightSequence::new(FPS, (0..PLANES).map(plane).collect()).unwrap();
        let model = SensorModel::from_config(&SensorConfig::default()).unwrap();
        let mut run = model.start(SIZE, 1);
        let mut events = EventStream::empty(SIZE);
        for (k, plane) in scene.planes().iter().enumerate() {
            for event in run.expose(plane, scene.time(k)).unwrap().iter() {
                events.push(event).unwrap();
            }
        }
        let reference_scene = ReferenceScene {
            classes: Classes::from_scene(&scene),
            expected: Expected::from_events(&events),
            scene,
        };
        (reference_scene, events)
    })
}

/// The scene, with the events of an ideal sensor as reference.
pub(crate) fn reference_scene() -> &'static ReferenceScene {
    &example().0
}

/// The events of the ideal sensor, as if measured.
pub(crate) fn events() -> &'static EventStream {
    &example().1
}

/// A constant scene of two steps.
pub(crate) fn tiny(width: u16, height: u16) -> ReferenceScene {
    let size = SensorSize { width, height };
    let scene = LightSequence::new(FPS, vec![Plane::for_sensor(size, 0.5); 3]).unwrap();
    let events = corner_events(width, height);
    ReferenceScene {
        classes: Classes::from_scene(&scene),
        expected: Expected::from_events(&events),
        scene,
    }
}

pub(crate) fn corner_events(width: u16, height: u16) -> EventStream {
    let events = [on(0, 0, 0), on(700, width - 1, height - 1), on(700, 0, 0)];
    EventStream::from_events(SensorSize { width, height }, events).unwrap()
}

pub(crate) fn whole() -> TimeWindow {
    TimeWindow { start: Micros(0), end: Micros(600_001) }
}

/// An ON event.
pub(crate) fn on(t_us: i64, x: u16, y: u16) -> Event {
    Event { t: Micros(t_us), x, y, polarity: Polarity::On }
}

pub(crate) fn stream(events: impl IntoIterator<Item = Event>) -> EventStream {
    let mut events: Vec<Event> = events.into_iter().collect();
    events.sort_by_key(|event| event.t);
    EventStream::from_events(SIZE, events).unwrap()
}

/// The events of the ideal sensor, each changed or dropped.
pub(crate) fn changed(change: impl FnMut(Event) -> Option<Event>) -> EventStream {
    stream(events().iter().filter_map(change))
}

/// Noise events, uniform over pixels and times.
pub(crate) fn noise(count: usize, seed: u64) -> Vec<Event> {
    let mut rng = CounterRng::new(seed, "noise", 0);
    let mut event = || Event {
        t: Micros(rng.below(600_000) as i64),
        x: rng.below(usize::from(SIZE.width)) as u16,
        y: rng.below(usize::from(SIZE.height)) as u16,
        polarity: Polarity::from_on(rng.chance(0.5)),
    };
    (0..count).map(|_| event()).collect()
}

/// One statistic of a probe, before any transform.
pub(crate) fn value(probe: &StatisticProbe, events: &EventStream, name: &str) -> f64 {
    let entries = (probe.entries)();
    let place = entries.iter().position(|entry| entry.name == name);
    let mut values = Vec::new();
    (probe.measure)(&View::new(reference_scene(), events, whole()), &mut values);
    assert_eq!(values.len(), entries.len());
    values[place.unwrap_or_else(|| panic!("no entry `{name}`"))]
}

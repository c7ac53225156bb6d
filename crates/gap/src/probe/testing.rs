//! A small stage on which probes are tested: a pattern that moves beside one at rest.

use std::sync::OnceLock;

use evpose_core::{
    CounterRng, Event, EventStream, Micros, Plane, Polarity, SensorSize, TimeWindow,
};
use evpose_sensor::{SensorConfig, SensorModel};

use crate::probe::Probe;
use crate::view::Expected;
use crate::{Classes, Scene, Stage, View};

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

fn made() -> &'static (Stage, EventStream) {
    static MADE: OnceLock<(Stage, EventStream)> = OnceLock::new();
    MADE.get_or_init(|| {
        let (width, height) = (usize::from(SIZE.width), usize::from(SIZE.height));
        let plane = |k: usize| {
            let t_s = (k as f64 / FPS) as f32;
            let pixels = (0..width * height).map(|p| luminance(p % width, p / width, t_s));
            Plane::from_vec(width, height, pixels.collect()).unwrap()
        };
        let scene = Scene::new(FPS, (0..PLANES).map(plane).collect()).unwrap();
        let model = SensorModel::from_config(&SensorConfig::default()).unwrap();
        let mut run = model.start(SIZE, 1);
        let mut events = EventStream::empty(SIZE);
        for (k, plane) in scene.planes().iter().enumerate() {
            for event in run.expose(plane, scene.time(k)).unwrap().iter() {
                events.push(event).unwrap();
            }
        }
        let stage = Stage { classes: Classes::of(&scene), expected: Expected::of(&events), scene };
        (stage, events)
    })
}

/// The scene and the events of an ideal sensor.
pub(crate) fn stage() -> &'static Stage {
    &made().0
}

/// The events of the ideal sensor, as if measured.
pub(crate) fn events() -> &'static EventStream {
    &made().1
}

/// A stage of two steps in which nothing happens.
pub(crate) fn tiny(width: u16, height: u16) -> Stage {
    let size = SensorSize { width, height };
    let scene = Scene::new(FPS, vec![Plane::for_sensor(size, 0.5); 3]).unwrap();
    let events = corner_events(width, height);
    Stage { classes: Classes::of(&scene), expected: Expected::of(&events), scene }
}

/// Events at either end of a sensor.
pub(crate) fn corner_events(width: u16, height: u16) -> EventStream {
    let at = |t, x, y| Event { t: Micros(t), x, y, polarity: Polarity::On };
    let events = [at(0, 0, 0), at(700, width - 1, height - 1), at(700, 0, 0)];
    EventStream::from_events(SensorSize { width, height }, events).unwrap()
}

/// All of the scene.
pub(crate) fn whole() -> TimeWindow {
    TimeWindow { start: Micros(0), end: Micros(600_001) }
}

/// Events in order of time, whatever order they come in.
pub(crate) fn stream(events: impl IntoIterator<Item = Event>) -> EventStream {
    let mut events: Vec<Event> = events.into_iter().collect();
    events.sort_by_key(|event| event.t);
    EventStream::from_events(SIZE, events).unwrap()
}

/// The events of the ideal sensor, each changed or taken out.
pub(crate) fn changed(change: impl FnMut(Event) -> Option<Event>) -> EventStream {
    stream(events().iter().filter_map(change))
}

/// Events without a cause, anywhere and at any time.
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

/// One number of a probe, before any change of scale.
pub(crate) fn number(probe: &dyn Probe, events: &EventStream, name: &str) -> f64 {
    let entries = probe.entries();
    let place = entries.iter().position(|entry| entry.name == name);
    let mut numbers = Vec::new();
    probe.measure(&View::new(stage(), events, whole()), &mut numbers);
    assert_eq!(numbers.len(), entries.len());
    numbers[place.unwrap_or_else(|| panic!("no entry `{name}`"))]
}

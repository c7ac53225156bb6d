use evpose_core::{
    CounterRng, Event, EventStream, Micros, Plane, Polarity, SensorSize, TimeWindow,
};
use evpose_sensor::{EffectConfig, SensorConfig};

use crate::locate::{Located, locate};
use crate::{LightSequence, ReferenceScene, View};

const SIZE: SensorSize = SensorSize { width: 48, height: 36 };
const PLANES: usize = 501;
const RUNS: u64 = 5;

/// A pattern that moves for 300 ms and then rests.
fn reference_scene() -> ReferenceScene {
    let plane = |k: usize| {
        let moved = 0.06 * k.min(300) as f32;
        let value = |x: usize, y: usize| {
            let (x, y) = (x as f32 - moved, y as f32);
            (-1.5 + 0.8 * (0.35 * x + 0.1 * y).sin() + 0.5 * (0.15 * x - 0.3 * y).cos()).exp()
        };
        let (width, height) = (usize::from(SIZE.width), usize::from(SIZE.height));
        let pixels = (0..width * height).map(|p| value(p % width, p / width));
        Plane::from_vec(width, height, pixels.collect()).unwrap()
    };
    ReferenceScene::new(
        LightSequence::new(1_000.0, (0..PLANES).map(plane).collect()).unwrap(),
        &model(),
    )
    .unwrap()
}

fn model() -> SensorConfig {
    let mut model = SensorConfig::default();
    let noise = EffectConfig::new("uniform_noise").with("on_hz", 3.0).with("off_hz", 3.0);
    model.effects.push(noise);
    model
}

fn window() -> TimeWindow {
    TimeWindow { start: Micros(0), end: Micros(500_001) }
}

fn stream(mut events: Vec<Event>) -> EventStream {
    events.sort_by_key(|event| event.t);
    EventStream::from_events(SIZE, events).unwrap()
}

fn located(reference_scene: &ReferenceScene, measured: &EventStream) -> Located {
    let runs: Vec<EventStream> =
        (0..RUNS).map(|i| reference_scene.simulate(&model(), 100 + i).unwrap()).collect();
    let views: Vec<View<'_>> =
        runs.iter().map(|run| View::new(reference_scene, run, window())).collect();
    locate(&View::new(reference_scene, measured, window()), &views)
}

/// Events of chance over all pixels and times, those that `is_kept`.
fn scattered(
    reference_scene: &ReferenceScene,
    count: usize,
    polarity: Polarity,
    is_kept: impl Fn(&Event, crate::Cell) -> bool,
) -> Vec<Event> {
    let mut rng = CounterRng::new(9, "scattered", 0);
    let mut events = Vec::new();
    while events.len() < count {
        let t = Micros(rng.below(500_000) as i64);
        let pixel = rng.below(SIZE.pixels());
        let (x, y) = (pixel % usize::from(SIZE.width), pixel / usize::from(SIZE.width));
        let event = Event { t, x: x as u16, y: y as u16, polarity };
        if is_kept(&event, reference_scene.classes.cell(pixel, t.as_seconds())) {
            events.push(event);
        }
    }
    events
}

#[test]
fn a_run_of_the_model_differs_nowhere() {
    let reference_scene = reference_scene();
    for seed in 0..8 {
        let found = located(&reference_scene, &reference_scene.simulate(&model(), seed).unwrap());
        assert!(found.scan.regions.is_empty(), "seed {seed}: {:?}", found.scan);
        assert!(found.scan.sentence.starts_with("No part"));
        assert!(found.attribution.shares().is_empty(), "seed {seed}: {:?}", found.attribution);
        let odd = found.maps.pixels.len();
        assert!(odd <= 3, "seed {seed}: {odd} odd pixels");
    }
}

#[test]
fn events_behind_edges_are_found_and_said() {
    let reference_scene = reference_scene();
    let mut events: Vec<Event> = reference_scene.simulate(&model(), 1).unwrap().iter().collect();
    let behind = |_: &Event, cell: crate::Cell| matches!(cell.age(), 3 | 4) && !cell.rises();
    events.extend(scattered(&reference_scene, 700, Polarity::Off, behind));
    let found = located(&reference_scene, &stream(events));
    let region = &found.scan.regions[0];
    let said = &region.sentence;
    assert!(said.starts_with("Excess x"), "{said}");
    assert!(said.contains("of OFF events 10-50 ms after light fell, everywhere"), "{said}");
    assert!(region.lo90 < region.ratio && region.ratio < region.hi90, "{region:?}");
    assert!((region.measured - region.expected - 700.0).abs() < 60.0, "{region:?}");
    let first = &found.attribution.explained[0];
    assert_eq!(first.axis, "age", "{:?}", found.attribution);
    let total: f64 = found.attribution.shares().values().sum();
    assert!((total - 1.0).abs() < 1e-9);
}

#[test]
fn events_that_are_lost_in_one_corner_are_found_there() {
    let reference_scene = reference_scene();
    let mut rng = CounterRng::new(1, "lost", 0);
    let all = reference_scene.simulate(&model(), 1).unwrap();
    let is_there = |event: &Event| event.x >= 24 && event.y < 18;
    let kept = all.iter().filter(|event| !is_there(event) || rng.chance(0.5)).collect();
    let found = located(&reference_scene, &stream(kept));
    let region = &found.scan.regions[0];
    assert!(region.sentence.starts_with("Deficit x"), "{}", region.sentence);
    assert!(region.sentence.contains("in columns 24-47 of rows 0-17"), "{}", region.sentence);
    assert!(region.lo90 < 0.5 && 0.5 < region.hi90, "{region:?}");
    assert_eq!(found.attribution.explained[0].axis, "place", "{:?}", found.attribution);
    assert!(found.maps.image.residuals.significant() > 20);
}

#[test]
fn a_hot_pixel_is_listed_and_nothing_beside_it() {
    let reference_scene = reference_scene();
    let mut events: Vec<Event> = reference_scene.simulate(&model(), 1).unwrap().iter().collect();
    let hot = |i: i64| Event { t: Micros(8_000 * i), x: 20, y: 11, polarity: Polarity::On };
    events.extend((0..60).map(hot));
    let found = located(&reference_scene, &stream(events));
    assert_eq!(found.maps.hot, 1, "{:?}", found.maps.pixels);
    assert_eq!((found.maps.pixels[0].x, found.maps.pixels[0].y), (20, 11));
    assert!(found.maps.pixels[0].measured >= 60.0);
    let sentence = found.location().sentence;
    let is_reported = sentence.contains("Of hot pixels there are 1,");
    assert!(is_reported || found.scan.regions.is_empty(), "{sentence}");
}

#[test]
fn fewer_than_two_runs_say_nothing_and_no_events_are_no_error() {
    let reference_scene = reference_scene();
    let none = EventStream::empty(SIZE);
    let view = || View::new(&reference_scene, &none, window());
    assert!(locate(&view(), &[view()]).scan.sentence.contains("two runs"));
    let found = locate(&view(), &[view(), view(), view()]);
    assert!(found.scan.regions.is_empty() && found.maps.pixels.is_empty());
    let json = serde_json::to_string(&found).unwrap();
    assert_eq!(serde_json::from_str::<Located>(&json).unwrap(), found);
}

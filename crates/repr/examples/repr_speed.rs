//! Times what a stream spends on its planes, on one core: `cargo run --release -p evpose-repr --example
//! repr_speed [FILTER]`.
//!
//! Each line is the median of 31 runs (events per second of an update, time of an image).

#![allow(clippy::print_stdout, reason = "a program that prints")]

use std::time::{Duration, Instant};

use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity, SensorSize};
use evpose_repr::{
    ChannelOrder, Eros, ErosConfig, ErosFramer, Representation, StreamWindow, representation_called,
};

const VGA: SensorSize = SensorSize { width: 640, height: 480 };
const WINDOW: Micros = Micros(100_000);
const EVENTS: usize = 1_000_000;

/// Something to time: how many events it takes, or none where it makes an image.
struct Case {
    name: String,
    events: Option<usize>,
    run: Box<dyn FnMut()>,
}

/// A hundred blobs of 24 pixels that wander, and every tenth event noise: 100 ms.
fn wandering(sensor: SensorSize, count: usize) -> EventStream {
    let mut rng = CounterRng::new(7, "events", 0);
    let (width, height) = (f32::from(sensor.width), f32::from(sensor.height));
    let mut blobs: Vec<[f32; 2]> =
        (0..100).map(|_| [rng.uniform(0.0, width), rng.uniform(0.0, height)]).collect();
    let mut stream = EventStream::empty(sensor);
    for i in 0..count {
        let blob = &mut blobs[(rng.uniform(0.0, 100.0) as usize).min(99)];
        *blob = [blob[0] + rng.uniform(-0.5, 0.5), blob[1] + rng.uniform(-0.5, 0.5)];
        let [x, y] = if i % 10 == 0 {
            [rng.uniform(0.0, width), rng.uniform(0.0, height)]
        } else {
            blob.map(|v| v + rng.uniform(-12.0, 12.0))
        };
        let event = Event {
            t: Micros(i as i64 * WINDOW.0 / count as i64),
            x: x.clamp(0.0, width - 1.0) as u16,
            y: y.clamp(0.0, height - 1.0) as u16,
            polarity: Polarity::from_on(rng.chance(0.5)),
        };
        assert_eq!(stream.push(event), Ok(()));
    }
    stream
}

/// Everywhere at once: what caches help least with.
fn uniform(sensor: SensorSize, count: usize) -> EventStream {
    let mut rng = CounterRng::new(8, "events", 0);
    let mut stream = EventStream::empty(sensor);
    for i in 0..count {
        let event = Event {
            t: Micros(i as i64 * WINDOW.0 / count as i64),
            x: rng.uniform(0.0, f32::from(sensor.width)) as u16 % sensor.width,
            y: rng.uniform(0.0, f32::from(sensor.height)) as u16 % sensor.height,
            polarity: Polarity::from_on(rng.chance(0.5)),
        };
        assert_eq!(stream.push(event), Ok(()));
    }
    stream
}

/// Updating planes with events that go on in time, and drawing them.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let sensors = [("640x480", VGA), ("240x180", SensorSize::DAVIS240C)];
    for (size, sensor) in sensors {
        for (kind, events) in
            [("wandering", wandering(sensor, EVENTS)), ("uniform", uniform(sensor, EVENTS))]
        {
            for name in ["eros", "eros-hpe-core", "eros-python", "tos", "sits", "pim", "sae"]
                .into_iter()
                .chain(["lnes", "eci", "voxel-grid", "time-surface"])
            {
                let Ok(choice) = representation_called(name) else { continue };
                let Ok(window) = StreamWindow::new(sensor, WINDOW, ChannelOrder::OffFirst) else {
                    continue;
                };
                let mut running = choice.start(window);
                let events = events.clone();
                cases.push(Case {
                    name: format!("{name} update {size} {kind}"),
                    events: Some(events.len()),
                    run: Box::new(move || running.push(&events)),
                });
            }
        }
        let events = wandering(sensor, EVENTS / 4);
        for name in ["eros", "lnes", "eci", "voxel-grid", "time-surface", "event-count"] {
            let Ok(choice) = representation_called(name) else { continue };
            let Ok(window) = StreamWindow::new(sensor, WINDOW, ChannelOrder::OffFirst) else {
                continue;
            };
            let mut running = choice.start(window);
            running.push(&events);
            let mut planes = vec![0.0; choice.channels() * sensor.pixels()];
            cases.push(Case {
                name: format!("{name} image {size}"),
                events: None,
                run: Box::new(move || running.render(&mut planes)),
            });
        }
        // A recording's worth of events at once, planes included, as Tonic makes them.
        for name in ["eci", "voxel-grid"] {
            let Ok(choice) = representation_called(name) else { continue };
            let Ok(window) = StreamWindow::new(sensor, WINDOW, ChannelOrder::OffFirst) else {
                continue;
            };
            let events = wandering(sensor, EVENTS);
            let mut running = choice.start(window);
            let mut planes = vec![0.0; choice.channels() * sensor.pixels()];
            cases.push(Case {
                name: format!("{name} of a window {size}"),
                events: Some(events.len()),
                run: Box::new(move || {
                    running.reset();
                    running.push(&events);
                    running.render(&mut planes);
                }),
            });
        }
    }
    let mut eros = Eros::hpe_core(VGA, ErosConfig::ONLINE);
    eros.push(&wandering(VGA, EVENTS));
    let mut framer = ErosFramer::new(VGA, 192, 192);
    let mut image = vec![0; 192 * 192];
    cases.push(Case {
        name: "eros image, 8 bits, blurred, 192x192".to_owned(),
        events: None,
        run: Box::new(move || framer.resized(&eros, &mut image)),
    });
    cases
}

fn median(run: &mut dyn FnMut()) -> Duration {
    run();
    let mut times: Vec<Duration> = (0..31)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed()
        })
        .collect();
    times.sort_unstable();
    times[times.len() / 2]
}

fn main() {
    let filter = std::env::args().nth(1).unwrap_or_default();
    for mut case in cases().into_iter().filter(|case| case.name.contains(&filter)) {
        let time = median(&mut case.run);
        match case.events {
            Some(events) => {
                println!("{:45} {:8.1} M/s", case.name, events as f64 / time.as_secs_f64() * 1e-6);
            }
            None => println!("{:45} {:8.1} µs", case.name, time.as_secs_f64() * 1e6),
        }
    }
}

//! Simulated recordings with a given event rate, for benchmarks.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity, SensorSize, TimeWindow};
use evpose_sim::person::{People, PeopleConfig};
use evpose_sim::{Simulation, SimulationConfig};

/// Simulated time, which benchmarks replay repeatedly.
const SECONDS: f64 = 2.0;
/// Sensor of recordings of people.
const VGA: SensorSize = SensorSize { width: 640, height: 480 };
/// Time skipped at the start, where the appearing scene causes a burst of all pixels.
const SETTLED: Micros = Micros(200_000);

/// Writes a recording of a person before a hand-held camera, resampled to `rate` events per second.
pub(crate) fn of_body(folder: &Path, rate: f64) -> Result<PathBuf> {
    let config = PeopleConfig {
        sensor_size: VGA,
        sequences: 1,
        seconds: SECONDS,
        // A camera that moves makes events all over the image, as busy recordings have them.
        moving_cameras: 1.0,
        activities: vec!["boxing".to_owned()],
        ..PeopleConfig::default()
    };
    let people = People::new(&config, 1)?;
    let mut person = people.sequence(0)?;
    let mut events = EventStream::empty(VGA);
    for _ in 0..config.steps() {
        let step = person.advance()?;
        let e = step.events;
        events.extend_columns(e.t(), e.x(), e.y(), e.polarity())?;
    }
    write(folder, &events, rate)
}

/// Writes a recording of the published hand, resampled to `rate` events per second.
pub(crate) fn of_hand(folder: &Path, rate: f64) -> Result<PathBuf> {
    let config = SimulationConfig { seconds: SECONDS, sequences: 1, ..SimulationConfig::default() };
    let simulation = Simulation::new(&config, 1)?;
    let mut events = EventStream::empty(config.image_size());
    let mut sequence = simulation.sequence(0)?;
    for _ in 0..config.frames() {
        let step = sequence.advance()?;
        let e = step.events;
        events.extend_columns(e.t(), e.x(), e.y(), e.polarity())?;
    }
    write(folder, &events, rate)
}

/// Writes `events` resampled to `rate` events per second: noise is added, or random events are
/// removed.
fn write(folder: &Path, events: &EventStream, rate: f64) -> Result<PathBuf> {
    let end = events.t().last().copied().unwrap_or_default();
    let events = events.slice(TimeWindow { start: SETTLED, end: end + Micros(1) });
    let sensor = events.sensor();
    let wanted = (rate * (end - SETTLED).as_seconds()) as usize;
    let mut rng = CounterRng::new(1, "noise of a busy camera", 0);
    let mut all: Vec<Event> = Vec::with_capacity(wanted);
    let mut left = events.len();
    for event in events.iter() {
        // Selection sampling (Knuth, TAOCP 2, algorithm S): every subset of the size is equally likely.
        if rng.below(left) < wanted.saturating_sub(all.len()) {
            all.push(event);
        }
        left -= 1;
    }
    let more = wanted - all.len();
    // Noise is spread evenly, so that the rate is reached in every part of the recording.
    all.extend((0..more).map(|k| Event {
        t: SETTLED + Micros((k as f64 / more as f64 * (end - SETTLED).0 as f64) as i64),
        x: rng.below(usize::from(sensor.width)) as u16,
        y: rng.below(usize::from(sensor.height)) as u16,
        polarity: Polarity::from_on(rng.chance(0.5)),
    }));
    all.sort_by_key(|event| event.t);
    let path = folder.join("busy.raw");
    let all = EventStream::from_events(sensor, all)?;
    let format = evpose_io::FORMATS.find("evt3").context("a format that is registered")?;
    format.write(&path, &all)?;
    Ok(path)
}

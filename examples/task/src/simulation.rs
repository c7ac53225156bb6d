//! Recordings of a disc that moves, with its centre and its size at every millisecond.

use std::f32::consts::TAU;

use anyhow::Result;
use evpose_core::{CounterRng, EventStream, Micros, Plane, SensorSize, atomic_write, seed_for};
use evpose_io::poses::{PoseColumns, PoseKind, TimedPose};
use evpose_sensor::{SensorConfig, SensorModel};
use evpose_sim::SequenceSet;

use crate::config::BlobConfig;
use crate::stream::{Blob, LAYOUT, estimate};

/// Light of the disc and of what is behind it, relative to white.
const LIGHTS: [f32; 2] = [0.8, 0.2];

/// Records a sequence: `0007.raw`, `0007.poses.csv`, `0007.toml`.
pub(crate) fn record(config: &BlobConfig, set: &SequenceSet, sequence: u64) -> Result<()> {
    let size = config.sensor;
    let model = SensorModel::from_config(&SensorConfig::preset(&config.camera)?)?;
    let mut sensor = model.start(size, seed_for(config.seed, "sensor", sequence));
    let disc = Motion::new(config, sequence);
    let mut events = EventStream::empty(size);
    let mut poses = Vec::new();
    for step in 0..=(1e3 * config.seconds) as u32 {
        let (t, blob) = (Micros(1_000 * i64::from(step)), disc.at(1e-3 * step as f32));
        let new = sensor.expose(&luminance(size, blob), t)?;
        events.extend_columns(new.t(), new.x(), new.y(), new.polarity())?;
        poses.push(TimedPose::new(t, &estimate(&blob)));
    }
    let stem = set.stem(sequence);
    let raw = stem.with_extension("raw");
    evpose_io::format_for(&raw)?.write(&raw, &events)?;
    let columns = PoseColumns::of(PoseKind::Values(&LAYOUT));
    columns.write(&stem.with_extension("poses.csv"), &mut poses.into_iter())?;
    let sensor = format!("[sensor]\nwidth = {}\nheight = {}\n", size.width, size.height);
    Ok(atomic_write(stem.with_extension("toml"), sensor.as_bytes())?)
}

/// Middle, amplitude, frequency in hertz and phase of a sine along each axis, and of one of the diameter.
struct Motion([[f32; 4]; 3]);

impl Motion {
    fn new(config: &BlobConfig, sequence: u64) -> Self {
        let mut rng = CounterRng::new(config.seed, "motion", sequence);
        let [smallest, largest] = config.diameters_px;
        let (width, height) = (config.sensor.width.into(), config.sensor.height.into());
        Self([(0.0, width), (0.0, height), (smallest, largest)].map(|(low, high)| {
            let amplitude = 0.5 * (high - low) * rng.uniform(0.5, 0.9);
            [0.5 * (low + high), amplitude, rng.uniform(0.3, 0.9), rng.uniform(0.0, TAU)]
        }))
    }

    fn at(&self, t_s: f32) -> Blob {
        self.0.map(|[middle, amplitude, hz, phase]| {
            middle + amplitude * (TAU * hz * t_s + phase).sin()
        })
    }
}

/// The disc, with an edge that is a pixel wide.
fn luminance(sensor: SensorSize, [u, v, size]: Blob) -> Plane<f32> {
    let mut plane = Plane::for_sensor(sensor, 0.0);
    let width = usize::from(sensor.width);
    for (index, light) in plane.data_mut().iter_mut().enumerate() {
        let (x, y) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
        let covered = (0.5 * size - (x - u).hypot(y - v) + 0.5).clamp(0.0, 1.0);
        *light = LIGHTS[1] + (LIGHTS[0] - LIGHTS[1]) * covered;
    }
    plane
}

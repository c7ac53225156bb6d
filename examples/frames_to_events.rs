//! Turns a video into the events of a camera: a preset of the sensor model, exposed to one frame
//! after another.
//!
//! ```console
//! $ cargo run --release --example frames_to_events [FRAMES [PRESET]]
//! ```
//!
//! `FRAMES` is a folder of PNG images or an `.npy` array, taken as 240 frames a second; without it,
//! a disc moves in a circle. `PRESET` is `davis346` unless given; `evpose sensor list` names all.

#![allow(clippy::print_stdout, reason = "a program")]

use anyhow::Result;
use evpose_core::{EventStream, Micros, Plane, Polarity, SensorSize};
use evpose_io::{Encoding, FrameSource};
use evpose_sensor::{SensorConfig, SensorModel};

const FPS: f64 = 240.0;
const SEED: u64 = 1;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let frames = match arguments.next() {
        Some(path) => read(&path)?,
        None => (0..120).map(disc).collect(),
    };
    let preset = arguments.next().unwrap_or_else(|| "davis346".to_owned());
    let model = SensorModel::from_config(&SensorConfig::preset(&preset)?)?;

    let sensor = SensorSize { width: frames[0].width() as u16, height: frames[0].height() as u16 };
    let mut run = model.start(sensor, SEED);
    let mut all = EventStream::empty(sensor);
    for (index, frame) in frames.iter().enumerate() {
        let t = Micros::from_seconds(index as f64 / FPS);
        for event in run.expose(frame, t)?.iter() {
            all.push(event)?;
        }
    }

    let on = all.polarity().iter().filter(|polarity| **polarity == Polarity::On).count();
    let seconds = frames.len() as f64 / FPS;
    let rate = all.len() as f64 / seconds / 1e3;
    println!(
        "stages: {}",
        model.describe().rows.iter().map(|row| row.spec.name).collect::<Vec<_>>().join(", ")
    );
    println!("{} frames of {sensor} in {seconds:.2} s of {preset}", frames.len());
    println!("{} events, {on} of them ON: {rate:.0} thousand a second", all.len());
    Ok(())
}

/// All frames of a folder or array, as luminance relative to white.
fn read(path: &str) -> Result<Vec<Plane<f32>>> {
    let mut source = FrameSource::open(path, Encoding::Srgb, None)?;
    let mut frames = Vec::new();
    let mut frame = Plane::for_sensor(source.size(), 0.0);
    while source.next_into(&mut frame)? {
        frames.push(frame.clone());
    }
    anyhow::ensure!(!frames.is_empty(), "{path}: no frames");
    Ok(frames)
}

/// A grey disc before a dark background, at its place in a circle.
fn disc(index: usize) -> Plane<f32> {
    let sensor = SensorSize { width: 96, height: 72 };
    let angle = index as f32 * 0.1;
    let centre = [48.0 + 24.0 * angle.cos(), 36.0 + 18.0 * angle.sin()];
    let mut frame = Plane::for_sensor(sensor, 0.15);
    for y in 0..frame.height() {
        for x in 0..frame.width() {
            let distance = (x as f32 - centre[0]).hypot(y as f32 - centre[1]);
            // A soft edge of a pixel: area that the disc covers.
            *frame.at_mut(x, y) += 0.5 * (9.5 - distance).clamp(0.0, 1.0);
        }
    }
    frame
}

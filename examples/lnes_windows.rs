//! Reads a recording of any format in windows of 50 ms and renders each as LNES
//! (locally normalised event surfaces).
//!
//! ```console
//! $ cargo run --release --example lnes_windows [RECORDING]
//! ```
//!
//! Without a file, a bright bar that crosses the sensor is simulated first.

#![allow(clippy::print_stdout, reason = "a program")]

use std::path::Path;

use anyhow::Result;
use evpose_core::{EventStream, Micros, Plane, SensorSize, TimeWindow};
use evpose_io::{OpenOptions, Windows, format_for};
use evpose_repr::{ChannelOrder, Lnes, Representation, StreamWindow};
use evpose_sensor::{SensorConfig, SensorModel};

const WINDOW: Micros = Micros(50_000);

fn main() -> Result<()> {
    let directory = tempfile::tempdir()?;
    let made = directory.path().join("bar.npz");
    let path = match std::env::args().nth(1) {
        Some(path) => path.into(),
        None => simulate_bar(&made).map(|()| made)?,
    };

    let mut windows = Windows::open(&path, &OpenOptions::default())?;
    let sensor = windows.sensor();
    println!("{}: a sensor of {sensor}", path.display());
    let mut lnes = Lnes::new(StreamWindow::new(sensor, WINDOW, ChannelOrder::OffFirst)?);
    let mut planes = vec![0.0; lnes.channels() * sensor.pixels()];
    let mut events = EventStream::empty(sensor);
    let mut start = windows.start().unwrap_or(Micros(0));
    println!("  from (ms)   events   active pixels   mean of active pixels");
    while !windows.is_over_at(start)? {
        let window = TimeWindow { start, end: start + WINDOW };
        windows.read(window, &mut events)?;
        lnes.push(&events);
        lnes.advance(window.end);
        lnes.render(&mut planes);
        let active: Vec<f32> = planes.iter().copied().filter(|&value| value > 0.0).collect();
        let mean = active.iter().sum::<f32>() / active.len().max(1) as f32;
        let from_ms = 1e3 * start.as_seconds();
        println!("{from_ms:>11.0} {:>8} {:>15} {mean:>23.3}", events.len(), active.len());
        start = window.end;
    }
    Ok(())
}

/// Writes the events of a bar that crosses a sensor of 64x48 pixels in 0.4 s.
fn simulate_bar(path: &Path) -> Result<()> {
    let sensor = SensorSize { width: 64, height: 48 };
    let model = SensorModel::from_config(&SensorConfig::preset("ideal")?)?;
    let mut run = model.start(sensor, 1);
    let mut all = EventStream::empty(sensor);
    for step in 0..=400 {
        let mut frame = Plane::for_sensor(sensor, 0.2);
        let bar = step * usize::from(sensor.width) / 400;
        for y in 8..40 {
            frame.row_mut(y).iter_mut().skip(bar).take(4).for_each(|pixel| *pixel = 0.8);
        }
        for event in run.expose(&frame, Micros(1_000 * step as i64))?.iter() {
            all.push(event)?;
        }
    }
    Ok(format_for(path)?.write(path, &all)?)
}

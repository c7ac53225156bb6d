//! `evpose calibrate`: camera parameters from calibration recordings.

mod args;
mod noise;
mod threshold;

use std::path::Path;

use anyhow::Result;
use evpose_core::stats::interval::Interval;
use evpose_core::{EventStream, SensorSize};
use evpose_gap::input::load_recording;
use evpose_io::OpenOptions;
use evpose_sensor::{EffectConfig, SensorConfig};

pub use args::CalibrateCommand;

use crate::outputs::write_file;
use crate::progress::say;

/// Runs `evpose calibrate`.
pub fn run(command: &CalibrateCommand) -> Result<()> {
    match command {
        CalibrateCommand::Threshold(args) => threshold::run(args),
        CalibrateCommand::Noise(args) => noise::run(args),
    }
}

/// Reads all events of a file; `sensor` is the size for files that do not state it.
fn read(path: &Path, sensor: SensorSize, options: &OpenOptions) -> Result<EventStream> {
    let read = load_recording(path, Some(sensor), options)?;
    for note in &read.notes {
        say(format!("note      {note}"));
    }
    if read.outside > 0 {
        say(format!("note      {} events outside the sensor: skipped", read.outside));
    }
    Ok(read.events)
}

fn interval_text(interval: Interval, unit: &str) -> String {
    match (interval.low, interval.high) {
        (Some(low), Some(high)) => {
            format!("{:.4} {unit} [{low:.4}, {high:.4}]", interval.estimate)
        }
        _ => format!("{:.4} {unit}", interval.estimate),
    }
}

fn write(path: &Path, head: &str, effects: Vec<EffectConfig>) -> Result<()> {
    let mut config = SensorConfig::from_toml("")?;
    config.effects = effects;
    let text = format!("# {head}\n\n{}", config.to_toml());
    write_file(path, text)
}

//! `evpose bench cameras`: the accuracy of a network on the same scenes before seven sensors.

mod body;
mod hand;

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use burn::tensor::Device;
use evpose_core::SensorSize;
use evpose_task::body::BodyCheckpoint;
use evpose_task::hand::HandCheckpoint;
use serde::Serialize;

use evpose_cli::json::write_json;
use evpose_cli::outputs::OutputFile;
use evpose_cli::progress::say;
use evpose_cli::provenance::Provenance;
use evpose_cli::ranges::{count, seconds, threads};
use evpose_cli::shipped::checkpoint_path;
use evpose_cli::threads::use_threads;

/// Sizes of the sensors of common cameras.
const SENSORS: [[u16; 2]; 7] =
    [[128, 128], [240, 180], [304, 240], [346, 260], [320, 240], [640, 480], [1280, 720]];

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose bench cameras --checkpoint hand\n  \
    evpose bench cameras --checkpoint body --sequences 8 --json cameras.json\n\n\
    Lenses are such that each sensor sees all that the network does; accuracy relative to the native \
    view is that of the same people or hands in the same motion.")]
pub struct BenchCamerasArgs {
    /// A run directory, a .bpk file, or the name of a shipped network
    #[arg(long)]
    pub(crate) checkpoint: PathBuf,
    /// Sequences before each sensor
    #[arg(long, default_value_t = 6, value_parser = count::<usize>())]
    pub(crate) sequences: usize,
    /// Length of each sequence in seconds
    #[arg(long, default_value_t = 2.0, value_parser = seconds())]
    pub(crate) seconds: f64,
    /// Seed of the scenes
    #[arg(long, default_value_t = 407)]
    pub(crate) seed: u64,
    /// CPU threads; all cores by default
    #[arg(long, value_parser = threads())]
    pub(crate) threads: Option<usize>,
    /// Where to write the results as JSON
    #[arg(long)]
    pub(crate) json: Option<OutputFile>,
}

/// Accuracy before a sensor; larger is better.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct CameraScore {
    sensor: SensorSize,
    /// The 2D AUC of hands, PCK@0.4 of bodies.
    score: f64,
}

/// Content of the JSON file.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    provenance: Provenance,
    checkpoint: String,
    metric: &'static str,
    native: CameraScore,
    cameras: Vec<CameraScore>,
    worst_over_native: f64,
}

/// Scenes of a task before any sensor.
struct Scenes {
    /// Name of the metric in the table.
    metric: &'static str,
    /// The sensor that the network expects.
    native: SensorSize,
    /// The accuracy before a sensor.
    score: Box<dyn Fn(SensorSize) -> Result<f64>>,
}

/// Evaluates a network before all sensors and prints a table.
///
/// # Errors
/// If the checkpoint cannot be read, or a simulation fails.
pub(super) fn run(args: &BenchCamerasArgs) -> Result<()> {
    use_threads(args.threads)?;
    if args.sequences == 0 || args.seconds.is_nan() || args.seconds < 0.5 {
        bail!("at least one sequence of half a second is needed");
    }
    let path = checkpoint_path(&args.checkpoint)?;
    let device = Device::flex();
    // Hands first; what is no checkpoint of either fails with the second error.
    let Scenes { metric, native, score } = match HandCheckpoint::load(&path, &device) {
        Ok(checkpoint) => hand::scenes(checkpoint, args)?,
        Err(_) => body::scenes(BodyCheckpoint::load(&path, &device)?, args)?,
    };
    let provenance = Provenance::this();
    say(format!("machine: {}", provenance.machine));
    let measure = |sensor: SensorSize| -> Result<CameraScore> {
        Ok(CameraScore { sensor, score: score(sensor)? })
    };
    // The sensor of its training is what the others are compared with.
    let native = measure(native)?;
    say(format!("{:<12}{metric:>14}{:>10}", "sensor", "relative"));
    say(format!("{:<12}{:>14.3}{:>10}", native.sensor.to_string(), native.score, "native"));
    let mut cameras = Vec::new();
    for [width, height] in SENSORS {
        let camera = measure(SensorSize { width, height })?;
        let relative = camera.score / native.score;
        say(format!("{:<12}{:>14.3}{relative:>10.3}", camera.sensor.to_string(), camera.score));
        cameras.push(camera);
    }
    // The worst of all: a network that works before most sensors only is not done.
    let worst = cameras.iter().map(|camera| camera.score).min_by(f64::total_cmp);
    let worst_over_native = worst.context("no sensor")? / native.score;
    say(format!("worst over native: {worst_over_native:.3}"));
    let report = Report {
        provenance,
        checkpoint: path.display().to_string(),
        metric,
        native,
        cameras,
        worst_over_native,
    };
    write_json(args.json.as_deref(), &report)
}

/// The vertical field of view in degrees with which a sensor sees at least what one of 4 to 3 sees
/// with `degrees`.
fn covering_fov_deg(sensor: SensorSize, degrees: f64) -> f64 {
    let aspect = f64::from(sensor.width) / f64::from(sensor.height);
    let wider = (4.0 / 3.0 / aspect).max(1.0);
    2.0 * ((0.5 * degrees.to_radians()).tan() * wider).atan().to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_sensor_gets_a_wider_lens_and_a_wide_one_does_not() {
        let fov = |width, height| covering_fov_deg(SensorSize { width, height }, 45.0);
        assert!((fov(240, 180) - 45.0).abs() < 1e-9);
        assert!((fov(1280, 720) - 45.0).abs() < 1e-9);
        let across = 2.0 * ((22.5f64.to_radians()).tan() * 4.0 / 3.0).atan().to_degrees();
        assert!((fov(128, 128) - across).abs() < 1e-9);
    }
}

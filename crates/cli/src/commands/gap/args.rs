//! Arguments of `evpose gap`.

use std::path::PathBuf;

use crate::outputs::OutputFile;
use crate::ranges::{seconds, since_start, threads, within};
use clap::Subcommand;
use evpose_gap::davis::Response;

use crate::tasks::opening::OpeningArgs;

const EXIT_CODES: &str = "Exit codes: 0 no gap, 10 a parameter differs, 11 effects are missing, 12 no known \
                          effect explains the gap, 13 undecided, 14 a part of the gap is explained, \
                          15 the time of --budget ran out, 2 invalid input, 1 any other error.";

/// Subcommands of `evpose gap` that identify effects of a recording.
#[derive(Debug, Subcommand)]
#[command(after_help = "Start with:\n  \
    evpose gap run --measured rec.npz --scene scene/ --model ideal --out gap/\n  \
    evpose gap verify gap/\n\n\
    A scene directory holds `scene.json` (width, height, fps, duration_s, and optionally white and \
    nominal) and the luminance of every frame in `frames.npy` or `frames/`. A scene can also be a config \
    or an output directory of `evpose simulate`, with #N for sequence N, which is then rendered. With \
    --poses, hands are rendered in the poses of a file, with unknown light and texture. With \
    `--scene frames`, the scene is estimated from the frames of a DAVIS recording.")]
pub enum GapCommand {
    /// Identify missing effects, add them to the model, and report the gap closed
    Run(RunArgs),
    /// Compare a recording with the model, statistic by statistic
    Probe(InputArgs),
    /// Report at which luminance, where and when recording and model disagree
    Locate(InputArgs),
    /// Identify the missing effects without correcting the model
    #[command(after_help = EXIT_CODES)]
    Name(InputArgs),
    /// Identify the missing effects and write the corrected model
    Correct(CorrectArgs),
    /// Identify the missing effects, then drop each one and swap it for its nearest rival
    #[command(after_help = EXIT_CODES)]
    Ablate(InputArgs),
    /// Predict which effects a recording of a scene could show
    Power(PowerArgs),
    /// Render the report of a run again
    Report(ReportArgs),
    /// Evaluate a run by five statistics, with code independent of the search
    Verify(VerifyArgs),
    /// Measure a camera from recordings of unknown light, as a sensor to simulate with
    Camera(CameraArgs),
}

/// Recording, scene and model of a comparison.
#[derive(Debug, clap::Args)]
pub struct InputArgs {
    /// The recording, in any supported format; `evpose convert --help` lists them
    #[arg(long)]
    pub(crate) measured: PathBuf,
    /// Its scene: a directory, a config of `evpose simulate` (CONFIG#N for sequence N, default 0),
    /// `frames` for the frames in an AEDAT4 recording or a bag of ROS, or `none` for an unknown scene
    #[arg(long, value_name = "DIR|CONFIG[#N]|frames|none")]
    pub(crate) scene: PathBuf,
    /// Response curve of the frames in the recording: linear, srgb, or a gamma such as 2.2
    /// [default: linear]
    #[arg(long, value_name = "CURVE")]
    pub(crate) response: Option<Response>,
    /// Hand poses of the recording (.meta, as `evpose simulate` writes them); --scene is then the config
    /// of camera and sensor, with unknown light and texture
    #[arg(long, value_name = "FILE")]
    pub(crate) poses: Option<PathBuf>,
    /// Seconds to compare, for scenes of a config or of recorded frames [default: all, at most 2]
    #[arg(long, value_parser = seconds())]
    pub(crate) seconds: Option<f64>,
    /// The model: a preset or a TOML file of effects
    #[arg(long, default_value = "ideal")]
    pub(crate) model: String,
    /// A second recording of the same sensor, for validation [default: the later part of the first]
    #[arg(long, requires = "validate_scene")]
    pub(crate) validate: Option<PathBuf>,
    /// Its scene, as --scene
    #[arg(long, requires = "validate", value_name = "DIR|CONFIG[#N]|frames")]
    pub(crate) validate_scene: Option<PathBuf>,
    /// Its poses, as --poses
    #[arg(long, requires_all = ["validate", "poses"], value_name = "FILE")]
    pub(crate) validate_poses: Option<PathBuf>,
    /// Seed of all noise of simulations
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Effects that are excluded from the search
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) leave_out: Vec<String>,
    /// Do not correct the time unit, start or orientation of the recording
    #[arg(long)]
    pub(crate) as_is: bool,
    /// Fewer replicates for probabilities and maps; the identification is the same
    #[arg(long)]
    pub(crate) quick: bool,
    /// Seconds that the search may take: it then names what it has found. By default it ends by
    /// itself; with a budget the result depends on the speed of the machine
    #[arg(long, value_name = "SECONDS", value_parser = since_start())]
    pub(crate) budget: Option<f64>,
    /// CPU threads; all cores by default. The result does not depend on it
    #[arg(long, value_parser = threads())]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose gap run --measured rec.npz --scene scene/ --model configs/sensor/ideal.toml --out gap/\n  \
    evpose gap run --measured a.npz --scene a/ --validate b.npz --validate-scene b/ --out gap/ \
    --quick\n  \
    evpose gap run --measured sim/0001.evc --scene sim#1 --out gap/\n  \
    evpose gap run --measured sim/0001.evc --scene sim --poses sim/0001.meta --out gap/\n  \
    evpose gap run --measured davis.aedat4 --scene frames --response linear --out gap/\n  \
    evpose gap run --measured rec.npz --scene none --out gap/\n\n\
    Exit codes: 0 no gap, 10 a parameter differs, 11 effects are missing, 12 no known effect explains \
    anything of the gap, 13 undecided, 14 a part of the gap is explained, 15 the time of --budget ran out, \
    2 invalid input, 1 any other error.")]
pub struct RunArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    /// Directory for verdict.json, evidence.json, corrected.toml, report.html and run.json
    #[arg(long)]
    pub(crate) out: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    evpose gap correct --measured rec.npz --scene scene/ --model ideal --out corrected.toml\n\n\
    Exit codes as of `evpose gap run`. If no effect is identified, the model is written with refitted \
    parameters.")]
pub struct CorrectArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    /// Where to write the corrected model
    #[arg(long)]
    pub(crate) out: OutputFile,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  evpose gap power --scene scene/ --model ideal")]
pub struct PowerArgs {
    /// A scene: a directory, or a config of `evpose simulate`
    #[arg(long, value_name = "DIR|CONFIG[#N]")]
    pub(crate) scene: PathBuf,
    /// The model: a preset or a TOML file of effects
    #[arg(long, default_value = "ideal")]
    pub(crate) model: String,
    /// Seed of all noise
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Seconds of the scene that are simulated
    #[arg(long, default_value_t = 0.4, value_parser = seconds())]
    pub(crate) seconds: f64,
    /// CPU threads; all cores by default
    #[arg(long, value_parser = threads())]
    pub(crate) threads: Option<usize>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  evpose gap report gap/")]
pub struct ReportArgs {
    /// A directory of `evpose gap run`
    pub(crate) dir: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  evpose gap verify gap/")]
pub struct VerifyArgs {
    /// A directory of `evpose gap run`; its run.json names the files
    pub(crate) dir: PathBuf,
    /// Runs of each model
    #[arg(long, default_value_t = 6, value_parser = within(2..=1_000_000_u64))]
    pub(crate) runs: u64,
    /// Seed of these runs
    #[arg(long, default_value_t = 1_000)]
    pub(crate) seed: u64,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose gap camera wall.npz --out camera/\n  \
    evpose gap camera wall.npz dark.npz lamp.npz pan.npz --out camera/\n  \
    evpose sensor show camera/camera.toml\n\n\
    Record, a minute each, with the same settings of the camera: a static scene at two or three light levels, a \
    lamp, and a slow pan over a printed page to and fro with a second of rest. What the recordings do not show is \
    listed with the recording that would.")]
pub struct CameraArgs {
    /// Recordings of one camera, in any supported format
    #[arg(required = true, value_name = "RECORDING")]
    pub(crate) recordings: Vec<PathBuf>,
    /// Directory for camera.toml, camera.json and camera.html
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// CPU threads; all cores by default. The result does not depend on it
    #[arg(long, value_parser = threads())]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
}

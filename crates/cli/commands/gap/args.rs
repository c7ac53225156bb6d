//! Arguments of `evpose gap`.

use std::path::PathBuf;

use clap::Subcommand;
use evpose_bench::gap::{BenchArgs, CalibrateArgs, ScoreArgs};
use evpose_gap::davis::Response;

/// How steps that name something end.
const EXIT_CODES: &str = "Ends with 0 if there is no gap, 10 for a parameter, 11 for effects, 12 if nothing \
                          of the catalogue\nexplains it, 13 if undecided, 2 if the input cannot be used, \
                          1 for anything else.";

/// Subcommands of `evpose gap`.
#[derive(Debug, Subcommand)]
#[command(after_help = "Start with:\n  \
    evpose gap run --measured rec.npz --scene scene/ --model ideal --out gap/\n  \
    evpose gap verify gap/\n\n\
    A scene directory holds `scene.json` (width, height, fps, duration_s, and if known white and\n\
    nominal) and the light of every frame in `frames.npy` or `frames/`. Instead, a scene can be a\n\
    config as `evpose simulate` takes it, or a directory that it wrote, with #N for sequence N: its\n\
    light is rendered. With --poses, hands in the poses of a file are rendered, and light and\n\
    texture are left open. `--scene frames` takes the frames that a DAVIS recorded beside its\n\
    events: what they hide is left open.")]
pub(crate) enum GapCommand {
    /// Find the effects that a sensor model lacks, add them, and report how far the gap closes
    Run(RunArgs),
    /// Compare a recording with the model, statistic by statistic
    Probe(InputArgs),
    /// Report in which light, where and when recording and model disagree
    Locate(InputArgs),
    /// Identify the missing effects, and stop there
    #[command(after_help = EXIT_CODES)]
    Name(InputArgs),
    /// Identify the missing effects and write the corrected model
    Correct(CorrectArgs),
    /// Identify the missing effects, then drop each one and swap it for its nearest rival
    #[command(after_help = EXIT_CODES)]
    Ablate(InputArgs),
    /// Predict which effects a recording of a scene could show
    Power(PowerArgs),
    /// Draw the report of a run again
    Report(ReportArgs),
    /// Evaluate a run by five plain statistics, with code that is independent of the search
    Verify(VerifyArgs),
    /// Benchmark: hide effects in recordings of an independent pixel, and count the identified ones
    Bench(BenchArgs),
    /// Merge the results of all shards of a benchmark: scores, tables and a page
    Score(ScoreArgs),
    /// Fit the constants of probabilities and intervals to results of a development plan
    Calibrate(CalibrateArgs),
}

/// Recording, scene and model of a comparison.
#[derive(Debug, clap::Args)]
pub(crate) struct InputArgs {
    /// The recording: .npz, .npy, .txt, .evc, recognised by content
    #[arg(long)]
    pub(crate) measured: PathBuf,
    /// Its scene: a directory, a config of `evpose simulate` (CONFIG#N for its sequence N, else
    /// 0), `frames` for those that an AEDAT4 recording holds itself, or `none` for a recording alone
    #[arg(long, value_name = "DIR|CONFIG[#N]|frames|none")]
    pub(crate) scene: PathBuf,
    /// The response curve of a recording's own frames: linear, srgb, or an exponent such as 2.2
    /// [default: linear]
    #[arg(long, value_name = "CURVE")]
    pub(crate) response: Option<Response>,
    /// Poses of the hand in the recording (.meta, as `evpose simulate` writes them); --scene is then
    /// the config with camera and sensor size, and light and texture are taken to be unknown
    #[arg(long, value_name = "FILE")]
    pub(crate) poses: Option<PathBuf>,
    /// Seconds of a config's scene, or of a recording with frames, that are compared [default: all,
    /// at most 2]
    #[arg(long)]
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
    /// Take the recording as it is: do not correct its time unit, start or orientation
    #[arg(long)]
    pub(crate) as_is: bool,
    /// Fewer replicates for probabilities and maps; the naming is the same
    #[arg(long)]
    pub(crate) quick: bool,
    /// CPU threads; all cores by default. What is found does not depend on it
    #[arg(long)]
    pub(crate) threads: Option<usize>,
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
    Ends with 0 if there is no gap, 10 for a parameter, 11 for effects, 12 if nothing of the\n\
    catalogue explains it, 13 if undecided, 2 if the input cannot be used, 1 for anything else.")]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    /// Directory for verdict.json, corrected.toml, report.html and how they were made
    #[arg(long)]
    pub(crate) out: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    evpose gap correct --measured rec.npz --scene scene/ --model ideal --out corrected.toml\n\n\
    Ends with the exit codes of `evpose gap run`. Where no effect is named, the model with its\n\
    own parameters refitted is written.")]
pub(crate) struct CorrectArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    /// Where to write the corrected model
    #[arg(long)]
    pub(crate) out: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  evpose gap power --scene scene/ --model ideal")]
pub(crate) struct PowerArgs {
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
    #[arg(long, default_value_t = 0.4)]
    pub(crate) seconds: f64,
    /// CPU threads; all cores by default
    #[arg(long)]
    pub(crate) threads: Option<usize>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  evpose gap report gap/")]
pub(crate) struct ReportArgs {
    /// A directory of `evpose gap run`
    pub(crate) dir: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  evpose gap verify gap/")]
pub(crate) struct VerifyArgs {
    /// A directory of `evpose gap run`; its run.json names the files
    pub(crate) dir: PathBuf,
    /// Runs of each model
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u64).range(2..))]
    pub(crate) runs: u64,
    /// Seed of these runs
    #[arg(long, default_value_t = 1_000)]
    pub(crate) seed: u64,
}

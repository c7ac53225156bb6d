//! What can be typed behind `evpose gap`.

use std::path::PathBuf;

use clap::Subcommand;
use evpose_bench::gap::{BenchArgs, CalibrateArgs, ScoreArgs};
use evpose_gap::davis::Response;

/// How steps that name something end.
const EXIT_CODES: &str = "Ends with 0 if there is no gap, 10 for a parameter, 11 for effects, 12 if nothing \
                          of the catalogue\nexplains it, 13 if undecided, 2 if the input cannot be used, \
                          1 for anything else.";

/// What can be done about a gap.
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
    /// Find what is missing in a sensor model, add it, and say how far the gap closes
    Run(RunArgs),
    /// Compare a recording with the model, number by number
    Probe(InputArgs),
    /// Say in which light, where and when recording and model disagree
    Locate(InputArgs),
    /// Name what is missing, and stop there
    #[command(after_help = EXIT_CODES)]
    Name(InputArgs),
    /// Name what is missing and write the corrected model
    Correct(CorrectArgs),
    /// Name what is missing, then take it out again and put its nearest rival in
    #[command(after_help = EXIT_CODES)]
    Ablate(InputArgs),
    /// Say what a recording of a scene could show, before there is one
    Power(PowerArgs),
    /// Draw the report of a run once more
    Report(ReportArgs),
    /// Judge a run by five plain statistics, with code that the rest does not use
    Verify(VerifyArgs),
    /// Hide effects in recordings of an independent pixel, and count what is found
    Bench(BenchArgs),
    /// Put the results of all parts of a benchmark together: scores, tables and a page
    Score(ScoreArgs),
    /// Fit the constants of probabilities and intervals to results of a development plan
    Calibrate(CalibrateArgs),
}

/// What is compared with what.
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
    /// A second recording of the same sensor, to judge on; else the later part of the first
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
    /// Effects that are not looked for
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) leave_out: Vec<String>,
    /// Take the recording as it is: do not put right its unit of time, start or orientation
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
    own numbers refitted is written.")]
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
    /// Seconds of the scene that are looked at
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

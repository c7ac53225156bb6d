//! Arguments of the commands that tasks implement.

use std::path::{Path, PathBuf};

use crate::args::{ConfigArgs, DeviceArgs};
use evpose_infer::Precision;
use evpose_io::poses::{POSE_FORMATS, PoseFormat, pose_format_of};
use evpose_sim::Shard;
use evpose_train::TrainOptions;

use crate::outputs::OutputFile;
use crate::ranges::{count, seconds, threads};
use crate::shipped::checkpoint_path;
use crate::tasks::opening::OpeningArgs;
use crate::tasks::own_args::{Eval, Infer, Simulate, TaskArgs, Train};

/// Arguments of `evpose simulate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose simulate quick --out data/train\n  \
    evpose simulate eventhands --out data/one --sequences 1 --seconds 10 --seed 7\n  \
    evpose simulate quick --out data/train --shard 3/64 --resume\n  \
    evpose simulate quick --condition dark --out data/dark --held-out\n  \
    evpose simulate eventhands --set simulation.motion.variant=bottom --sequences 8 --seconds 3 \\\n      \
    --out data/bottom --preview bottom.png\n\n\
    Shards may share a directory or be copied together: the files are those of one run. The last \
    one to finish writes manifest.sha256; `evpose info --verify DIR` and `sha256sum -c` check it. \
    docs/guide/scale.md says more.")]
pub struct SimulateArgs {
    /// Config and overrides.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Directory to write the sequences into
    #[arg(long)]
    pub out: PathBuf,
    /// Length of each sequence in seconds, instead of the config's
    #[arg(long, value_parser = seconds())]
    pub seconds: Option<f64>,
    /// Number of sequences, instead of the config's
    #[arg(long, value_parser = count::<usize>())]
    pub sequences: Option<usize>,
    /// Seed, instead of the config's
    #[arg(long)]
    pub seed: Option<u64>,
    /// Record the held-out set, with its own number and length of sequences and its own seeds
    #[arg(long)]
    pub held_out: bool,
    /// Record only shard I of N of the sequences (I from 1)
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Keep the sequences that are complete and record the others
    #[arg(long)]
    pub resume: bool,
    /// CPU threads; all cores by default. The bytes written do not depend on it
    #[arg(long, value_parser = threads())]
    pub threads: Option<usize>,
    /// Arguments of the task of the config.
    #[command(flatten)]
    pub own: TaskArgs<Simulate>,
}

/// Arguments of `evpose simulate` of tasks that draw scenes.
#[derive(Debug, clap::Args)]
pub(crate) struct RecordingArgs {
    /// Format of the events, instead of the config's: a name of `evpose convert --help`, or an ending
    /// such as raw, h5 or aedat4 [default: people raw; hands evc, and raw of more than 256 rows]
    #[arg(long)]
    pub(crate) format: Option<String>,
    /// Also write a PNG file of rendered frames and their events side by side
    #[arg(long, value_name = "FILE")]
    pub(crate) preview: Option<OutputFile>,
}

/// Arguments of `evpose train`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose train quick --data data/train --out runs/hand\n  \
    evpose train quick --data data/train --out runs/hand --resume\n  \
    evpose train configs/body/pretrain.toml\n  \
    evpose train configs/body/finetune.toml")]
pub struct TrainArgs {
    /// Config and overrides.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Continue an interrupted run from its newest checkpoint
    #[arg(long)]
    pub resume: bool,
    /// Plain lines instead of the dashboard, even on a terminal
    #[arg(long)]
    pub plain: bool,
    /// Arguments of the task of the config.
    #[command(flatten)]
    pub own: TaskArgs<Train>,
    /// Device and threads.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Arguments of `evpose train` of tasks that train on one directory.
#[derive(Debug, clap::Args)]
pub struct DirectoryArgs {
    /// Directory of sequences from `evpose simulate`
    #[arg(long)]
    pub data: PathBuf,
    /// Directory of the run
    #[arg(long)]
    pub out: PathBuf,
}

/// Arguments of `evpose train` of tasks whose trainings start from weights.
#[derive(Debug, clap::Args)]
pub(crate) struct StartArgs {
    /// A run, a file of weights, or the name of a shipped network to start from [default: the config's
    /// `start_from`]
    #[arg(long, value_name = "RUN")]
    start_from: Option<PathBuf>,
}

impl StartArgs {
    /// The file that is given, or else that of the config.
    pub(crate) fn or(&self, of_config: Option<PathBuf>) -> anyhow::Result<Option<PathBuf>> {
        self.start_from.as_deref().map_or(Ok(of_config), |start| checkpoint_path(start).map(Some))
    }
}

impl TrainArgs {
    /// Options of the run.
    pub fn options(&self) -> TrainOptions {
        let Self { resume, plain, .. } = *self;
        TrainOptions { resume, plain, ..TrainOptions::new(self.device.device) }
    }
}

/// Arguments of `evpose eval`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Conditions:\n  \
    normal      as in training\n  \
    slow        a tenth of the speed, with rests\n  \
    lit         office light, DAVIS240C\n  \
    dark        a hundredth of the light, same camera\n  \
    night       a thousandth\n  \
    dark-noisy  as dark, with much shot noise\n\n\
    Examples:\n  \
    evpose eval --checkpoint runs/hand --data data/test --json metrics.json\n  \
    evpose eval --checkpoint runs/hand --conditions normal,slow,lit,dark --out runs/conditions\n  \
    evpose eval --checkpoint body --data data/people --foreign")]
pub struct EvalArgs {
    /// A run directory, a .bpk file, or the name of a shipped network: `hand`, `body`, …
    #[arg(long)]
    pub checkpoint: PathBuf,
    /// Directory of held-out sequences
    #[arg(long, required_unless_present_any = ["conditions", "foreign"])]
    pub data: Option<PathBuf>,
    /// Where to write the metrics as JSON
    #[arg(long)]
    pub json: Option<OutputFile>,
    /// Milliseconds between the poses that are evaluated [hands: 1; bodies: the config's]
    #[arg(long, value_parser = count::<u32>())]
    pub stride_ms: Option<u32>,
    /// Arguments of the task of the checkpoint.
    #[command(flatten)]
    pub own: TaskArgs<Eval>,
    /// Device and threads.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Arguments of `evpose eval` of tasks with cameras and recordings of others.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct PoseEvalArgs {
    /// Also evaluate on recordings from outside of this simulator (other meshes, motions, renderers and
    /// pixels): hands or bodies of this directory
    #[arg(
        long, value_name = "DIR", num_args = 0..=1, default_missing_value = "datasets/development",
        conflicts_with = "conditions"
    )]
    pub(crate) foreign: Option<PathBuf>,
    /// The camera of --data: a calibration file of OpenCV, ROS, kalibr, DSEC, rpg, dv-processing or this project, a name
    /// such as `davis346`, or a vertical field of view such as `60deg` [default: that of the
    /// simulation, or a guess]
    #[arg(long, value_name = "CAMERA", requires = "data")]
    pub(crate) camera: Option<String>,
    /// Precision of the inference: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub(crate) precision: Precision,
}

/// Arguments of `evpose infer`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose infer --checkpoint runs/hand \
    --events hand.evc --out poses.csv --joints joints.csv\n  evpose infer --checkpoint runs/hand \
    --events slow.npz --out poses.csv --mode slow-motion\n  evpose infer --checkpoint runs/hand \
    --events rec.aedat4 --camera calibration.yaml \\\n      --out poses.csv --joints joints.csv\n  \
    evpose infer --checkpoint body --events left.raw right.raw --cameras rig.toml \\\n      \
    --out people.csv")]
pub struct InferArgs {
    /// A run directory, a .bpk file, or the name of a shipped network: `hand`, `body`, …
    #[arg(long)]
    pub checkpoint: PathBuf,
    /// Sensor, camera of the file, ticks, damage.
    #[command(flatten)]
    pub opening: OpeningArgs,
    /// Output, in the format of its ending (.csv, .json, .jsonl): a line for each time with its time stamp in
    /// microseconds, score, and joints by name in pixels of the sensor; of hands also 12 parameters, and
    /// joints in metres in the camera's frame. A line of nobody says so
    #[arg(long)]
    pub out: OutputFile,
    /// Also write the latency of each pose, from its events to the pose on this machine: the output then
    /// differs from run to run
    #[arg(long)]
    pub latencies: bool,
    /// Milliseconds between poses [hands: 1; bodies: the config's]
    #[arg(long, value_parser = count::<u32>())]
    pub stride_ms: Option<u32>,
    /// Arguments of the task of the checkpoint.
    #[command(flatten)]
    pub own: TaskArgs<Infer>,
    /// Device and threads.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Arguments of `evpose infer` of tasks with cameras and filters.
#[derive(Debug, clap::Args)]
pub(crate) struct PoseInferArgs {
    /// The camera: a calibration file of OpenCV, ROS, kalibr, DSEC, rpg, dv-processing or this project, a name such as
    /// davis346 or evk4, or a vertical field of view such as 45deg [default: 45deg, with a note]
    #[arg(long)]
    pub(crate) camera: Option<String>,
    /// Write poses without the Kalman filter
    #[arg(long)]
    pub(crate) unfiltered: bool,
    /// Precision of the inference: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub(crate) precision: Precision,
}

/// Arguments of `evpose live` of tasks with cameras and compiled networks.
#[derive(Debug, clap::Args)]
pub(crate) struct PoseLiveArgs {
    /// Inputs per call of the network, one of each stride; poses wait for the last one of theirs
    /// [default: 1; hands on other devices than the CPU 16]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) batch: Option<u16>,
    /// The camera: a calibration file of OpenCV, ROS, kalibr, DSEC, rpg, dv-processing or this project, a name such as
    /// davis346 or evk4, or a vertical field of view such as 45deg [default: 45deg, with a note]
    #[arg(long)]
    pub(crate) camera: Option<String>,
    /// Precision of the inference: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub(crate) precision: Precision,
}

/// Arguments of `evpose infer` of tasks that infer from one recording.
#[derive(Debug, clap::Args)]
pub struct OneRecordingArgs {
    /// Recording, in any supported format
    #[arg(long)]
    pub events: PathBuf,
    /// Format of the output, instead of its ending's: `table` (CSV with a header), `json` (an array of the
    /// same names) or `jsonl` (JSON Lines)
    #[arg(long, value_parser = format_of_any_task)]
    pub format: Option<&'static PoseFormat>,
}

/// Formats of people alone.
const OF_BODIES: [&str; 2] = ["hpe-core", "yarp"];

pub(crate) fn written_format(name: &str) -> Result<&'static PoseFormat, String> {
    POSE_FORMATS.find(name).filter(|format| format.is_written()).ok_or_else(|| {
        let written = POSE_FORMATS.iter().filter(|format| format.is_written());
        let known: Vec<&str> = written.map(|format| format.name).collect();
        format!("expected one of {}", known.join(", "))
    })
}

fn format_of_any_task(name: &str) -> Result<&'static PoseFormat, String> {
    match OF_BODIES.contains(&name) {
        true => Err("it is for the task `body`".to_owned()),
        false => written_format(name),
    }
}

/// The format of a file of poses: the given one, or else that of its ending.
///
/// # Errors
/// If it has the ending of no format, or of one that this build does not write.
pub fn format_of(
    given: Option<&'static PoseFormat>,
    path: &Path,
) -> anyhow::Result<&'static PoseFormat> {
    let format = given.map_or_else(|| pose_format_of(path), Ok)?;
    let PoseFormat { name, summary, .. } = format;
    anyhow::ensure!(format.is_written(), "{}: not written as {name}: {summary}", path.display());
    Ok(format)
}

impl InferArgs {
    /// `delay_s` in milliseconds, if latencies are asked for.
    pub(crate) fn latency_ms(&self, delay_s: f64) -> Option<f64> {
        self.latencies.then_some(1e3 * delay_s)
    }
}

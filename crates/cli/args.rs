//! What can be typed.

mod bench;

use std::path::PathBuf;

use clap::{Parser, Subcommand};
use evpose_infer::Precision;
use evpose_io::{Encoding, FrameSource};
use evpose_nn::DeviceKind;
use evpose_sim::Shard;

pub(crate) use self::bench::{
    BenchCommand, BenchInferArgs, BenchIoArgs, BenchReprArgs, BenchSensorArgs, BenchSimArgs,
    BenchTrainArgs,
};
use crate::commands::ablate::AblateCommand;
use crate::commands::calibrate::CalibrateCommand;
use crate::commands::check_labels::CheckLabelsArgs;
use crate::commands::clean::CleanArgs;
use crate::commands::convert::formats;
use crate::commands::gap::GapCommand;
use crate::commands::live::LiveArgs;
use crate::commands::opening::{OpeningArgs, RecordingArgs};
use crate::commands::prepare::PrepareCommand;
use crate::commands::sensor::SensorCommand;
use crate::commands::view::ViewArgs;

/// Pose estimation from event cameras: simulate, train, evaluate, infer.
#[derive(Debug, Parser)]
#[command(
    name = "evpose",
    version,
    arg_required_else_help = true,
    after_help = "Start with:\n  evpose demo\n\nThen, step by step:\n  \
        evpose simulate quick --out data/train\n  \
        evpose simulate quick --out data/test --seed 2 --held-out\n  \
        evpose train quick --data data/train --out runs/hand\n  \
        evpose eval --checkpoint runs/hand --data data/test\n  \
        evpose infer --checkpoint runs/hand --events data/test/0000.evc --out poses.csv"
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What can be done.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Simulate, train, evaluate and report: everything on the embedded default, in minutes
    Demo(DemoArgs),
    /// Record simulated hands or people in front of an event camera, with labels
    Simulate(SimulateArgs),
    /// Turn image sequences into events
    Events(EventsArgs),
    /// Turn data sets of bodies, as distributed, into what is trained on
    #[command(subcommand)]
    Prepare(PrepareCommand),
    /// Look for labels of bodies that are wrong
    CheckLabels(CheckLabelsArgs),
    /// Train a network of hands or bodies
    Train(TrainArgs),
    /// Judge a checkpoint on sequences with known poses
    Eval(EvalArgs),
    /// Poses of a recording
    Infer(InferArgs),
    /// Poses while events come, with their latency
    Live(LiveArgs),
    /// Let a network compute in fewer bits, and measure what that costs
    Quantize(QuantizeArgs),
    /// Write a network as an ONNX file, for other runtimes
    Export(ExportArgs),
    /// Measure speed
    #[command(subcommand)]
    Bench(BenchCommand),
    /// See what event cameras do: presets, effects, one pixel, a gallery
    #[command(subcommand)]
    Sensor(SensorCommand),
    /// Find where simulation and measurement disagree, and what is missing
    #[command(subcommand)]
    Gap(GapCommand),
    /// Thresholds, background rates and hot pixels of a camera, from recordings made for it
    #[command(subcommand)]
    Calibrate(CalibrateCommand),
    /// What each part of a method is worth: everything trained anew without it
    #[command(subcommand)]
    Ablate(AblateCommand),
    /// Say what is in a recording, a hand model, a network, a directory of sequences
    Info(InfoArgs),
    /// Write a recording in another format
    Convert(ConvertArgs),
    /// Check a recording, straighten its lens, remove its noise
    Clean(CleanArgs),
    /// Look at a recording: a page with a slider, a sheet or an animation
    View(ViewArgs),
}

/// A config and changes to it.
#[derive(Debug, clap::Args)]
pub(crate) struct ConfigArgs {
    /// A TOML file, or an embedded config: `quick`, `ablation`, `eventhands` for hands, `pretrain`,
    /// `finetune` for bodies
    pub(crate) config: String,
    /// Change one field, for example --set training.steps=500 (may be repeated)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<String>,
}

/// Where to compute.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct DeviceArgs {
    /// flex (CPU), ndarray, wgpu or cuda; all but flex need the Cargo feature of that name
    #[arg(long, default_value = "flex")]
    pub(crate) device: DeviceKind,
    /// CPU threads; all cores by default
    #[arg(long)]
    pub(crate) threads: Option<usize>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  evpose demo --out runs/first")]
pub(crate) struct DemoArgs {
    /// Directory for data, checkpoints and report [default: a fresh one below runs/]
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
    /// A TOML file, or an embedded config
    #[arg(long, default_value = "quick")]
    pub(crate) config: String,
    /// Change one field, for example --set training.steps=500 (may be repeated)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<String>,
    /// Milliseconds between the poses that are evaluated
    #[arg(long, default_value_t = 5)]
    pub(crate) stride_ms: u32,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose simulate quick --out data/train\n  \
    evpose simulate eventhands --out data/one --sequences 1 --seconds 10 --seed 7\n  \
    evpose simulate quick --out data/train --shard 3/64 --resume\n  \
    evpose simulate quick --condition dark --out data/dark --held-out\n  \
    evpose simulate eventhands --set simulation.motion.variant=bottom --sequences 8 --seconds 3 \
    --out data/bottom --pictures bottom.png\n\n\
    Shards may share a directory or be copied together: the files are those of one run. The last \
    one to finish\nwrites manifest.sha256; `evpose info --verify DIR` and `sha256sum -c` check it. \
    docs/guide/scale.md says more.")]
pub(crate) struct SimulateArgs {
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Directory to write the sequences into
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Length of each sequence in seconds, instead of the config's
    #[arg(long)]
    pub(crate) seconds: Option<f64>,
    /// Number of sequences, instead of the config's
    #[arg(long)]
    pub(crate) sequences: Option<usize>,
    /// Seed, instead of the config's
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Record the held-out set: its number and length of sequences, and seeds of its own
    #[arg(long)]
    pub(crate) held_out: bool,
    /// Record only part I of N of the sequences (I from 1), beside those of other shards
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Keep the sequences that are complete and record the others
    #[arg(long)]
    pub(crate) resume: bool,
    /// A condition to record under (`evpose eval --help` lists them), or a TOML file of one
    #[arg(long)]
    pub(crate) condition: Option<String>,
    /// Also write a PNG file of what the camera looks at, with the events beside it
    #[arg(long, value_name = "FILE")]
    pub(crate) pictures: Option<PathBuf>,
    /// CPU threads; all cores by default. The bytes written do not depend on it
    #[arg(long)]
    pub(crate) threads: Option<usize>,
}

/// Images that light is read from.
#[derive(Debug, clap::Args)]
pub(crate) struct FrameArgs {
    /// A folder of .png or .jpg images (8 or 16 bits, grey or colour, in natural order of their names), or
    /// an .npy array (frames, height, width) of u1, u2, f2, f4 or f8
    #[arg(long)]
    pub(crate) frames: PathBuf,
    /// Frames per second; the first is at time 0
    #[arg(long)]
    pub(crate) fps: f64,
    /// How values stand for light. `linear`: in proportion, as v2e takes them. `srgb`: as on a
    /// display, which is what cameras and video files store
    #[arg(long, default_value = "linear", value_parser = ["linear", "srgb"])]
    pub(crate) encoding: String,
    /// The value of reference white [default: 255 of 8 bits, 65535 of 16 bits, 1 of numbers]
    #[arg(long)]
    pub(crate) white: Option<f64>,
}

impl FrameArgs {
    /// Opens them.
    pub(crate) fn open(&self) -> anyhow::Result<FrameSource> {
        let encoding: Encoding = self.encoding.parse().map_err(anyhow::Error::msg)?;
        Ok(FrameSource::open(&self.frames, encoding, self.white)?)
    }
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose events --frames video/ --fps 120 --encoding srgb --sensor davis346 --out events.npz\n  \
    evpose events --frames frames.npy --fps 1000 --sensor v2e-clean --out events.txt")]
pub(crate) struct EventsArgs {
    #[command(flatten)]
    pub(crate) frames: FrameArgs,
    /// A preset or a TOML file of effects
    #[arg(long)]
    pub(crate) sensor: String,
    /// Where to write the events: .npz, .txt or .evc; how they were made goes to the same name
    /// with .toml behind it
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Steps per frame, between which luminance runs in a line
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) upsample: u32,
    /// Thresholds of every pixel: one .npy (height, width) for ON and OFF, or one each
    #[arg(long, value_name = "FILE.npy", num_args = 1..=2)]
    pub(crate) threshold_map: Vec<PathBuf>,
    /// Seed of fixed patterns and noise
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose train quick --data data/train --out runs/hand\n  \
    evpose train quick --data data/train --out runs/hand --resume\n  \
    evpose train configs/body/pretrain.toml\n  \
    evpose train configs/body/finetune.toml")]
pub(crate) struct TrainArgs {
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Directory of sequences from `evpose simulate`, or of images from `evpose prepare`, or the annotation
    /// file of the latter. Bodies: made in OUT/data where it is missing
    #[arg(long)]
    pub(crate) data: Option<PathBuf>,
    /// Directory of the run [bodies: the config's `out`]
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
    /// A run or a file of weights to start from [bodies: the config's `start_from`]
    #[arg(long, value_name = "RUN")]
    pub(crate) start_from: Option<PathBuf>,
    /// Continue an interrupted run from its newest checkpoint
    #[arg(long)]
    pub(crate) resume: bool,
    /// Plain lines instead of the dashboard, even on a terminal
    #[arg(long)]
    pub(crate) plain: bool,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Conditions:\n  \
    normal      as the network was trained\n  \
    slow        the hand at a tenth of the speed, with rests\n  \
    lit         office light, DAVIS240C\n  \
    dark        a hundredth of the light, same camera\n  \
    night       a thousandth\n  \
    dark-noisy  as dark, with much shot noise\n\n\
    Examples:\n  \
    evpose eval --checkpoint runs/hand --data data/test --json metrics.json\n  \
    evpose eval --checkpoint runs/hand --conditions normal,slow,lit,dark --out runs/conditions")]
pub(crate) struct EvalArgs {
    /// A run directory, or a .bpk file with its .toml beside it
    #[arg(long)]
    pub(crate) checkpoint: PathBuf,
    /// Directory of sequences the network has not seen
    #[arg(long, required_unless_present = "conditions")]
    pub(crate) data: Option<PathBuf>,
    /// Instead: simulate sequences under these conditions (names below, or TOML files), and judge
    /// the slow-motion mode beside the plain pipeline
    #[arg(long, value_delimiter = ',', conflicts_with = "data")]
    pub(crate) conditions: Vec<String>,
    /// Where to write the numbers
    #[arg(long)]
    pub(crate) json: Option<PathBuf>,
    /// Where to keep sequences, numbers and a picture of each condition
    #[arg(long, requires = "conditions")]
    pub(crate) out: Option<PathBuf>,
    /// Sequences of each condition
    #[arg(long, default_value_t = 10, requires = "conditions")]
    pub(crate) sequences: usize,
    /// Length of each sequence of a condition
    #[arg(long, default_value_t = 6.0, requires = "conditions")]
    pub(crate) seconds: f64,
    /// Milliseconds between the poses that are evaluated [hands: 1; bodies: the config's]
    #[arg(long)]
    pub(crate) stride_ms: Option<u32>,
    /// Bodies: also judge poses at 500 Hz, held between those of the network, and carried on by
    /// velocities of events
    #[arg(long)]
    pub(crate) fusion: bool,
    /// Bodies: true and predicted joints over what the network saw, as a PNG file
    #[arg(long, value_name = "FILE")]
    pub(crate) pictures: Option<PathBuf>,
    /// Bodies: draw PCK over its threshold, as an SVG file
    #[arg(long, value_name = "FILE")]
    pub(crate) curves: Option<PathBuf>,
    /// Bits that the network computes in: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub(crate) precision: Precision,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose infer --checkpoint runs/hand \
    --events hand.evc --out poses.csv --joints joints.csv\n  evpose infer --checkpoint runs/hand \
    --events slow.npz --out poses.csv --mode slow-motion")]
pub(crate) struct InferArgs {
    /// A run directory, or a .bpk file with its .toml beside it
    #[arg(long)]
    pub(crate) checkpoint: PathBuf,
    /// Recording, of any format
    #[arg(long)]
    pub(crate) events: PathBuf,
    /// Hands: time and the 12 parameters, a line every millisecond, or for each surface of slow motion.
    /// Bodies: time, delay and 13 joints in pixels, as hpe-core has them
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// `plain`: a pose every millisecond. `slow-motion`: where enough events came, in batches; at
    /// rest the last ones again; smoothed less where the hand is fast
    #[arg(long, default_value = "plain", value_parser = ["plain", "slow-motion"])]
    pub(crate) mode: String,
    /// Time and the 21 evaluated joints in pixels and in metres
    #[arg(long)]
    pub(crate) joints: Option<PathBuf>,
    /// Bodies: milliseconds between poses [the config's]
    #[arg(long)]
    pub(crate) stride_ms: Option<u32>,
    /// Bodies: joints of a lower score are not found
    #[arg(long, default_value_t = 0.01)]
    pub(crate) confidence: f32,
    /// Bodies: also write skeletons as a folder of YARP's
    #[arg(long, value_name = "DIR")]
    pub(crate) skeletons: Option<PathBuf>,
    /// Bodies: also write poses at 500 Hz, carried on between those of the network by velocities of
    /// events
    #[arg(long, value_name = "FILE")]
    pub(crate) fused: Option<PathBuf>,
    /// Write the network's poses as they are, without the Kalman filter
    #[arg(long)]
    pub(crate) unfiltered: bool,
    /// Bits that the network computes in: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub(crate) precision: Precision,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose quantize --checkpoint runs/hand --data data/train \
    --judge data/test\n  evpose infer --checkpoint runs/hand --precision int8 --events hand.evc \
    --out poses.csv\n\nA byte stands for a step between the least and the largest value that a layer \
    was seen to make.\nThese are measured on the data and kept in int8.json beside the checkpoint.")]
pub(crate) struct QuantizeArgs {
    /// A run directory, or a .bpk file with its .toml beside it
    #[arg(long)]
    pub(crate) checkpoint: PathBuf,
    /// Directory of sequences to measure values on: those of the training
    #[arg(long)]
    pub(crate) data: PathBuf,
    /// Windows to measure values on, spread evenly
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) windows: u64,
    /// Directory of sequences the network has not seen, to judge f32, bf16 and int8 on
    #[arg(long)]
    pub(crate) judge: Option<PathBuf>,
    /// Milliseconds between the poses that are judged
    #[arg(long, default_value_t = 20, requires = "judge")]
    pub(crate) stride_ms: u32,
    /// Where to write the numbers
    #[arg(long, requires = "judge")]
    pub(crate) json: Option<PathBuf>,
    /// CPU threads; all cores by default
    #[arg(long, value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose export --checkpoint runs/hand --onnx hand.onnx\n  \
    evpose export eventhands --set network.backbone=mobilenet_v2 --onnx untrained.onnx")]
pub(crate) struct ExportArgs {
    /// A TOML file, or an embedded config: its network with first weights, for the size of its images
    #[arg(required_unless_present = "checkpoint", conflicts_with = "checkpoint")]
    pub(crate) config: Option<String>,
    /// Change one field, for example --set network.width=0.5 (may be repeated)
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "config")]
    pub(crate) overrides: Vec<String>,
    /// A trained network instead: a run directory, or a .bpk file with its .toml beside it
    #[arg(long)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// The file to write
    #[arg(long)]
    pub(crate) onnx: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  evpose info data/train/0000.evc\n  evpose info MANO_RIGHT.pkl\n  \
    evpose info checkpoints/body-quick.bpk\n  \
    evpose info --verify data/train"
)]
pub(crate) struct InfoArgs {
    /// Files: recordings of any format, or hand and body models (.pkl, .npz), recognised by content;
    /// directories of sequences
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Read every file of a directory of sequences and compare it with its digest
    #[arg(long)]
    pub(crate) verify: bool,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
}

#[derive(Debug, clap::Args)]
#[command(after_help = format!("Examples:\n  evpose convert rec.aedat4 rec.npz\n  \
    evpose convert rec.raw part.txt --from 1.5 --to 2 --zero-time\n  \
    evpose convert rec.txt rec.raw --format evt2 --sensor 640x480\n\n{}", formats()))]
pub(crate) struct ConvertArgs {
    #[command(flatten)]
    pub(crate) recording: RecordingArgs,
    /// File to write; its ending says the format, unless --format does
    pub(crate) out: PathBuf,
    /// Name of the format to write
    #[arg(long)]
    pub(crate) format: Option<String>,
    /// Begin so many seconds after the first event
    #[arg(long, value_name = "SECONDS")]
    pub(crate) from: Option<f64>,
    /// End so many seconds after the first event
    #[arg(long, value_name = "SECONDS")]
    pub(crate) to: Option<f64>,
    /// Let time begin at 0 with the first event, or with --from
    #[arg(long)]
    pub(crate) zero_time: bool,
}

/// A number of threads.
fn parse_threads(text: &str) -> Result<usize, String> {
    let threads = text.parse().map_err(|error| format!("{error}"))?;
    if threads == 0 { Err("at least 1".to_owned()) } else { Ok(threads) }
}

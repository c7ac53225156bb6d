//! Arguments of the commands whose work is the task's.

use std::path::PathBuf;

use evpose_app::args::{ConfigArgs, DeviceArgs};
use evpose_infer::Precision;
use evpose_sim::Shard;

/// Arguments of `evpose simulate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose simulate quick --out data/train\n  \
    evpose simulate eventhands --out data/one --sequences 1 --seconds 10 --seed 7\n  \
    evpose simulate quick --out data/train --shard 3/64 --resume\n  \
    evpose simulate quick --condition dark --out data/dark --held-out\n  \
    evpose simulate eventhands --set simulation.motion.variant=bottom --sequences 8 --seconds 3 \
    --out data/bottom --preview bottom.png\n\n\
    Shards may share a directory or be copied together: the files are those of one run. The last \
    one to finish\nwrites manifest.sha256; `evpose info --verify DIR` and `sha256sum -c` check it. \
    docs/guide/scale.md says more.")]
pub struct SimulateArgs {
    /// Config and overrides.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Directory to write the sequences into
    #[arg(long)]
    pub out: PathBuf,
    /// Length of each sequence in seconds, instead of the config's
    #[arg(long)]
    pub seconds: Option<f64>,
    /// Number of sequences, instead of the config's
    #[arg(long)]
    pub sequences: Option<usize>,
    /// Seed, instead of the config's
    #[arg(long)]
    pub seed: Option<u64>,
    /// Record the held-out set: its number and length of sequences, and seeds of its own
    #[arg(long)]
    pub held_out: bool,
    /// Record only part I of N of the sequences (I from 1), beside those of other shards
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Keep the sequences that are complete and record the others
    #[arg(long)]
    pub resume: bool,
    /// A condition to record under (`evpose eval --help` lists them), or a TOML file of one
    #[arg(long)]
    pub condition: Option<String>,
    /// Also write a PNG file of what the camera looks at, with the events beside it
    #[arg(long, alias = "pictures", value_name = "FILE")]
    pub preview: Option<PathBuf>,
    /// CPU threads; all cores by default. The bytes written do not depend on it
    #[arg(long)]
    pub threads: Option<usize>,
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
    /// Directory of sequences from `evpose simulate`, or of images from `evpose prepare`, or the annotation
    /// file of the latter. Bodies: made in OUT/data where it is missing
    #[arg(long)]
    pub data: Option<PathBuf>,
    /// Directory of the run [bodies: the config's `out`]
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// A run or a file of weights to start from [bodies: the config's `start_from`]
    #[arg(long, value_name = "RUN")]
    pub start_from: Option<PathBuf>,
    /// Continue an interrupted run from its newest checkpoint
    #[arg(long)]
    pub resume: bool,
    /// Plain lines instead of the dashboard, even on a terminal
    #[arg(long)]
    pub plain: bool,
    /// Device and threads.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Arguments of `evpose eval`.
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
pub struct EvalArgs {
    /// A run directory, or a .bpk file with its .toml beside it
    #[arg(long)]
    pub checkpoint: PathBuf,
    /// Directory of sequences the network has not seen
    #[arg(long, required_unless_present = "conditions")]
    pub data: Option<PathBuf>,
    /// Instead: simulate sequences under these conditions (names below, or TOML files), and judge
    /// the slow-motion mode beside the plain pipeline
    #[arg(long, value_delimiter = ',', conflicts_with = "data")]
    pub conditions: Vec<String>,
    /// Where to write the numbers
    #[arg(long)]
    pub json: Option<PathBuf>,
    /// Where to keep sequences, numbers and a picture of each condition
    #[arg(long, requires = "conditions")]
    pub out: Option<PathBuf>,
    /// Sequences of each condition
    #[arg(long, default_value_t = 10, requires = "conditions")]
    pub sequences: usize,
    /// Length of each sequence of a condition
    #[arg(long, default_value_t = 6.0, requires = "conditions")]
    pub seconds: f64,
    /// Milliseconds between the poses that are evaluated [hands: 1; bodies: the config's]
    #[arg(long)]
    pub stride_ms: Option<u32>,
    /// Bodies: also judge poses at 500 Hz, held between those of the network, and carried on by
    /// velocities of events
    #[arg(long)]
    pub fusion: bool,
    /// Bodies: true and predicted joints over what the network saw, as a PNG file
    #[arg(long, value_name = "FILE")]
    pub pictures: Option<PathBuf>,
    /// Bodies: draw PCK over its threshold, as an SVG file
    #[arg(long, value_name = "FILE")]
    pub curves: Option<PathBuf>,
    /// Bits that the network computes in: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub precision: Precision,
    /// Device and threads.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Arguments of `evpose infer`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose infer --checkpoint runs/hand \
    --events hand.evc --out poses.csv --joints joints.csv\n  evpose infer --checkpoint runs/hand \
    --events slow.npz --out poses.csv --mode slow-motion")]
pub struct InferArgs {
    /// A run directory, or a .bpk file with its .toml beside it
    #[arg(long)]
    pub checkpoint: PathBuf,
    /// Recording, of any format
    #[arg(long)]
    pub events: PathBuf,
    /// Hands: time and the 12 parameters, a line every millisecond, or for each surface of slow motion.
    /// Bodies: time, delay and 13 joints in pixels, as hpe-core has them
    #[arg(long)]
    pub out: PathBuf,
    /// `plain`: a pose every millisecond. `slow-motion`: where enough events came, in batches; at
    /// rest the last ones again; smoothed less where the hand is fast
    #[arg(long, default_value = "plain", value_parser = ["plain", "slow-motion"])]
    pub mode: String,
    /// Time and the 21 evaluated joints in pixels and in metres
    #[arg(long)]
    pub joints: Option<PathBuf>,
    /// Bodies: milliseconds between poses [the config's]
    #[arg(long)]
    pub stride_ms: Option<u32>,
    /// Bodies: joints of a lower score are not found
    #[arg(long, default_value_t = 0.01)]
    pub confidence: f32,
    /// Bodies: also write skeletons as a folder of YARP's
    #[arg(long, value_name = "DIR")]
    pub skeletons: Option<PathBuf>,
    /// Bodies: also write poses at 500 Hz, carried on between those of the network by velocities of
    /// events
    #[arg(long, value_name = "FILE")]
    pub fused: Option<PathBuf>,
    /// Write the network's poses as they are, without the Kalman filter
    #[arg(long)]
    pub unfiltered: bool,
    /// Bits that the network computes in: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub precision: Precision,
    /// Device and threads.
    #[command(flatten)]
    pub device: DeviceArgs,
}

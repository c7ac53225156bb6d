//! Arguments of the commands that tasks implement.

use std::path::{Path, PathBuf};

use crate::args::{ConfigArgs, DeviceArgs};
use evpose_infer::Precision;
use evpose_io::poses::{POSE_FORMATS, PoseFormat, pose_format_by_name};
use evpose_pose::body::JointDefinition;
use evpose_sim::Shard;
use evpose_train::TrainOptions;

use crate::tasks::opening::OpeningArgs;

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
    #[arg(long)]
    pub seconds: Option<f64>,
    /// Number of sequences, instead of the config's
    #[arg(long)]
    pub sequences: Option<usize>,
    /// Format of the events, instead of the config's: a name of `evpose convert --help`, or an ending
    /// such as raw, h5 or aedat4 [default: people raw; hands evc, and raw of more than 256 rows]
    #[arg(long)]
    pub format: Option<String>,
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
    /// A condition to record under (`evpose eval --help` lists them), or a TOML file of one
    #[arg(long)]
    pub condition: Option<String>,
    /// Also write a PNG file of rendered frames and their events side by side
    #[arg(long, value_name = "FILE")]
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
    /// Directory of sequences from `evpose simulate`, or of images from `evpose prepare`, or the
    /// annotation file of the latter; for bodies it may be repeated, and the last sequences are for
    /// validation [bodies: simulated into OUT/data where it is missing]
    #[arg(long)]
    pub data: Vec<PathBuf>,
    /// Directory of the run [bodies: the config's `out`]
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// A run, a file of weights, or the name of a shipped network to start from [default: the config's
    /// `start_from`]
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

impl SimulateArgs {
    /// Refuses the arguments that not every task has.
    ///
    /// # Errors
    /// If one of them was given.
    pub fn refuse_others(&self, task: &str) -> anyhow::Result<()> {
        let Self { format, condition, preview, .. } = self;
        refuse(
            task,
            &[
                ("--format", format.is_some()),
                ("--condition", condition.is_some()),
                ("--preview", preview.is_some()),
            ],
        )
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
    /// Also evaluate on recordings from outside of this simulator (other meshes, motions, renderers and
    /// pixels): hands or bodies of this directory
    #[arg(
        long, value_name = "DIR", num_args = 0..=1, default_missing_value = "datasets/development",
        conflicts_with = "conditions"
    )]
    pub foreign: Option<PathBuf>,
    /// The camera of --data: a calibration file of OpenCV, ROS, dv-processing or this project, a name
    /// such as `davis346`, or a vertical field of view such as `60deg` [default: that of the
    /// simulation, or a guess]
    #[arg(long, value_name = "CAMERA", requires = "data")]
    pub camera: Option<String>,
    /// Hands: simulate sequences under these conditions instead (names below, or TOML files), and
    /// compare the slow-motion mode with the plain pipeline
    #[arg(long, value_delimiter = ',', conflicts_with = "data")]
    pub conditions: Vec<String>,
    /// Where to write the metrics as JSON
    #[arg(long)]
    pub json: Option<PathBuf>,
    /// Where to keep the sequences, metrics and a figure of each condition
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
    /// Bodies: also evaluate poses at 500 Hz, held constant after each inference, and propagated by
    /// velocities from events
    #[arg(long)]
    pub fusion: bool,
    /// Bodies, on annotated images: also evaluate joints where the labels of `dhp19` put them: the
    /// head's on top of it, the hips' on the crest of the pelvis
    #[arg(long, value_name = "SET", value_parser = joint_definition)]
    pub joints: Option<JointDefinition>,
    /// Draw true and predicted joints over inputs of the network, as a PNG file; of hands, those of
    /// `--foreign`
    #[arg(long, value_name = "FILE")]
    pub preview: Option<PathBuf>,
    /// Bodies: plot PCK against its threshold, as an SVG file
    #[arg(long, value_name = "FILE")]
    pub curves: Option<PathBuf>,
    /// Precision of the inference: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub precision: Precision,
    /// Device and threads.
    #[command(flatten)]
    pub device: DeviceArgs,
}

fn joint_definition(set: &str) -> Result<JointDefinition, String> {
    match set {
        "dhp19" => Ok(JointDefinition::Dhp19),
        _ => Err("there is `dhp19`".to_owned()),
    }
}

impl EvalArgs {
    /// The same without files to write.
    #[must_use]
    pub fn without_outputs(&self) -> Self {
        Self { json: None, preview: None, curves: None, ..self.clone() }
    }

    /// Refuses the arguments that not every task has.
    ///
    /// # Errors
    /// If one of them was given.
    pub fn refuse_others(&self, task: &str) -> anyhow::Result<()> {
        refuse(
            task,
            &[
                ("--foreign", self.foreign.is_some()),
                ("--camera", self.camera.is_some()),
                ("--conditions", !self.conditions.is_empty()),
                ("--fusion", self.fusion),
                ("--joints", self.joints.is_some()),
                ("--preview", self.preview.is_some()),
                ("--curves", self.curves.is_some()),
                ("--precision", self.precision != Precision::F32),
            ],
        )
    }
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
    /// Recording, in any supported format; bodies: several, of calibrated cameras with one clock, for
    /// joints in the world
    #[arg(long, num_args = 1.., required = true)]
    pub events: Vec<PathBuf>,
    /// Bodies: the calibrated cameras of several recordings, a TOML file with a `[[camera]]` for each
    /// [default: the metadata that `evpose simulate` writes beside each]
    #[arg(long, value_name = "FILE")]
    pub cameras: Option<PathBuf>,
    /// Sensor, camera of the file, ticks, damage.
    #[command(flatten)]
    pub opening: OpeningArgs,
    /// Output: a line for each pose with its time stamp in microseconds, score, and joints by name in
    /// pixels of the sensor; of hands also 12 parameters, and joints in metres in the camera's frame
    #[arg(long)]
    pub out: PathBuf,
    /// Format of the output: `table` (CSV with a header), `json` (JSON Lines of the same names), or, of
    /// bodies, `hpe-core` or `yarp` (a folder)
    #[arg(long, default_value = "table", value_parser = written_format)]
    pub format: &'static PoseFormat,
    /// The camera: a calibration file of OpenCV, ROS, dv-processing or this project, a name such as
    /// davis346 or evk4, or a vertical field of view such as 45deg [default: 45deg, with a note]
    #[arg(long)]
    pub camera: Option<String>,
    /// Hands: `plain` infers every millisecond; `slow-motion` infers in batches once enough events
    /// have arrived, repeats the last poses of a hand at rest, and smooths a fast hand less
    #[arg(long, default_value = "plain", value_parser = ["plain", "slow-motion"])]
    pub mode: String,
    /// Hands: also write a table of the joints alone, without parameters
    #[arg(long)]
    pub joints: Option<PathBuf>,
    /// Milliseconds between poses [hands: 1; bodies: the config's]
    #[arg(long)]
    pub stride_ms: Option<u32>,
    /// Bodies: images per call of the network; hands have 64 [default: 1 on the CPU, 16 on other devices]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub batch: Option<u16>,
    /// Bodies: minimum score of a pose and of a joint, 0 to 1; below it, positions are empty [poses and
    /// joints: the checkpoint's]
    #[arg(long, value_name = "SCORE", value_parser = score)]
    pub min_score: Option<f32>,
    /// Bodies: minimum score of a joint in the decoder of the network [the checkpoint's]
    #[arg(long)]
    pub confidence: Option<f32>,
    /// Bodies: also write skeletons as a YARP folder
    #[arg(long, value_name = "DIR")]
    pub skeletons: Option<PathBuf>,
    /// Bodies: also write poses at 500 Hz, propagated from each inference by velocities from events
    #[arg(long, value_name = "FILE")]
    pub fused: Option<PathBuf>,
    /// Write poses without the Kalman filter
    #[arg(long)]
    pub unfiltered: bool,
    /// Precision of the inference: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub precision: Precision,
    /// Device and threads.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Parses the name of a format of poses that can be written.
fn written_format(name: &str) -> Result<&'static PoseFormat, String> {
    pose_format_by_name(name).filter(|format| format.is_written()).ok_or_else(|| {
        let written = POSE_FORMATS.iter().filter(|format| format.is_written());
        let known: Vec<&str> = written.map(|format| format.name).collect();
        format!("expected one of {}", known.join(", "))
    })
}

/// Parses a score.
///
/// # Errors
/// If it is not a value from 0 to 1.
pub fn score(text: &str) -> Result<f32, String> {
    let score = text.parse().ok().filter(|score| (0.0..=1.0).contains(score));
    score.ok_or_else(|| "expected a score from 0 to 1".to_owned())
}

/// Refuses arguments of other tasks, each by its name and whether it was given.
pub(crate) fn refuse(task: &str, others: &[(&str, bool)]) -> anyhow::Result<()> {
    match others.iter().find(|(_, is_given)| *is_given) {
        Some((name, _)) => anyhow::bail!("{name} is not for the task `{task}`"),
        None => Ok(()),
    }
}

impl InferArgs {
    /// Refuses the arguments that not every task has.
    ///
    /// # Errors
    /// If one of them was given.
    pub fn refuse_others(&self, task: &str) -> anyhow::Result<()> {
        refuse(
            task,
            &[
                ("--camera", self.camera.is_some()),
                ("--mode", self.mode != "plain"),
                ("--joints", self.joints.is_some()),
                ("--batch", self.batch.is_some()),
                ("--min-score", self.min_score.is_some()),
                ("--confidence", self.confidence.is_some()),
                ("--skeletons", self.skeletons.is_some()),
                ("--fused", self.fused.is_some()),
                ("--precision", self.precision != Precision::F32),
            ],
        )
    }

    /// The only recording.
    ///
    /// # Errors
    /// If there are several.
    pub fn recording(&self) -> anyhow::Result<&Path> {
        match &self.events[..] {
            [one] if self.cameras.is_none() => Ok(one),
            _ => {
                anyhow::bail!("one recording is expected: several, with --cameras, are for bodies")
            }
        }
    }
}

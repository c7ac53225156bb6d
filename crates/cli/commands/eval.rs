//! `evpose eval`.

use std::path::Path;

use anyhow::{Context, Result, bail};
use burn::tensor::Device;
use evpose_pose::metric::MeanPose;
use evpose_task::hand::HandCheckpoint;
use evpose_train::HandDataset;

use super::{body, conditions};
use evpose_app::args::DeviceArgs;
use evpose_app::progress::say;
use evpose_app::{body_checkpoint, hand_predictor};
use evpose_infer::Precision;
use evpose_report::held_out;
use std::path::PathBuf;

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

pub(crate) fn run(args: &EvalArgs) -> Result<()> {
    if let Some(checkpoint) = body_checkpoint::checkpoint(&args.checkpoint, &Device::flex())? {
        return body::eval(&checkpoint, args);
    }
    if args.fusion || args.curves.is_some() || args.pictures.is_some() {
        bail!("--fusion, --curves and --pictures are for bodies");
    }
    match &args.data {
        Some(data) => judge(args, data),
        None => conditions::run(args),
    }
}

/// Judges on sequences that are there.
fn judge(args: &EvalArgs, data: &Path) -> Result<()> {
    let device = args.device.open()?;
    let checkpoint = HandCheckpoint::load(&args.checkpoint, &device)?;
    let config = checkpoint.config;
    let data = HandDataset::open(data, &config)?;
    // The checkpoint knows the mean of what it was trained on; foreign weights do not, and are
    // held against the mean of the very data they are judged on, which is harder to beat.
    let mean = match checkpoint.mean_pose {
        Some(mean) => mean,
        None => {
            let mut mean = MeanPose::default();
            data.poses(100_000)?.iter().for_each(|pose| mean.push(pose));
            mean.mean().context("no poses to average")?
        }
    };
    let network = checkpoint.network;
    let trained =
        hand_predictor::predictor(&args.checkpoint, network, args.precision, device.clone())?;
    let judged = held_out::evaluate_with_baselines(
        &config,
        &data,
        trained,
        mean,
        &device,
        args.stride_ms.unwrap_or(1),
    )?;
    held_out::print(&config, &judged);
    if let Some(path) = &args.json {
        judged.metrics.write(path)?;
        say(format!("written to {}", path.display()));
    }
    Ok(())
}

//! `evpose eval`.

use std::path::Path;

use anyhow::{Context, Result, bail};
use burn::tensor::Device;
use evpose_pose::metric::MeanPose;
use evpose_train::{Checkpoint, HandDataset};

use super::{body, conditions, device, held_out, quantize};
use crate::args::EvalArgs;
use crate::progress::say;

pub(crate) fn run(args: &EvalArgs) -> Result<()> {
    if let Some(checkpoint) = body::checkpoint(&args.checkpoint, &Device::flex())? {
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
    let device = device(&args.device)?;
    let checkpoint = Checkpoint::load(&args.checkpoint, &device)?;
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
    let trained = quantize::predictor(&args.checkpoint, network, args.precision, device.clone())?;
    let judged =
        held_out::judge(&config, &data, trained, mean, &device, args.stride_ms.unwrap_or(1))?;
    held_out::print(&config, &judged);
    if let Some(path) = &args.json {
        judged.metrics.write(path)?;
        say(format!("written to {}", path.display()));
    }
    Ok(())
}

//! `evpose eval` of hands.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_app::progress::say;
use evpose_pose::metric::MeanPose;
use evpose_report::held_out;
use evpose_train::HandDataset;

use super::HandModel;
use crate::args::EvalArgs;

/// Evaluates a model on the sequences of a directory.
pub(super) fn run(model: &HandModel, args: &EvalArgs, data: &Path) -> Result<()> {
    let checkpoint = &model.checkpoint;
    let config = &checkpoint.config;
    let data = HandDataset::open(data, config)?;
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
    let trained = model.predictor(args.precision)?;
    let judged = held_out::evaluate_with_baselines(
        config,
        &data,
        trained,
        mean,
        &model.device,
        args.stride_ms.unwrap_or(1),
    )?;
    held_out::print(config, &judged);
    if let Some(path) = &args.json {
        judged.metrics.write(path)?;
        say(format!("written to {}", path.display()));
    }
    Ok(())
}

//! `evpose eval` of hands.

use std::path::Path;

use crate::pages::held_out;
use crate::progress::say;
use anyhow::{Context, Result};
use evpose_pose::metric::MeanPose;
use evpose_train::HandDataset;

use super::HandNetwork;
use crate::tasks::args::{EvalArgs, PoseEvalArgs};

/// Evaluates a model on the sequences of a directory.
pub(super) fn run(
    model: &HandNetwork,
    args: &EvalArgs,
    own: &PoseEvalArgs,
    data: &Path,
) -> Result<()> {
    let checkpoint = &model.checkpoint;
    let config = &checkpoint.config;
    let data = HandDataset::open_of_camera(data, config, own.camera.as_deref())?;
    if let Some(note) = data.note() {
        say(format!("note: {note}"));
    }
    // Imported weights carry no mean pose of their training data. They are compared with the mean of the test
    // data, which is a stronger baseline.
    let mean = match checkpoint.mean_pose {
        Some(mean) => mean,
        None => {
            let mut mean = MeanPose::default();
            data.poses(100_000)?.iter().for_each(|pose| mean.push(pose));
            mean.mean().context("no poses to average")?
        }
    };
    let trained = model.predictor(own.precision)?;
    let evaluated = held_out::evaluate_with_baselines(
        config,
        &data,
        trained,
        mean,
        &model.device,
        args.stride_ms.unwrap_or(1),
    )?;
    held_out::print(config, &evaluated);
    if let Some(path) = &args.json {
        evaluated.metrics.write(path)?;
        say(format!("written to {}", path.display()));
    }
    Ok(())
}

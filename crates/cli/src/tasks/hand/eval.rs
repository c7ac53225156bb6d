//! `evpose eval` of hands.

use std::path::Path;

use crate::json::write_result;
use crate::pages::held_out;
use crate::progress::say;
use anyhow::Result;
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
    let config = &model.checkpoint.config;
    let data = HandDataset::open_of_camera(data, config, own.camera.as_deref())?;
    if let Some(note) = data.note() {
        say(format!("note: {note}"));
    }
    let trained = model.predictor(own.precision)?;
    let evaluated = held_out::evaluate_with_baselines(
        config,
        &data,
        trained,
        model.mean_pose(&data)?,
        &model.device,
        args.stride_ms.unwrap_or(1),
    )?;
    held_out::print(config, &evaluated);
    if let Some(path) = &args.json {
        write_result(path, &evaluated.metrics)?;
        say(format!("written to {}", path.display()));
    }
    Ok(())
}

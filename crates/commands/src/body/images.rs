//! `evpose eval` of bodies on images with annotations: EROS images of others, for example.

use std::path::Path;

use anyhow::{Result, bail};
use evpose_app::json::write_json;
use evpose_app::machine::Machine;
use evpose_app::progress::{bar, say};
use evpose_app::run_info::COMMIT;
use evpose_core::Micros;
use evpose_pose::metric::body::BodySummary;
use evpose_report::people;
use evpose_task::body::{BodyPredictorOptions, BodySourceKind};
use evpose_train::body::{BodyFrames, evaluate_frames};
use serde::Serialize;

use super::BodyModel;
use super::eval::{PERCENTS, print};
use crate::args::EvalArgs;

/// Results, as written to JSON.
#[derive(Debug, Serialize)]
struct ImageReport {
    machine: Machine,
    commit: &'static str,
    images: usize,
    network: BodySummary,
    mean_pose: BodySummary,
}

pub(super) fn run(model: &BodyModel, args: &EvalArgs, data: &Path) -> Result<()> {
    if args.fusion {
        bail!("--fusion is for recordings: images have no events");
    }
    let checkpoint = &model.checkpoint;
    let mut config = checkpoint.config.clone();
    config.data.source = BodySourceKind::Annotations;
    config.data.min_joints = 1;
    let progress = bar("reading", 0, "images");
    let mut frames = BodyFrames::load(&config, data, &|count| progress.inc(count))?;
    progress.finish_and_clear();
    // Images are evaluated one by one, whether or not they are of one clip.
    for (index, frame) in frames.frames.iter_mut().enumerate() {
        frame.sequence = index as u64;
        // Not in the part of a sequence that the protocol leaves out.
        frame.t = Micros::SECOND;
    }
    let options =
        BodyPredictorOptions { precision: args.precision, ..BodyPredictorOptions::default() };
    let predictor = model.predictor(options)?;
    let mean = checkpoint.mean_pose.unwrap_or_else(|| frames.mean_pose());
    let (network, mean_pose) = evaluate_frames(&predictor, &frames, &mean)?;
    let bootstrap = &checkpoint.config.evaluation.bootstrap;
    let report = ImageReport {
        machine: Machine::this(),
        commit: COMMIT,
        images: frames.len(),
        network: network.summary(&PERCENTS, bootstrap)?,
        mean_pose: mean_pose.summary(&PERCENTS, bootstrap)?,
    };
    say(format!("{} images of {}", report.images, data.display()));
    print("network", &report.network.raw);
    print("mean pose", &report.mean_pose.raw);
    if let Some(path) = &args.preview {
        people::of_frames(&predictor, &frames, path)?;
    }
    write_json(args.json.as_deref(), &report)
}

//! `evpose eval` of bodies on images with annotations: EROS images of others, for example.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use evpose_app::json::write_json;
use evpose_app::machine::Machine;
use evpose_app::progress::{bar, say};
use evpose_app::run_info::COMMIT;
use evpose_core::Micros;
use evpose_pose::metric::body::{BodyEvaluation, BodySequence, BodySummary};
use evpose_report::people;
use evpose_task::body::{BodyPredictorOptions, BodySourceKind};
use evpose_train::body::{BodyFrames, evaluate_frames, holds_annotations};
use serde::Serialize;

use super::BodyModel;
use super::eval::{PERCENTS, RecordingScores, print};
use crate::args::EvalArgs;

/// Results, as written to JSON.
#[derive(Debug, Serialize)]
struct ImageReport {
    machine: Machine,
    commit: &'static str,
    images: usize,
    /// Of several clips, intervals are over clips.
    network: BodySummary,
    mean_pose: BodySummary,
    /// The network's scores on each clip.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    recordings: Vec<RecordingScores>,
}

/// Directories of annotated images: `data`, or those in it, by name.
pub(super) fn clips(data: &Path) -> Vec<PathBuf> {
    if holds_annotations(data) {
        return vec![data.to_owned()];
    }
    let entries = data.read_dir().into_iter().flatten().flatten();
    let mut clips: Vec<PathBuf> =
        entries.map(|entry| entry.path()).filter(|path| holds_annotations(path)).collect();
    clips.sort();
    clips
}

/// Evaluates a model on the images of clips.
pub(super) fn run(model: &BodyModel, args: &EvalArgs, clips: &[PathBuf]) -> Result<()> {
    if args.fusion {
        bail!("--fusion is for recordings: images have no events");
    }
    let bootstrap = &model.checkpoint.config.evaluation.bootstrap;
    let mut images = 0;
    let mut both = [BodyEvaluation::default(), BodyEvaluation::default()];
    let mut recordings = Vec::new();
    for clip in clips {
        let (count, evaluations) = evaluate(model, args, clip)?;
        images += count;
        if clips.len() == 1 {
            both = evaluations;
            continue;
        }
        for (all, clip) in both.iter_mut().zip(&evaluations) {
            all.sequences.push(as_one(clip));
        }
        recordings.push(RecordingScores {
            file: clip.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            scores: evaluations[0].summary(&PERCENTS, bootstrap)?.raw,
        });
    }
    let [network, mean_pose] = both.map(|evaluation| evaluation.summary(&PERCENTS, bootstrap));
    let report = ImageReport {
        machine: Machine::this(),
        commit: COMMIT,
        images,
        network: network?,
        mean_pose: mean_pose?,
        recordings,
    };
    say(format!("{images} images"));
    print("network", &report.network.raw);
    print("mean pose", &report.mean_pose.raw);
    report.recordings.iter().for_each(|clip| print(&clip.file, &clip.scores));
    write_json(args.json.as_deref(), &report)
}

/// The images of a clip as one sequence.
fn as_one(images: &BodyEvaluation) -> BodySequence {
    let mut one = BodySequence::default();
    for image in &images.sequences {
        one.raw.merge(&image.raw);
        one.resampled.merge(&image.resampled);
    }
    one
}

/// The number of images of a clip, and the scores of the network and of the mean pose on each.
fn evaluate(
    model: &BodyModel,
    args: &EvalArgs,
    data: &Path,
) -> Result<(usize, [BodyEvaluation; 2])> {
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
    if let Some(path) = &args.preview {
        people::of_frames(&predictor, &frames, path)?;
    }
    let (network, mean_pose) = evaluate_frames(&predictor, &frames, &mean)?;
    Ok((frames.len(), [network, mean_pose]))
}

//! `evpose eval` of bodies on images with annotations: EROS images of others, for example.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::json::write_json;
use crate::pages::people;
use crate::progress::{bar, say};
use crate::provenance::Provenance;
use anyhow::{Result, bail};
use evpose_core::Micros;
use evpose_pose::PoseError;
use evpose_pose::body::BodyPoints;
use evpose_pose::body::fusion::ScoredPoints;
use evpose_pose::filter::BodyFilter;
use evpose_pose::metric::body::{BodyEvaluation, BodyPrediction, BodySequence, BodySummary};
use evpose_task::body::{BodyPredictorOptions, BodySourceKind};
use evpose_train::body::{
    BodyFrame, BodyFrames, evaluate_frames, evaluate_frames_with, holds_annotations,
};
use serde::Serialize;

use super::BodyNetwork;
use super::args::BodyEvalArgs;
use super::eval::{PERCENTS, RecordingScores, print};
use crate::tasks::args::EvalArgs;

/// Interval that images of a clip without time stamps are taken to have: what video has.
const UNTIMED: Micros = Micros(33_333);

/// Results, as written to JSON.
#[derive(Debug, Serialize)]
struct ImageReport {
    #[serde(flatten)]
    provenance: Provenance,
    images: usize,
    /// Of several clips, intervals are over clips.
    network: BodySummary,
    /// The network's joints through the temporal filter, clip by clip.
    filtered: BodySummary,
    mean_pose: BodySummary,
    /// The network's joints where the labels of another set put them.
    #[serde(skip_serializing_if = "Option::is_none")]
    placed: Option<BodySummary>,
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
pub(super) fn run(
    model: &BodyNetwork,
    args: &EvalArgs,
    own: &BodyEvalArgs,
    clips: &[PathBuf],
) -> Result<()> {
    if own.fusion {
        bail!("--fusion is for recordings: images have no events");
    }
    let provenance = Provenance::this();
    let bootstrap = &model.checkpoint.config.evaluation.bootstrap;
    let mut images = 0;
    let mut all: [BodyEvaluation; 4] = Default::default();
    let mut recordings = Vec::new();
    for clip in clips {
        let (count, evaluations) = evaluate(model, own, clip)?;
        images += count;
        if clips.len() == 1 {
            all = evaluations;
            continue;
        }
        for (all, clip) in all.iter_mut().zip(&evaluations) {
            // Intervals are over clips, since images of one clip look alike; a single clip has only images.
            all.sequences.push(as_one(clip));
        }
        recordings.push(RecordingScores {
            file: clip.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            scores: evaluations[0].summary(&PERCENTS, bootstrap)?.raw,
        });
    }
    let [network, filtered, mean_pose, placed] = all;
    let summary = |evaluation: BodyEvaluation| evaluation.summary(&PERCENTS, bootstrap);
    let report = ImageReport {
        provenance,
        images,
        network: summary(network)?,
        filtered: summary(filtered)?,
        mean_pose: summary(mean_pose)?,
        placed: own.joints.map(|_| summary(placed)).transpose()?,
        recordings,
    };
    say(format!("{images} images"));
    print("network", &report.network.raw);
    print("filtered", &report.filtered.raw);
    print("mean pose", &report.mean_pose.raw);
    if let Some(placed) = &report.placed {
        print("as labels", &placed.raw);
    }
    report.recordings.iter().for_each(|clip| print(&clip.file, &clip.scores));
    write_json(args.json.as_deref(), &report)
}

fn as_one(images: &BodyEvaluation) -> BodySequence {
    let mut one = BodySequence::default();
    for image in &images.sequences {
        one.raw.merge(&image.raw);
        one.resampled.merge(&image.resampled);
    }
    one
}

/// The number of images of a clip, and the scores of the network, through the filter, of the mean pose
/// and of the network as `--joints` says on each.
fn evaluate(
    model: &BodyNetwork,
    own: &BodyEvalArgs,
    data: &Path,
) -> Result<(usize, [BodyEvaluation; 4])> {
    let checkpoint = &model.checkpoint;
    let mut config = checkpoint.config.clone();
    config.data.source = BodySourceKind::Annotations;
    // An image with a single labelled joint can be scored, whatever a training demands.
    config.data.min_joints = 1;
    let progress = bar("reading", 0, "images");
    let mut frames = BodyFrames::load(&config, data, &|count| progress.inc(count))?;
    progress.finish_and_clear();
    let times = times(&frames);
    // Images are evaluated one by one, whether or not they are of one clip.
    for (index, frame) in frames.frames.iter_mut().enumerate() {
        frame.sequence = index as u64;
        // Not in the part of a sequence that the protocol leaves out.
        frame.t = Micros::SECOND;
    }
    let options = BodyPredictorOptions {
        precision: own.own.precision,
        consensus: own.consensus,
        ..BodyPredictorOptions::default()
    };
    let predictor = model.predictor(options)?;
    let mean = checkpoint.mean_pose.unwrap_or_else(|| frames.mean_pose());
    if let Some(path) = &own.preview {
        people::of_frames(&predictor, &frames, path)?;
    }
    let predicted: Vec<OnceLock<ScoredPoints>> = vec![OnceLock::new(); frames.len()];
    let observe = |frame: &BodyFrame, pose: &ScoredPoints| {
        // Sequences are numbers of images, and each is predicted once.
        let _ = predicted[frame.sequence as usize].set(*pose);
    };
    let (network, mean_pose) = evaluate_frames(&predictor, &frames, &mean, &observe)?;
    let mut filter = BodyFilter::new(checkpoint.config.filter)?;
    let mut sequence = None;
    let filtered: Vec<BodyPoints> = times
        .iter()
        .zip(&predicted)
        .map(|((own, t), pose)| {
            // The filter must not go on from the last image of a clip to the first of the next.
            if sequence.replace(*own) != Some(*own) {
                filter.reset();
            }
            pose.get().map_or_else(BodyPoints::default, |pose| filter.update(*t, pose))
        })
        .collect();
    let filtered = of_points(&frames, &filtered)?;
    let placed = match own.joints {
        Some(definition) => {
            let of = |pose: &OnceLock<ScoredPoints>| {
                pose.get().map(|pose| definition.place(&pose.points))
            };
            let joints: Vec<BodyPoints> =
                predicted.iter().map(|pose| of(pose).unwrap_or_default()).collect();
            of_points(&frames, &joints)?
        }
        None => BodyEvaluation::default(),
    };
    Ok((frames.len(), [network, filtered, mean_pose, placed]))
}

fn of_points(frames: &BodyFrames, joints_px: &[BodyPoints]) -> Result<BodyEvaluation> {
    let of_frame = |(): &mut (), frame: &BodyFrame| {
        let joints_px = joints_px[frame.sequence as usize];
        Ok::<_, PoseError>(BodyPrediction { t_s: frame.t.as_seconds(), delay_s: 0.0, joints_px })
    };
    Ok(evaluate_frames_with(frames, || (), of_frame)?)
}

/// The sequence and the time of each image.
fn times(frames: &BodyFrames) -> Vec<(u64, Micros)> {
    let frames = &frames.frames;
    // Images without time stamps all have the same one.
    let is_timed = frames.windows(2).any(|pair| pair[0].t < pair[1].t);
    let time = |(index, frame): (i64, &BodyFrame)| {
        (frame.sequence, if is_timed { frame.t } else { Micros(index * UNTIMED.0) })
    };
    (0..).zip(frames).map(time).collect()
}

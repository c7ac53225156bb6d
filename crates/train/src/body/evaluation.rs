//! Methods on recordings with known poses.

use std::path::PathBuf;

use evpose_core::Micros;
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_pose::metric::body::{
    BodyEvaluation, BodyPrediction, BodyProtocol, BodySequence, BodyTruth, MeanBody,
};
use evpose_sim::person::PoseTable;
use glam::Vec2;
use rayon::prelude::*;

use super::frames::{BodyFrame, BodyFrames, label_of};
use super::recordings::BodyRecordings;
use crate::TrainError;
use evpose_task::body::BodyCheckpoint;
use evpose_task::body::BodyPredictor;
use evpose_task::body::RepresentationReader;

/// A recording, what was found on it, and what was there.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyJudged {
    /// The recording.
    pub events: PathBuf,
    /// Poses as they were.
    pub truth: Vec<BodyTruth>,
    /// Poses that the network found.
    pub found: Vec<BodyPrediction>,
    /// How good they are.
    pub network: BodySequence,
    /// How good the mean of all training poses is.
    pub mean_pose: BodySequence,
}

/// All recordings of an evaluation.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyEvaluated {
    /// In the order of their names.
    pub recordings: Vec<BodyJudged>,
}

impl BodyEvaluated {
    /// Scores of the network.
    pub fn network(&self) -> BodyEvaluation {
        BodyEvaluation { sequences: self.recordings.iter().map(|r| r.network.clone()).collect() }
    }

    /// Scores of the mean pose.
    pub fn mean_pose(&self) -> BodyEvaluation {
        BodyEvaluation { sequences: self.recordings.iter().map(|r| r.mean_pose.clone()).collect() }
    }
}

/// Judges a network on recordings: a prediction every `every` from the first sample of its config on, and
/// beside it the mean pose. `progress` is told of every recording that is done.
///
/// # Errors
/// If a recording cannot be read.
pub fn evaluate_body(
    checkpoint: &BodyCheckpoint,
    predictor: &BodyPredictor,
    recordings: &BodyRecordings,
    every: Micros,
    mean_pose: &BodyPoints,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<BodyEvaluated, TrainError> {
    let one = |predictor: &mut BodyPredictor, (events, poses): &(PathBuf, PathBuf)| {
        let truth = truth_of(&PoseTable::read(poses)?);
        let mut film = RepresentationReader::open(events, &checkpoint.config.image)?;
        let first = Micros(1_000 * i64::from(checkpoint.config.data.first_ms));
        let end = Micros::from_seconds(truth.last().map_or(0.0, |last| last.t_s));
        let mut found = Vec::new();
        let mut t = first;
        while t <= end {
            let image = film.at(t, |_| {})?;
            found.push(predictor.predict(t.as_seconds(), &image));
            t = t + every;
        }
        let sensor = film.sensor();
        let size_px = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
        let constant: Vec<BodyPrediction> = found
            .iter()
            .map(|prediction| BodyPrediction {
                joints_px: mean_pose.map(|joint| joint.map(|at| at * size_px)),
                delay_s: 0.0,
                ..*prediction
            })
            .collect();
        let protocol = BodyProtocol::default();
        let network = BodySequence::evaluate(&truth, &found, &protocol)?;
        let mean_pose = BodySequence::evaluate(&truth, &constant, &protocol)?;
        progress(1);
        Ok(BodyJudged { events: events.clone(), truth, found, network, mean_pose })
    };
    let recordings = recordings
        .files
        .par_iter()
        .map_init(|| predictor.another(), one)
        .collect::<Result<_, TrainError>>()?;
    Ok(BodyEvaluated { recordings })
}

/// Judges a network on images with labels, and beside it the mean pose.
///
/// # Errors
/// If a label is not finite.
pub fn judge_frames(
    predictor: &BodyPredictor,
    frames: &BodyFrames,
    mean_pose: &BodyPoints,
) -> Result<(BodyEvaluation, BodyEvaluation), TrainError> {
    let sequences: Vec<&[BodyFrame]> =
        frames.frames.chunk_by(|a, b| a.sequence == b.sequence).collect();
    let one = |predictor: &mut BodyPredictor, frames: &&[BodyFrame]| {
        let (mut truth, mut found, mut constant) = (Vec::new(), Vec::new(), Vec::new());
        for frame in *frames {
            let t_s = frame.t.as_seconds();
            let size_px = Vec2::new(frame.image.width() as f32, frame.image.height() as f32);
            let mut joints_px = [None; BODY_JOINTS];
            for (joint, keypoint) in joints_px.iter_mut().zip(&frame.label.keypoints) {
                *joint = keypoint.is_labelled().then(|| keypoint.position * size_px);
            }
            truth.push(BodyTruth::by_torso(t_s, joints_px));
            found.push(predictor.predict(t_s, &frame.image));
            let joints_px = mean_pose.map(|joint| joint.map(|at| at * size_px));
            constant.push(BodyPrediction { t_s, delay_s: 0.0, joints_px });
        }
        let protocol = BodyProtocol::default();
        let of = |found: &[BodyPrediction]| BodySequence::evaluate(&truth, found, &protocol);
        Ok((of(&found)?, of(&constant)?))
    };
    let judged: Vec<(BodySequence, BodySequence)> = sequences
        .par_iter()
        .map_init(|| predictor.another(), one)
        .collect::<Result<_, TrainError>>()?;
    let (network, mean_pose) = judged.into_iter().unzip();
    Ok((BodyEvaluation { sequences: network }, BodyEvaluation { sequences: mean_pose }))
}

/// A table of poses, each measured by its own torso.
pub fn truth_of(table: &PoseTable) -> Vec<BodyTruth> {
    table.rows.iter().map(|row| BodyTruth::by_torso(row.t.as_seconds(), row.joints_px)).collect()
}

/// The mean of the poses of recordings, relative to the image: for networks that do not know the mean of
/// what they were trained on.
///
/// # Errors
/// If a table cannot be read.
pub fn mean_pose_of(
    recordings: &BodyRecordings,
    checkpoint: &BodyCheckpoint,
) -> Result<BodyPoints, TrainError> {
    let mut mean = MeanBody::default();
    for (events, poses) in &recordings.files {
        let sensor = RepresentationReader::open(events, &checkpoint.config.image)?.sensor();
        for row in PoseTable::read(poses)?.rows {
            mean.push(&label_of(&row.joints_px, sensor));
        }
    }
    Ok(mean.mean_px(Vec2::ONE))
}

//! Evaluation of networks of bodies on recordings with ground truth.

use std::path::PathBuf;

use evpose_core::Micros;
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_pose::metric::body::{
    BodyEvaluation, BodyPrediction, BodyProtocol, BodySequence, BodyTruth, MeanBody,
};
use evpose_sim::person::PoseTable;
use glam::Vec2;
use rayon::prelude::*;

use super::detections::DetectionCounts;
use super::frames::{BodyFrame, BodyFrames, label_of};
use super::recordings::{BodyRecordings, PoseTrack};
use crate::TrainError;
use evpose_task::body::BodyCheckpoint;
use evpose_task::body::{BodyPredictor, BodyRecordingStream, RepresentationReader};

/// Ground truth, predictions and scores of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyRecordingResult {
    /// The file of events.
    pub events: PathBuf,
    /// Ground truth poses.
    pub truth: Vec<BodyTruth>,
    /// Poses predicted by the network.
    pub predictions: Vec<BodyPrediction>,
    /// Whether somebody is reported where somebody is.
    pub detections: DetectionCounts,
    /// Scores of the network.
    pub network: BodySequence,
    /// Scores of the mean of all training poses, the baseline.
    pub mean_pose: BodySequence,
}

/// Results of an evaluation, recording by recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyResults {
    /// In the order of their names.
    pub recordings: Vec<BodyRecordingResult>,
}

impl BodyResults {
    /// Scores of the network.
    pub fn network(&self) -> BodyEvaluation {
        BodyEvaluation { sequences: self.recordings.iter().map(|r| r.network.clone()).collect() }
    }

    /// Whether somebody is reported where somebody is, over all recordings.
    pub fn detections(&self) -> DetectionCounts {
        let counts = self.recordings.iter().map(|recording| recording.detections);
        counts.fold(DetectionCounts::default(), DetectionCounts::merge)
    }

    /// Scores of the mean pose.
    pub fn mean_pose(&self) -> BodyEvaluation {
        BodyEvaluation { sequences: self.recordings.iter().map(|r| r.mean_pose.clone()).collect() }
    }
}

/// Evaluates a network on recordings: a prediction every `every` from the first sample of its
/// config on, and for comparison the mean pose. `camera` is as in [`Calibration::choose`](evpose_view::Calibration::choose). `progress` receives 1 after each recording.
///
/// # Errors
/// If a recording cannot be read.
pub fn evaluate_body(
    checkpoint: &BodyCheckpoint,
    predictor: &BodyPredictor,
    recordings: &BodyRecordings,
    every: Micros,
    camera: Option<&str>,
    mean_pose: &BodyPoints,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<BodyResults, TrainError> {
    let one = |(events, poses): &(PathBuf, PathBuf)| {
        let track = PoseTrack(PoseTable::read(poses)?);
        let truth = ground_truth(&track.0);
        let mut stream =
            BodyRecordingStream::open(events, camera, checkpoint, None, predictor.another())?;
        let first = Micros(1_000 * i64::from(checkpoint.config.data.first_ms));
        let end = Micros::from_seconds(truth.last().map_or(0.0, |last| last.t_s));
        let mut predictions = Vec::new();
        let mut t = first;
        while t <= end {
            predictions.push(stream.predict(t)?);
            t = t + every;
        }
        let sensor = stream.sensor();
        let size_px = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
        let constant: Vec<BodyPrediction> = predictions
            .iter()
            .map(|prediction| BodyPrediction {
                joints_px: mean_pose.map(|joint| joint.map(|at| at * size_px)),
                delay_s: 0.0,
                ..*prediction
            })
            .collect();
        let detections = DetectionCounts::of(&track, &predictions, every);
        let protocol = BodyProtocol::default();
        let network = BodySequence::evaluate(&truth, &predictions, &protocol)?;
        let mean_pose = BodySequence::evaluate(&truth, &constant, &protocol)?;
        progress(1);
        let events = events.clone();
        Ok(BodyRecordingResult { events, truth, predictions, detections, network, mean_pose })
    };
    let recordings = recordings.files.par_iter().map(one).collect::<Result<_, TrainError>>()?;
    Ok(BodyResults { recordings })
}

/// Evaluates a network, and for comparison the mean pose, on images with labels. Returns the scores
/// of both, in this order.
///
/// # Errors
/// If a label is not finite.
pub fn evaluate_frames(
    predictor: &BodyPredictor,
    frames: &BodyFrames,
    mean_pose: &BodyPoints,
) -> Result<(BodyEvaluation, BodyEvaluation), TrainError> {
    let sequences: Vec<&[BodyFrame]> =
        frames.frames.chunk_by(|a, b| a.sequence == b.sequence).collect();
    let one = |predictor: &mut BodyPredictor, frames: &&[BodyFrame]| {
        let (mut truth, mut predictions, mut constant) = (Vec::new(), Vec::new(), Vec::new());
        for frame in *frames {
            let t_s = frame.t.as_seconds();
            let size_px = Vec2::new(frame.image.width() as f32, frame.image.height() as f32);
            let mut joints_px = [None; BODY_JOINTS];
            for (joint, keypoint) in joints_px.iter_mut().zip(&frame.label.keypoints) {
                *joint = keypoint.is_labelled().then(|| keypoint.position * size_px);
            }
            truth.push(BodyTruth::by_torso(t_s, joints_px));
            predictions.push(predictor.predict(t_s, &frame.image));
            let joints_px = mean_pose.map(|joint| joint.map(|at| at * size_px));
            constant.push(BodyPrediction { t_s, delay_s: 0.0, joints_px });
        }
        let protocol = BodyProtocol::default();
        let score =
            |predictions: &[BodyPrediction]| BodySequence::evaluate(&truth, predictions, &protocol);
        Ok((score(&predictions)?, score(&constant)?))
    };
    let scores: Vec<(BodySequence, BodySequence)> = sequences
        .par_iter()
        .map_init(|| predictor.another(), one)
        .collect::<Result<_, TrainError>>()?;
    let (network, mean_pose) = scores.into_iter().unzip();
    Ok((BodyEvaluation { sequences: network }, BodyEvaluation { sequences: mean_pose }))
}

/// The ground truth of a table of poses: the scale of each pose is its own torso.
pub fn ground_truth(table: &PoseTable) -> Vec<BodyTruth> {
    table.rows.iter().map(|row| BodyTruth::by_torso(row.t.as_seconds(), row.joints_px)).collect()
}

/// The mean of the poses of recordings, relative to the image: the baseline for networks whose
/// checkpoint does not hold the mean of their training poses.
///
/// # Errors
/// If a table cannot be read.
pub fn mean_pose_of_recordings(
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

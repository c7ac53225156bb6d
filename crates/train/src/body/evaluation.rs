//! Evaluation of networks of bodies on recordings with ground truth.

use std::path::PathBuf;
use std::time::Instant;

use evpose_core::{Micros, SensorSize};
use evpose_io::{OpenOptions, Windows};
use evpose_pose::PoseError;
use evpose_pose::body::BodyPoints;
use evpose_pose::body::fusion::ScoredPoints;
use evpose_pose::filter::BodyFilterConfig;
use evpose_pose::metric::body::{
    BodyEvaluation, BodyPrediction, BodyProtocol, BodySequence, BodyTruth, MeanBody,
};
use evpose_pose::stream::InferenceSchedule;
use evpose_sim::person::PoseTable;
use glam::Vec2;
use rayon::prelude::*;

use super::detections::DetectionCounts;
use super::filter_noise::{ScoredPose, estimate_filter};
use super::frames::{BodyFrame, BodyFrames, label_of};
use super::recordings::{BodyRecordings, PoseTrack};
use crate::TrainError;
use evpose_camera::Calibration;
use evpose_task::body::BodyCheckpoint;
use evpose_task::body::{BodyPredictor, body_stream};
use evpose_task::{InferredPoses, RecordingStream};

/// Ground truth, predictions and scores of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyRecordingResult {
    /// The file of events.
    pub events: PathBuf,
    /// Ground truth poses.
    pub truth: Vec<BodyTruth>,
    /// Poses predicted by the network.
    pub predictions: Vec<BodyPrediction>,
    /// The same through the filter of the config; none of networks without one.
    pub filtered_predictions: Vec<BodyPrediction>,
    /// Whether somebody is reported where somebody is.
    pub detections: DetectionCounts,
    /// The same with scores and truth.
    pub scored: Vec<ScoredPose>,
    /// Scores of the network.
    pub network: BodySequence,
    /// Scores of the same poses through the filter of the config; none of networks without one.
    pub filtered: Option<BodySequence>,
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

    /// Scores of the network's poses through the filter.
    pub fn filtered(&self) -> BodyEvaluation {
        let filtered = self.recordings.iter().filter_map(|recording| recording.filtered.clone());
        BodyEvaluation { sequences: filtered.collect() }
    }

    /// The filter that its residuals would have; none without any.
    ///
    /// # Errors
    /// If no filter can be made.
    pub fn estimated_filter(&self) -> Result<Option<BodyFilterConfig>, TrainError> {
        let sequences: Vec<&[ScoredPose]> =
            self.recordings.iter().map(|recording| &recording.scored[..]).collect();
        estimate_filter(&sequences)
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

/// Evaluates a network on recordings: the poses that `evpose infer` writes every `every`, from the time of the
/// first sample of its config on, and for comparison the mean pose. `camera` is as in [`Calibration::choose`].
/// `progress` receives 1 after each recording.
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
        let windows = Windows::open(events, &OpenOptions::default())?;
        let calibration = Calibration::choose(camera, windows.sensor())?;
        // Recordings run in parallel, and each needs the buffers of an engine of its own.
        let mut stream = body_stream(checkpoint, &calibration, None, predictor.another())?;
        stream.frontend = stream.frontend.with_filter(checkpoint.config.filter)?;
        let recording = RecordingStream::new(windows, stream, InferenceSchedule::Every(every));
        let first = Micros(1_000 * i64::from(checkpoint.config.data.first_ms));
        let (mut predictions, mut smoothed, mut scored) = (Vec::new(), Vec::new(), Vec::new());
        for inferred in recording {
            let InferredPoses { t, poses, delay_s, .. } = inferred?;
            // As in training, whose images begin there.
            if t < first || t > track.end() {
                continue;
            }
            // Without a pose no joint is known, which counts as missed.
            let mut joints = [BodyPoints::default(); 2];
            if let Some((_, pose)) = poses.first() {
                joints = [pose.detection.points, pose.joints_px];
                let truth = track.at(t).unwrap_or_default();
                scored.push(ScoredPose { t, pose: pose.detection, truth });
            }
            let [raw, filtered] =
                joints.map(|joints_px| BodyPrediction { t_s: t.as_seconds(), delay_s, joints_px });
            predictions.push(raw);
            smoothed.push(filtered);
        }
        let constant = constant_predictions(&predictions, mean_pose, calibration.sensor);
        let detections = DetectionCounts::of(&track, &predictions, every);
        let protocol = BodyProtocol::default();
        let network = BodySequence::evaluate(&truth, &predictions, &protocol)?;
        let filtered = Some(BodySequence::evaluate(&truth, &smoothed, &protocol)?);
        let mean_pose = BodySequence::evaluate(&truth, &constant, &protocol)?;
        progress(1);
        Ok(BodyRecordingResult {
            events: events.clone(),
            truth,
            predictions,
            filtered_predictions: smoothed,
            detections,
            scored,
            network,
            filtered,
            mean_pose,
        })
    };
    let recordings = recordings.files.par_iter().map(one).collect::<Result<_, TrainError>>()?;
    Ok(BodyResults { recordings })
}

/// The same pose, relative to the image of a sensor, at the times of predictions.
fn constant_predictions(
    predictions: &[BodyPrediction],
    pose: &BodyPoints,
    sensor: SensorSize,
) -> Vec<BodyPrediction> {
    let size_px = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
    let joints_px = pose.map(|joint| joint.map(|at| at * size_px));
    // A constant needs no inference, hence no delay.
    let constant =
        |prediction: &BodyPrediction| BodyPrediction { joints_px, delay_s: 0.0, ..*prediction };
    predictions.iter().map(constant).collect()
}

/// Evaluates a network, and for comparison the mean pose, on images with labels. Returns the scores
/// of both, in this order. `observe` is shown what the network finds on each image.
///
/// # Errors
/// If a label is not finite.
pub fn evaluate_frames(
    predictor: &BodyPredictor,
    frames: &BodyFrames,
    mean_pose: &BodyPoints,
    observe: &(dyn Fn(&BodyFrame, &ScoredPoints) + Sync),
) -> Result<(BodyEvaluation, BodyEvaluation), TrainError> {
    let predict = |predictor: &mut BodyPredictor, frame: &BodyFrame| {
        let begin = Instant::now();
        let ScoredPose { pose, .. } = ScoredPose::of(predictor, frame);
        let delay_s = begin.elapsed().as_secs_f64();
        observe(frame, &pose);
        let (t_s, joints_px) = (frame.t.as_seconds(), pose.points);
        Ok::<_, TrainError>(BodyPrediction { t_s, delay_s, joints_px })
    };
    let network = evaluate_frames_with(frames, || predictor.another(), predict)?;
    // The mean pose is known beforehand: it has no delay.
    let constant = |frame: &BodyFrame| {
        let size_px = frame.size_px();
        let joints_px = mean_pose.map(|joint| joint.map(|at| at * size_px));
        BodyPrediction { t_s: frame.t.as_seconds(), delay_s: 0.0, joints_px }
    };
    let mean_pose =
        evaluate_frames_with(frames, || (), |(), frame| Ok::<_, TrainError>(constant(frame)))?;
    Ok((network, mean_pose))
}

/// Evaluates any predictor on images with labels: `start` makes one for each sequence, `predict` runs
/// it on the images in their order.
///
/// # Errors
/// Those of `predict`, or if a label is not finite.
pub fn evaluate_frames_with<P, E: From<PoseError> + Send>(
    frames: &BodyFrames,
    start: impl Fn() -> P + Sync,
    predict: impl Fn(&mut P, &BodyFrame) -> Result<BodyPrediction, E> + Sync,
) -> Result<BodyEvaluation, E> {
    // Frames are sorted, so that a run of one sequence is all of it.
    let sequences: Vec<&[BodyFrame]> =
        frames.frames.chunk_by(|a, b| a.sequence == b.sequence).collect();
    let one = |frames: &&[BodyFrame]| {
        // A predictor may remember what it saw: not from one sequence to the next.
        let mut predictor = start();
        let truth: Vec<BodyTruth> = frames
            .iter()
            .map(|frame| BodyTruth::by_torso(frame.t.as_seconds(), frame.joints_px()))
            .collect();
        let predictions: Vec<BodyPrediction> =
            frames.iter().map(|frame| predict(&mut predictor, frame)).collect::<Result<_, E>>()?;
        Ok(BodySequence::evaluate(&truth, &predictions, &BodyProtocol::default())?)
    };
    let sequences = sequences.par_iter().map(one).collect::<Result<_, E>>()?;
    Ok(BodyEvaluation { sequences })
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
pub fn mean_pose_of_recordings(recordings: &BodyRecordings) -> Result<BodyPoints, TrainError> {
    let mut mean = MeanBody::default();
    for (events, poses) in &recordings.files {
        let sensor = Windows::open(events, &OpenOptions::default())?.sensor();
        for row in PoseTable::read(poses)?.rows {
            mean.push(&label_of(&row.joints_px, sensor));
        }
    }
    Ok(mean.mean_px(Vec2::ONE))
}

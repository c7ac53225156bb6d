//! Evaluation of baselines on recordings with ground truth, on the image and in metres.

use std::path::PathBuf;

use evpose_core::Micros;
use evpose_io::{OpenOptions, Windows};
use evpose_pose::body::BodyPoints;
use evpose_pose::metric::body::{BodyPrediction, BodyProtocol, BodySequence};
use evpose_pose::stream::InferenceSchedule;
use evpose_sim::person::PoseTable;
use evpose_task::baseline::{BaselineCheckpoint, BaselinePose, baseline_stream};
use evpose_task::{InferredPoses, RecordingStream};
use rayon::prelude::*;

use crate::TrainError;
use crate::body::{
    BodyRecordingResult, BodyRecordings, BodyResults, DetectionCounts, PoseTrack,
    constant_predictions, ground_truth, in_camera, placed_camera,
};

/// Results of an evaluation, recording by recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BaselineResults {
    /// Scores on the image, as those of MoveEnet.
    pub body: BodyResults,
    /// The poses of each recording.
    pub poses: Vec<Vec<BaselinePose>>,
    /// Distances of joints from the truth in the camera, in metres, of each recording: one for each
    /// pose and joint where both are known. Empty where the camera is not known, and of
    /// `dhp19-cnn`.
    pub errors_m: Vec<Vec<f32>>,
}

impl BaselineResults {
    /// The mean distance of joints from the truth in the camera, in metres; none where no joint has
    /// a position in metres.
    pub fn mpjpe_m(&self) -> Option<f64> {
        let errors = || self.errors_m.iter().flatten();
        let count = errors().count();
        (count > 0).then(|| errors().map(|&error| f64::from(error)).sum::<f64>() / count as f64)
    }
}

/// Evaluates a network on recordings: a pose every `every`, from the time of the first sample of its config on,
/// and for comparison the mean pose. Cameras are those that the recordings say. `progress`
/// receives 1 after each recording.
///
/// # Errors
/// If a recording cannot be read.
pub fn evaluate_baseline(
    checkpoint: &BaselineCheckpoint,
    recordings: &BodyRecordings,
    every: Micros,
    mean_pose: &BodyPoints,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<BaselineResults, TrainError> {
    let one = |(events, poses): &(PathBuf, PathBuf)| {
        let track = PoseTrack(PoseTable::read(poses)?);
        let truth = ground_truth(&track.0);
        let camera = placed_camera(poses);
        let windows = Windows::open(events, &OpenOptions::default())?;
        let sensor = windows.sensor();
        let stream = baseline_stream(checkpoint, sensor, camera.map(|camera| camera.lens))?;
        let first = Micros(1_000 * i64::from(checkpoint.config.data.first_ms));
        let (mut predicted, mut predictions, mut errors_m) = (Vec::new(), Vec::new(), Vec::new());
        for inferred in RecordingStream::new(windows, stream, InferenceSchedule::Every(every)) {
            let InferredPoses { t, poses, delay_s } = inferred?;
            let is_scored = t >= first && t <= track.end();
            let Some((_, pose)) = poses.first().filter(|_| is_scored) else { continue };
            if let Some((camera, joints_m)) = camera.zip(track.at_m(t)) {
                let truth = joints_m.map(|at_m| in_camera(&camera, at_m));
                let errors = pose.joints_m.iter().zip(truth).filter_map(|(joint, truth)| {
                    Some(joint.as_ref()?.distance(truth)).filter(|error| error.is_finite())
                });
                errors_m.extend(errors);
            }
            let joints_px = pose.joints_px;
            predictions.push(BodyPrediction { t_s: t.as_seconds(), delay_s, joints_px });
            predicted.push(*pose);
        }
        let constant = constant_predictions(&predictions, mean_pose, sensor);
        let protocol = BodyProtocol::default();
        let result = BodyRecordingResult {
            events: events.clone(),
            detections: DetectionCounts::of(&track, &predictions, every),
            scored: Vec::new(),
            filtered_predictions: Vec::new(),
            filtered: None,
            network: BodySequence::evaluate(&truth, &predictions, &protocol)?,
            mean_pose: BodySequence::evaluate(&truth, &constant, &protocol)?,
            truth,
            predictions,
        };
        progress(1);
        Ok((result, predicted, errors_m))
    };
    let all: Vec<(BodyRecordingResult, Vec<BaselinePose>, Vec<f32>)> =
        recordings.files.par_iter().map(one).collect::<Result<_, TrainError>>()?;
    let mut results = BaselineResults::default();
    for (result, poses, errors_m) in all {
        results.body.recordings.push(result);
        results.poses.push(poses);
        results.errors_m.push(errors_m);
    }
    Ok(results)
}

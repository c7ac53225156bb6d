//! Scores of a baseline on recordings.

use std::path::PathBuf;

use evpose_core::Micros;
use evpose_io::{OpenOptions, Windows};
use evpose_pose::metric::body::{BodyEvaluation, BodyPrediction, BodyProtocol, BodySequence};
use evpose_pose::stream::InferenceSchedule;
use evpose_sim::person::PoseTable;
use evpose_task::baseline::{BaselineCheckpoint, baseline_stream};
use evpose_task::{InferredPoses, RecordingStream};
use rayon::prelude::*;

use crate::TrainError;
use crate::body::{BodyRecordings, ground_truth};

/// Evaluates a network on recordings: the poses that `evpose infer` writes every `every`, from the time of
/// the first sample of its config on. `progress` receives 1 after each recording.
///
/// # Errors
/// If a recording cannot be read.
pub fn evaluate_baseline(
    checkpoint: &BaselineCheckpoint,
    recordings: &BodyRecordings,
    every: Micros,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<(BodyEvaluation, Vec<Vec<BodyPrediction>>), TrainError> {
    let first = Micros(1_000 * i64::from(checkpoint.config.data.first_ms));
    let one = |(events, poses): &(PathBuf, PathBuf)| {
        let truth = ground_truth(&PoseTable::read(poses)?);
        let end_s = truth.last().map_or(f64::NEG_INFINITY, |last| last.t_s);
        let windows = Windows::open(events, &OpenOptions::default())?;
        let stream = baseline_stream(checkpoint, windows.sensor(), None)?;
        let mut predictions = Vec::new();
        for inferred in RecordingStream::new(windows, stream, InferenceSchedule::Every(every)) {
            let InferredPoses { t, poses, delay_s, .. } = inferred?;
            let t_s = t.as_seconds();
            // As in training, whose images begin there.
            if t >= first && t_s <= end_s {
                // Without a pose no joint is known, which counts as missed.
                let joints_px = poses.first().map(|(_, pose)| pose.joints_px).unwrap_or_default();
                predictions.push(BodyPrediction { t_s, delay_s, joints_px });
            }
        }
        let scores = BodySequence::evaluate(&truth, &predictions, &BodyProtocol::default())?;
        progress(1);
        Ok((scores, predictions))
    };
    let results = recordings.files.par_iter().map(one).collect::<Result<Vec<_>, TrainError>>()?;
    let (sequences, predictions) = results.into_iter().unzip();
    Ok((BodyEvaluation { sequences }, predictions))
}

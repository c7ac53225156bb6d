//! Evaluation of poses propagated from detections by the velocities of events.
//!
//! # Model
//! The network runs at a rate of its own, and a detection becomes known a latency after the time
//! stamp of its input. Without propagation the last detection stands until the next one; with
//! propagation events since then move each joint on. Both are compared with the ground truth at the
//! same instants.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use evpose_core::Micros;
use evpose_io::{OpenOptions, Windows};
use evpose_pose::PoseEstimate;
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_pose::metric::body::{BodyEvaluation, BodyPrediction, BodyProtocol, BodySequence};
use evpose_pose::stream::{InferenceSchedule, InferenceWorker, PoseStream, StreamFrontend};
use evpose_sim::person::PoseTable;
use rayon::prelude::*;

use super::evaluation::ground_truth;
use super::recordings::BodyRecordings;
use crate::TrainError;
use evpose_camera::Calibration;
use evpose_task::body::{
    BodyCheckpoint, BodyFrontend, BodyPredictor, BodyWorker, PropagationConfig, body_stream,
};
use evpose_task::{RecordingStream, TaskError};

/// The pose at one instant, without and with propagation.
#[derive(Debug, Clone, PartialEq)]
pub struct PropagatedPose {
    /// Time stamp, in seconds.
    pub t_s: f64,
    /// The newest detection that is known by then, unchanged.
    pub last_detection: BodyPoints,
    /// The newest detection, propagated to this instant.
    pub propagated: BodyPoints,
    /// The same with its scores; none before the first detection.
    pub estimate: Option<PoseEstimate>,
}

/// Poses of a recording at an even rate, from `first` to `end`, made as they are asked for; after an
/// error there are none.
///
/// # Errors
/// Each item: if the recording cannot be read, or the network fails.
pub fn propagated_poses<'a>(
    recording: &'a mut RecordingStream<BodyFrontend, BodyWorker>,
    config: &PropagationConfig,
    (first, end): (Micros, Micros),
) -> impl Iterator<Item = Result<PropagatedPose, TrainError>> + use<'a> {
    let micros = |seconds: f64| Micros((seconds * 1e6).round() as i64);
    let (step, period) = (micros(1.0 / config.output_hz), micros(1.0 / config.network_hz));
    let latency = micros(1e-3 * config.latency_ms);
    let (mut last_detection, mut next_inference) = ([None; BODY_JOINTS], first);
    // Inputs whose output is computed but, with the latency, not yet known.
    let mut pending = VecDeque::new();
    let mut t = first;
    let mut pose_at = move |t: &mut Micros| {
        // Time without events is skipped.
        let active = recording.skip_silence(*t)?;
        // Whole steps are skipped: the poses stay on the grid of the output's rate.
        *t = *t + Micros((active - *t).0.div_euclid(step.0) * step.0);
        recording.advance(*t)?;
        let PoseStream { frontend, worker, .. } = recording.stream();
        if *t >= next_inference {
            if let Some(input) = frontend.input(*t, None) {
                let joints = worker.infer(&input).map_err(TaskError::Stream)?;
                pending.push_back((*t, input, joints));
            }
            next_inference = next_inference + period;
            // A network that is faster than the output runs once per output, and accumulates no
            // debt.
            if next_inference <= *t {
                next_inference = *t + period;
            }
        }
        while let Some((stamp, input, joints)) =
            pending.pop_front_if(|(stamp, ..)| *stamp + latency <= *t)
        {
            for (_, pose) in frontend.accept(stamp, &input, joints, *t) {
                last_detection = pose.joints_px;
            }
        }
        let estimate = frontend.propagate(*t);
        let propagated = match &estimate {
            Some(PoseEstimate::Body { joints_px, .. }) => *joints_px,
            _ => [None; BODY_JOINTS],
        };
        let pose = PropagatedPose { t_s: t.as_seconds(), last_detection, propagated, estimate };
        *t = *t + step;
        Ok(pose)
    };
    std::iter::from_fn(move || {
        (t <= end).then(|| pose_at(&mut t).inspect_err(|_| t = Micros(i64::MAX)))
    })
}

/// Scores of recordings without and with propagation.
///
/// A filter leaves out joints that the network detected with little confidence. A mean error over
/// the remaining ones would flatter it, so both are also compared on the joints that both have.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PropagationResults {
    /// The last detections, unchanged.
    pub last_detection: BodyEvaluation,
    /// The same, propagated.
    pub propagated: BodyEvaluation,
    /// As `last_detection`, on the joints that propagated poses have as well.
    pub last_detection_on_common_joints: BodyEvaluation,
    /// As `propagated`, on the joints that the last detections have as well.
    pub propagated_on_common_joints: BodyEvaluation,
}

/// Compares last detections and propagated poses with the ground truth of recordings. `progress`
/// receives 1 after each recording.
///
/// # Errors
/// As [`propagated_poses`].
pub fn evaluate_propagation(
    checkpoint: &BodyCheckpoint,
    predictor: &BodyPredictor,
    recordings: &BodyRecordings,
    config: &PropagationConfig,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<PropagationResults, TrainError> {
    let one = |(events, poses): &(PathBuf, PathBuf)| {
        let scores = score_recording(checkpoint, predictor.another(), events, poses, config);
        progress(1);
        scores
    };
    let scores: Vec<[BodySequence; 4]> =
        recordings.files.par_iter().map(one).collect::<Result<_, TrainError>>()?;
    let mut results = PropagationResults::default();
    for [last_detection, propagated, last_common, propagated_common] in scores {
        results.last_detection.sequences.push(last_detection);
        results.propagated.sequences.push(propagated);
        results.last_detection_on_common_joints.sequences.push(last_common);
        results.propagated_on_common_joints.sequences.push(propagated_common);
    }
    Ok(results)
}

fn score_recording(
    checkpoint: &BodyCheckpoint,
    predictor: BodyPredictor,
    events: &Path,
    poses: &Path,
    config: &PropagationConfig,
) -> Result<[BodySequence; 4], TrainError> {
    let truth = ground_truth(&PoseTable::read(poses)?);
    let windows = Windows::open(events, &OpenOptions::default())?;
    let calibration = Calibration::choose(None, windows.sensor())?;
    let stream = body_stream(checkpoint, &calibration, Some(config), predictor)?;
    let mut recording = RecordingStream::new(windows, stream, InferenceSchedule::NewestWhenFree);
    let first = Micros(1_000 * i64::from(checkpoint.config.data.first_ms));
    let end = Micros::from_seconds(truth.last().map_or(0.0, |last| last.t_s));
    let poses: Vec<PropagatedPose> =
        propagated_poses(&mut recording, config, (first, end)).collect::<Result<_, _>>()?;
    // At the rate of the output, as often as poses are propagated.
    let protocol = BodyProtocol { rate_hz: config.output_hz, ..BodyProtocol::default() };
    let sequence = |joints: fn(&PropagatedPose) -> BodyPoints| {
        let predictions: Vec<BodyPrediction> = poses
            .iter()
            // Their delay is simulated already: a pose comes at the time at which it is known.
            .map(|pose| BodyPrediction { t_s: pose.t_s, delay_s: 0.0, joints_px: joints(pose) })
            .collect();
        BodySequence::evaluate(&truth, &predictions, &protocol)
    };
    Ok([
        // Over joints that both have, too: leaving joints out must not look like accuracy.
        sequence(|pose| pose.last_detection)?,
        sequence(|pose| pose.propagated)?,
        sequence(|pose| on_common_joints(&pose.last_detection, &pose.propagated))?,
        sequence(|pose| on_common_joints(&pose.propagated, &pose.last_detection))?,
    ])
}

/// `joints` without those that `others` lacks.
fn on_common_joints(joints: &BodyPoints, others: &BodyPoints) -> BodyPoints {
    std::array::from_fn(|joint| joints[joint].filter(|_| others[joint].is_some()))
}

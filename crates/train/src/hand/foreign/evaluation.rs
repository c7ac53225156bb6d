//! Evaluation of a network of hands on recordings of any camera, by labelled joints.

use evpose_core::Micros;
use evpose_pose::metric::{HandEvaluation, HandPoints, SequenceScores};
use evpose_pose::stream::{InferenceSchedule, InferenceWorker, PoseStream, StreamFrontend};
use evpose_pose::{HandParams, HandPose, PoseEstimate};
use evpose_task::hand::{
    HandConfig, HandFrontend, HandWorker, Predictor, canonical_view, hand_recording,
};
use evpose_task::{RecordingStream, TaskError};
use glam::{Vec2, Vec3};

use super::{ForeignHand, HandJointRow};
use crate::TrainError;

/// Largest distance in time of a label from the pose that it is compared with.
const MAX_OFFSET: Micros = Micros(1_500);

/// Scores of a network and of a constant pose on recordings of any camera.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ForeignHandResults {
    /// The network's poses.
    pub network: HandEvaluation,
    /// The same after the Kalman filter.
    pub filtered: HandEvaluation,
    /// The mean pose of the training.
    pub mean_pose: HandEvaluation,
}

/// Evaluates a network on recordings at the times of their labels; where it sees no hand, all of the label is wrong. Parameters are not labelled:
/// only errors of points are scored. `progress` receives 1 after each recording.
///
/// # Errors
/// If a prediction fails.
pub fn evaluate_foreign_hands(
    config: &HandConfig,
    recordings: &[ForeignHand],
    predictor: &mut dyn Predictor,
    mean_pose: &HandParams,
    progress: &mut dyn FnMut(u64),
) -> Result<ForeignHandResults, TrainError> {
    let mut results = ForeignHandResults::default();
    let mean_pose = HandPose::from(*mean_pose);
    for recording in recordings {
        let mut stream = stream(config, recording, &mut *predictor)?;
        let mut poses = Vec::new();
        for inferred in &mut stream {
            poses.extend(inferred?.poses.into_iter().map(|(_, estimate)| estimate));
        }
        let frontend = &stream.stream().frontend;
        let since = frontend.presence().since;
        let mut scores: [SequenceScores; 3] = Default::default();
        for label in &recording.labels.rows {
            // Labels have times of their own: the pose before or after, whichever is nearer.
            let next = poses.partition_point(|pose| pose.t < label.t);
            let around = poses[next.saturating_sub(1)..].iter().take(2);
            let nearest = around.min_by_key(|pose| (pose.t - label.t).0.abs());
            let Some(pose) = nearest.filter(|pose| (pose.t - label.t).0.abs() <= MAX_OFFSET.0)
            else {
                // There is a hand, and the network saw none. Before the first full window it was not asked.
                if since.is_some_and(|since| label.t >= since) {
                    let [network, filtered, constant] = &mut scores;
                    miss(label, network);
                    miss(label, filtered);
                    score(&frontend.pose(mean_pose), label, constant);
                }
                continue;
            };
            for (scores, pose) in
                scores.iter_mut().zip([&pose.measured, &pose.filtered, &mean_pose])
            {
                score(&frontend.pose(*pose), label, scores);
            }
        }
        let [network, filtered, constant] = scores;
        results.network.sequences.push(network);
        results.filtered.sequences.push(filtered);
        results.mean_pose.sequences.push(constant);
        progress(1);
    }
    Ok(results)
}

/// The input of the network at the time of a label, and where the points of the hand are in it.
#[derive(Debug, Clone)]
pub struct ForeignHandView {
    /// Values of the canonical view, `[2][rows][columns]`; a left hand is mirrored.
    pub values: Vec<f32>,
    /// Height and width of it.
    pub size: (usize, usize),
    /// Labelled points in it, in pixels.
    pub truth_px: [Option<Vec2>; 21],
    /// Points of the network's pose.
    pub predicted_px: [Option<Vec2>; 21],
}

/// The inputs of the network from a recording at `count` labels, spread evenly.
///
/// # Errors
/// If a prediction fails.
pub fn foreign_hand_views(
    config: &HandConfig,
    recording: &ForeignHand,
    predictor: &mut dyn Predictor,
    count: usize,
) -> Result<Vec<ForeignHandView>, TrainError> {
    let sensor = canonical_view(config).sensor;
    let size = (usize::from(sensor.height), usize::from(sensor.width));
    let mut stream = stream(config, recording, predictor)?;
    let Some([begin, _]) = stream.span()? else { return Ok(Vec::new()) };
    // Before a whole window has passed there is no input.
    let first = begin + config.representation.window();
    let rows: Vec<&HandJointRow> =
        recording.labels.rows.iter().filter(|label| label.t >= first).collect();
    let mut views = Vec::new();
    // The middles of equal parts of the labels.
    let count = count.min(rows.len());
    for k in 0..count {
        let label = rows[(2 * k + 1) * rows.len() / (2 * count)];
        stream.advance(label.t)?;
        let PoseStream { frontend, worker, .. } = stream.stream();
        frontend.stride(label.t);
        // A batch that is not full: of this input alone.
        let Some(input) = frontend.rest() else { continue };
        let poses = worker.infer(&input).map_err(TaskError::Stream)?;
        let Some(pose) = poses.first() else { continue };
        let view_px = |at_px: Option<Vec2>| frontend.view_from_sensor(at_px?);
        let PoseEstimate::Hand { points, .. } = frontend.pose(*pose) else { continue };
        let predicted_px = points.image_px.map(view_px);
        let truth_px = label.image_px.map(view_px);
        let values = input.values().to_vec();
        views.push(ForeignHandView { values, size, truth_px, predicted_px });
    }
    Ok(views)
}

/// A recording through the stream, a pose every millisecond; the network sees hands of the other side mirrored.
fn stream<'a>(
    config: &HandConfig,
    recording: &ForeignHand,
    predictor: &'a mut dyn Predictor,
) -> Result<RecordingStream<HandFrontend, HandWorker<&'a mut dyn Predictor>>, TrainError> {
    let (windows, every_ms) = (recording.windows()?, InferenceSchedule::Every(Micros(1_000)));
    let calibration = &recording.calibration;
    let mut stream = hand_recording(config, predictor, windows, calibration, every_ms)?;
    stream.stream().frontend.mirror(recording.side != config.simulation.hands.side(0));
    Ok(stream)
}

/// Scores a label of which there is no pose.
fn miss(label: &HandJointRow, scores: &mut SequenceScores) {
    let world_m = label.camera_m.unwrap_or([Vec3::ZERO; 21]);
    let truth = HandPoints { world_m, image_px: label.image_px };
    scores.push_missing(&truth, label.camera_m.is_some());
}

/// Compares a pose with labels on the sensor and in the frame of the camera.
fn score(predicted: &PoseEstimate, label: &HandJointRow, scores: &mut SequenceScores) {
    let PoseEstimate::Hand { points, camera_m, .. } = predicted else { return };
    let predicted = HandPoints { world_m: **camera_m, image_px: points.image_px };
    // Nothing reads these zeros: without positions only the image is scored.
    let world_m = label.camera_m.unwrap_or([Vec3::ZERO; 21]);
    let truth = HandPoints { world_m, image_px: label.image_px };
    if label.camera_m.is_some() {
        scores.push_points(&predicted, &truth);
    } else {
        scores.push_image_points(&predicted, &truth);
    }
}

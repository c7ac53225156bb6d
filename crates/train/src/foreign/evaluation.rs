//! Evaluation of a network of hands on recordings of any camera, by labelled joints.

use evpose_core::Micros;
use evpose_pose::metric::{HandEvaluation, HandPoints, SequenceScores};
use evpose_pose::stream::{InferenceSchedule, InferenceWorker, PoseStream, StreamFrontend};
use evpose_pose::{HandParams, HandSide};
use evpose_task::hand::{
    HandConfig, HandFrontend, HandView, HandWorker, Predictor, canonical_view, hand_recording,
};
use evpose_task::{RecordingStream, TaskError};
use evpose_view::ViewAdaptor;
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

/// Evaluates a network on recordings at the times of their labels. Parameters are not labelled:
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
    for recording in recordings {
        let seen = SeenHand::new(config, recording)?;
        let mut poses = Vec::new();
        for inferred in seen.recording(config, recording, &mut *predictor)? {
            poses.extend(inferred?.poses.into_iter().map(|(_, estimate)| estimate));
        }
        let mut scores: [SequenceScores; 3] = Default::default();
        for label in &recording.labels.rows {
            let next = poses.partition_point(|pose| pose.t < label.t);
            let around = poses[next.saturating_sub(1)..].iter().take(2);
            let nearest = around.min_by_key(|pose| (pose.t - label.t).0.abs());
            let Some(pose) = nearest.filter(|pose| (pose.t - label.t).0.abs() <= MAX_OFFSET.0)
            else {
                continue;
            };
            for (scores, params) in
                scores.iter_mut().zip([&pose.measured, &pose.filtered, mean_pose])
            {
                seen.score(params, label, scores);
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
    let seen = SeenHand::new(config, recording)?;
    let sensor = seen.adaptor.view().sensor;
    let size = (usize::from(sensor.height), usize::from(sensor.width));
    let mut stream = seen.recording(config, recording, predictor)?;
    let Some([begin, _]) = stream.span()? else { return Ok(Vec::new()) };
    let first = begin + config.representation.window();
    let rows: Vec<&HandJointRow> =
        recording.labels.rows.iter().filter(|label| label.t >= first).collect();
    let mut views = Vec::new();
    for k in 0..count.min(rows.len()) {
        let label = rows[(2 * k + 1) * rows.len() / (2 * count)];
        stream.advance(label.t)?;
        let PoseStream { frontend, worker, .. } = stream.stream();
        frontend.stride(label.t);
        // A batch that is not full: of this input alone.
        let Some(input) = frontend.rest() else { continue };
        let poses = worker.infer(&input).map_err(TaskError::Stream)?;
        let Some(pose) = poses.first() else { continue };
        let predicted_px = seen.view.points(seen.side, pose, &[]).image_px;
        let truth_px = label.image_px.map(|point| seen.view_px(point?));
        let values = input.values().to_vec();
        views.push(ForeignHandView { values, size, truth_px, predicted_px });
    }
    Ok(views)
}

/// A recording as the network sees it: a right hand before the canonical camera.
struct SeenHand {
    adaptor: ViewAdaptor,
    view: HandView,
    is_mirrored: bool,
    /// The side of the network's hands.
    side: HandSide,
}

impl SeenHand {
    fn new(config: &HandConfig, recording: &ForeignHand) -> Result<Self, TrainError> {
        let adaptor = ViewAdaptor::new(&recording.calibration, &canonical_view(config));
        let side = config.simulation.hands.side(0);
        let is_mirrored = recording.side != side;
        Ok(Self { adaptor, view: HandView::new(config)?, is_mirrored, side })
    }

    /// The recording through the stream, a pose every millisecond; a hand of the other side is mirrored.
    fn recording<'a>(
        &self,
        config: &HandConfig,
        recording: &ForeignHand,
        predictor: &'a mut dyn Predictor,
    ) -> Result<RecordingStream<HandFrontend, HandWorker<&'a mut dyn Predictor>>, TrainError> {
        let (windows, every_ms) = (recording.windows()?, InferenceSchedule::Every(Micros(1_000)));
        let calibration = &recording.calibration;
        let mut stream = hand_recording(config, predictor, windows, calibration, every_ms)?;
        stream.stream().frontend.mirror(self.is_mirrored);
        Ok(stream)
    }

    /// The points of a predicted pose: on the sensor, and in the frame of the camera, y downwards.
    fn points(&self, pose: &HandParams) -> HandPoints {
        let canonical = self.view.points(self.side, pose, &[]);
        let width_px = f32::from(self.adaptor.view().sensor.width);
        let image_px = canonical.image_px.map(|point| {
            let point = point?;
            let x = if self.is_mirrored { width_px - point.x } else { point.x };
            Some(self.adaptor.sensor_from_view(Vec2::new(x, point.y)))
        });
        let mirror = if self.is_mirrored { -1.0 } else { 1.0 };
        let world_m = self.view.camera_points(&canonical.world_m).map(|point| {
            // From y up, looking along -z, to y down, looking along z.
            Vec3::new(mirror * point.x, -point.y, -point.z)
        });
        HandPoints { world_m, image_px }
    }

    /// Position in what the network sees of a position on the sensor.
    fn view_px(&self, sensor_px: Vec2) -> Option<Vec2> {
        let at = self.adaptor.view_from_sensor(sensor_px)?;
        let width_px = f32::from(self.adaptor.view().sensor.width);
        Some(Vec2::new(if self.is_mirrored { width_px - at.x } else { at.x }, at.y))
    }

    fn score(&self, pose: &HandParams, label: &HandJointRow, scores: &mut SequenceScores) {
        let predicted = self.points(pose);
        let world_m = label.camera_m.unwrap_or([Vec3::ZERO; 21]);
        let truth = HandPoints { world_m, image_px: label.image_px };
        if label.camera_m.is_some() {
            scores.push_points(&predicted, &truth);
        } else {
            scores.push_image_points(&predicted, &truth);
        }
    }
}

//! People in the world: recordings of several calibrated cameras, one network, triangulation and a
//! filter.

use evpose_camera::Calibration;
use evpose_core::{Micros, PlacedCamera};
use evpose_io::Windows;
use evpose_pose::PoseEstimate;
use evpose_pose::body::triangulation::{
    Observation, TriangulatedPoint, TriangulationConfig, triangulate,
};
use evpose_pose::body::{BODY_JOINTS, SpatialFilter, SpatialFilterConfig, WorldJoints};
use evpose_pose::stream::InferenceSchedule;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::checkpoint::BodyCheckpoint;
use super::frontend::{BodyFrontend, BodyPose, BodyWorker, body_stream};
use super::predictor::BodyPredictor;
use crate::{InferredPoses, RecordingStream, TaskError};

/// From detections of several cameras to joints in the world.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SpatialConfig {
    /// Accuracy of detections, and their agreement.
    pub triangulation: TriangulationConfig,
    /// The filter; none for the points themselves.
    pub filter: Option<SpatialFilterConfig>,
}

impl SpatialConfig {
    /// With the filter.
    pub fn filtered() -> Self {
        Self { filter: Some(SpatialFilterConfig::default()), ..Self::default() }
    }
}

/// A person in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct SpatialPose {
    /// Time stamp.
    pub t: Micros,
    /// Joints in metres, filtered if the config has a filter; none where fewer than two cameras
    /// agree.
    pub joints_m: WorldJoints,
    /// Triangulated joints.
    pub points: [Option<TriangulatedPoint>; BODY_JOINTS],
    /// The estimate of each camera; none before it has shown enough events.
    pub estimates: Vec<Option<PoseEstimate>>,
    /// Time that inference took, in seconds, over all cameras.
    pub delay_s: f64,
}

/// A recording of a calibrated camera.
pub struct PlacedRecording {
    stream: RecordingStream<BodyFrontend, BodyWorker>,
    camera: PlacedCamera,
}

impl PlacedRecording {
    /// The recording `windows` of a camera; with a minimum score of poses and joints as in
    /// [`BodyFrontend::with_min_score`].
    ///
    /// # Errors
    /// If the stream cannot be made for its sensor.
    pub fn new(
        windows: Windows,
        camera: PlacedCamera,
        checkpoint: &BodyCheckpoint,
        min_score: Option<f32>,
        predictor: BodyPredictor,
    ) -> Result<Self, TaskError> {
        let calibration = Calibration::of_lens(windows.sensor(), camera.lens);
        let mut stream = body_stream(checkpoint, &calibration, None, predictor)?;
        if let Some(min_score) = min_score {
            stream.frontend = stream.frontend.with_min_score(min_score);
        }
        // The schedule is that of all recordings together.
        let schedule = InferenceSchedule::NewestWhenFree;
        Ok(Self { stream: RecordingStream::new(windows, stream, schedule), camera })
    }
}

/// Recordings of one person by several cameras with one clock, read forwards in time: an iterator over
/// poses at an even rate, in the time that all recordings have.
pub struct SpatialRecordings {
    recordings: Vec<PlacedRecording>,
    every: Micros,
    /// The time of the next pose, and that up to which there are some.
    next: Micros,
    end: Micros,
    config: TriangulationConfig,
    filter: Option<SpatialFilter>,
}

impl SpatialRecordings {
    /// Joins recordings; poses are `every` apart.
    ///
    /// # Errors
    /// If one cannot be read to its end.
    pub fn new(
        mut recordings: Vec<PlacedRecording>,
        config: SpatialConfig,
        every: Micros,
    ) -> Result<Self, TaskError> {
        let (mut start, mut end) = (Micros(i64::MIN), Micros(i64::MAX));
        for PlacedRecording { stream, .. } in &mut recordings {
            // Nothing is in common with an empty one.
            let [own_start, own_end] = stream.span()?.unwrap_or([end, start]);
            (start, end) = (start.max(own_start), end.min(own_end));
        }
        let filter = config.filter.map(SpatialFilter::new);
        // At the very start, no camera has shown anything yet.
        let next = Micros(start.0.saturating_add(every.0));
        Ok(Self { recordings, every, next, end, config: config.triangulation, filter })
    }

    /// The time from the beginning to the end of what all recordings have; none if that is nothing.
    pub fn span(&self) -> Option<[Micros; 2]> {
        let start = Micros(self.next.0.saturating_sub(self.every.0));
        (start < self.end).then_some([start, self.end])
    }

    /// Remarks on the recordings, each with its number.
    pub fn warnings(&self) -> Vec<(usize, String)> {
        let of = |(index, one): (usize, &PlacedRecording)| {
            one.stream.warnings().into_iter().map(move |warning| (index, warning)).collect()
        };
        self.recordings.iter().enumerate().flat_map(|one| -> Vec<_> { of(one) }).collect()
    }

    /// The time of the next pose at which a recording is not silent.
    fn next_time(&mut self) -> Result<Micros, TaskError> {
        let mut active = Micros(i64::MAX);
        for PlacedRecording { stream, .. } in &mut self.recordings {
            active = active.min(stream.skip_silence(self.next)?);
        }
        // Whole steps are skipped, so that all poses lie on one grid of times.
        let skipped =
            (active.0.saturating_sub(self.next.0) + self.every.0 - 1).div_euclid(self.every.0);
        Ok(self.next + Micros(skipped * self.every.0))
    }

    /// The pose at `t`, which is not before the last one. Cameras are inferred in parallel.
    fn pose(&mut self, t: Micros) -> Result<SpatialPose, TaskError> {
        let one = |PlacedRecording { stream, .. }: &mut PlacedRecording| stream.infer_at(t);
        let inferred: Vec<InferredPoses<BodyPose>> =
            self.recordings.par_iter_mut().map(one).collect::<Result<_, TaskError>>()?;
        let delay_s = inferred.iter().map(|inferred| inferred.delay_s).sum();
        // Inputs are not batched here, so that each camera has one pose at most.
        let seen: Vec<Option<BodyPose>> =
            inferred.iter().map(|one| one.poses.first().map(|(_, pose)| *pose)).collect();
        let points = self.points(&seen);
        let positions = || points.map(|point| point.map(|point| point.position_m));
        let joints_m = match &mut self.filter {
            Some(filter) => filter.update(t, &points),
            None => positions(),
        };
        let estimate = |pose: BodyPose| PoseEstimate::Body {
            joints_px: pose.joints_px,
            scores: pose.detection.scores,
            score: pose.score,
        };
        let estimates = seen.into_iter().map(|pose| pose.map(estimate)).collect();
        Ok(SpatialPose { t, joints_m, points, estimates, delay_s })
    }

    fn points(&self, seen: &[Option<BodyPose>]) -> [Option<TriangulatedPoint>; BODY_JOINTS] {
        std::array::from_fn(|joint| {
            let observation = |(recording, pose): (&'_ PlacedRecording, &Option<BodyPose>)| {
                let BodyPose { detection, joints_px, .. } = pose.as_ref()?;
                Some((recording.camera, joints_px[joint]?, detection.scores[joint]))
            };
            let all: Vec<_> = self.recordings.iter().zip(seen).filter_map(observation).collect();
            let all: Vec<Observation<'_>> = all
                .iter()
                .map(|(camera, at_px, score)| Observation { camera, at_px: *at_px, score: *score })
                .collect();
            triangulate(&all, &self.config)
        })
    }
}

impl Iterator for SpatialRecordings {
    type Item = Result<SpatialPose, TaskError>;

    fn next(&mut self) -> Option<Self::Item> {
        let t = match self.next_time() {
            Ok(t) => t,
            Err(error) => return Some(Err(error)),
        };
        (t <= self.end).then(|| {
            self.next = t + self.every;
            self.pose(t)
        })
    }
}

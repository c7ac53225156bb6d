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
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::checkpoint::BodyCheckpoint;
use super::predictor::BodyPredictor;
use super::recording_stream::BodyRecordingStream;
use crate::TaskError;

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
    stream: BodyRecordingStream,
    camera: PlacedCamera,
}

impl PlacedRecording {
    /// The recording `windows` of a camera.
    ///
    /// # Errors
    /// If the stream cannot be made for its sensor.
    pub fn new(
        windows: Windows,
        camera: PlacedCamera,
        checkpoint: &BodyCheckpoint,
        predictor: BodyPredictor,
    ) -> Result<Self, TaskError> {
        let calibration = Calibration::of_lens(windows.sensor(), camera.lens);
        let of = BodyRecordingStream::of_camera;
        let stream = of(windows, &calibration, checkpoint, None, predictor)?;
        Ok(Self { stream, camera })
    }

    /// The same with a minimum score of poses and joints.
    #[must_use]
    pub fn with_min_score(mut self, min_score: f32) -> Self {
        self.stream = self.stream.with_min_score(min_score);
        self
    }
}

/// Recordings of one person by several cameras with one clock, read forwards in time.
pub struct SpatialRecordings {
    recordings: Vec<PlacedRecording>,
    config: TriangulationConfig,
    filter: Option<SpatialFilter>,
}

impl SpatialRecordings {
    /// Joins recordings.
    pub fn new(recordings: Vec<PlacedRecording>, config: SpatialConfig) -> Self {
        let filter = config.filter.map(SpatialFilter::new);
        Self { recordings, config: config.triangulation, filter }
    }

    /// The time span that all recordings have; none if they have none in common.
    ///
    /// # Errors
    /// If one cannot be read to its end.
    pub fn span(&mut self) -> Result<Option<[Micros; 2]>, TaskError> {
        let (mut start, mut end) = (None, None);
        for PlacedRecording { stream, .. } in &mut self.recordings {
            let Some(own) = stream.start() else { return Ok(None) };
            start = Some(start.map_or(own, |start: Micros| start.max(own)));
            let own = stream.end()?;
            end = Some(end.map_or(own, |end: Micros| end.min(own)));
        }
        Ok(start.zip(end).filter(|(start, end)| start < end).map(|(start, end)| [start, end]))
    }

    /// Remarks on the recordings, each with its number.
    pub fn warnings(&self) -> Vec<(usize, String)> {
        let of = |(index, one): (usize, &PlacedRecording)| {
            one.stream.warnings().into_iter().map(move |warning| (index, warning)).collect()
        };
        self.recordings.iter().enumerate().flat_map(|one| -> Vec<_> { of(one) }).collect()
    }

    /// The pose at `t`, which is not before the last one. Cameras are inferred in parallel.
    ///
    /// # Errors
    /// If a recording cannot be read up to there, or the network fails.
    pub fn pose(&mut self, t: Micros) -> Result<SpatialPose, TaskError> {
        let one = |recording: &mut PlacedRecording| recording.stream.pose(t);
        let estimates: Vec<(Option<PoseEstimate>, f64)> =
            self.recordings.par_iter_mut().map(one).collect::<Result<_, TaskError>>()?;
        let delay_s = estimates.iter().map(|(_, delay_s)| delay_s).sum();
        let seen: Vec<_> = estimates.into_iter().map(|(estimate, _)| estimate).collect();
        let points = self.points(&seen);
        let positions = || points.map(|point| point.map(|point| point.position_m));
        let joints_m = match &mut self.filter {
            Some(filter) => filter.update(t, &points),
            None => positions(),
        };
        Ok(SpatialPose { joints_m, points, estimates: seen, delay_s })
    }

    fn points(&self, seen: &[Option<PoseEstimate>]) -> [Option<TriangulatedPoint>; BODY_JOINTS] {
        std::array::from_fn(|joint| {
            let observation = |(recording, estimate): (&'_ PlacedRecording, _)| match estimate {
                &Some(PoseEstimate::Body { joints_px, scores, .. }) => {
                    Some((recording.camera, joints_px[joint]?, scores[joint]))
                }
                _ => None,
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

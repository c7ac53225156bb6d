//! A recording through a baseline: events to poses.

use std::path::Path;
use std::time::Instant;

use evpose_camera::Calibration;
use evpose_core::{LensCamera, Micros, SensorSize};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_pose::metric::body::BodyPrediction;
use glam::{Vec2, Vec3};

use super::checkpoint::{BaselineCheckpoint, PUBLISHED_TORSO_M};
use super::geometry::LiftGeometry;
use super::predictor::BaselinePredictor;
use crate::TaskError;
use crate::body::RepresentationReader;

/// A pose of a baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaselinePose {
    /// Time stamp in seconds: that of the newest event.
    pub t_s: f64,
    /// Time from the image to the pose, in seconds.
    pub delay_s: f64,
    /// Joints in pixels of the sensor; none where a joint was not found.
    pub joints_px: BodyPoints,
    /// Scores, 0 to 1.
    pub scores: [f32; BODY_JOINTS],
    /// Joints in metres in camera space: x right, y up, looking along -z. None of `dhp19-cnn`,
    /// which needs two cameras.
    pub joints_m: [Option<Vec3>; BODY_JOINTS],
}

impl BaselinePose {
    /// The pose on the image, as evaluations take it.
    pub fn prediction(&self) -> BodyPrediction {
        let Self { t_s, delay_s, joints_px, .. } = *self;
        BodyPrediction { t_s, delay_s, joints_px }
    }
}

/// A recording, read forwards in time.
pub struct BaselineStream {
    reader: RepresentationReader,
    predictor: BaselinePredictor,
    geometry: LiftGeometry,
    torso_m: f32,
}

impl BaselineStream {
    /// Opens a recording of a camera; without one, a field of view is guessed, and joints in metres
    /// are in proportion to it.
    ///
    /// # Errors
    /// If it cannot be read, or the representation not be made.
    pub fn open(
        path: &Path,
        checkpoint: &BaselineCheckpoint,
        camera: Option<LensCamera>,
    ) -> Result<Self, TaskError> {
        let reader = RepresentationReader::open(path, &checkpoint.config.body().image)?;
        let sensor = reader.sensor();
        let camera = camera.unwrap_or_else(|| Calibration::guessed(sensor).camera);
        let geometry = LiftGeometry::new(camera, sensor);
        Ok(Self {
            reader,
            predictor: BaselinePredictor::new(checkpoint),
            geometry: match checkpoint.depths_m {
                Some(depths_m) => geometry.within_depths(depths_m),
                None => geometry,
            },
            torso_m: checkpoint.torso_m.unwrap_or(PUBLISHED_TORSO_M),
        })
    }

    /// The sensor.
    pub fn sensor(&self) -> SensorSize {
        self.reader.sensor()
    }

    /// When the recording begins; none if it is empty.
    pub fn start(&self) -> Option<Micros> {
        self.reader.start()
    }

    /// When it ends.
    ///
    /// # Errors
    /// If it cannot be read to its end.
    pub fn end(&mut self) -> Result<Micros, TaskError> {
        self.reader.end()
    }

    /// The pose at `t`, which is not before the last one.
    ///
    /// # Errors
    /// If the recording cannot be read up to there.
    pub fn pose(&mut self, t: Micros) -> Result<BaselinePose, TaskError> {
        let image = self.reader.at(t, |_| {})?;
        let begin = Instant::now();
        let joints = self.predictor.predict(&image);
        let size = Vec2::new(image.width() as f32, image.height() as f32);
        let view_px = joints.points.map(|point| Some(point? * size));
        let joints_px = self.reader.sensor_points(&view_px);
        let joints_m = match &joints.depths {
            Some(depths) => self.geometry.joints_m(&joints_px, depths, self.torso_m),
            None => [None; BODY_JOINTS],
        };
        Ok(BaselinePose {
            t_s: t.as_seconds(),
            delay_s: begin.elapsed().as_secs_f64(),
            joints_px,
            scores: joints.scores,
            joints_m,
        })
    }
}

impl std::fmt::Debug for BaselineStream {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BaselineStream").field("sensor", &self.sensor()).finish_non_exhaustive()
    }
}

//! The stream of a baseline: events to images of a representation, and joints on them to poses.

use evpose_camera::Calibration;
use evpose_core::{EventStream, LensCamera, Micros, Plane, SensorSize};
use evpose_pose::body::{BODY_JOINTS, BodyPoints, pose_score};
use evpose_pose::stream::{InferenceWorker, PoseStream, StreamError, StreamFrontend};
use evpose_pose::{PoseEstimate, PoseOrigin};
use evpose_repr::Representation;
use glam::{Vec2, Vec3};

use super::checkpoint::BaselineCheckpoint;
use super::lift_mono::{LiftGeometry, PUBLISHED_TORSO_M};
use super::predictor::{BaselineJoints, BaselinePredictor};
use crate::TaskError;
use crate::body::{CanonicalEvents, start_representation};

/// A pose of a baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaselinePose {
    /// Joints in pixels of the sensor; none where a joint was not found.
    pub joints_px: BodyPoints,
    /// Scores, 0 to 1.
    pub scores: [f32; BODY_JOINTS],
    /// Joints in metres in camera space: x right, y up, looking along -z. None of `dhp19-cnn`,
    /// which needs two cameras.
    pub joints_m: [Option<Vec3>; BODY_JOINTS],
}

/// The stream of a baseline, for events of `sensor`; without its camera, a field of view is guessed, and
/// joints in metres are in proportion to it.
///
/// # Errors
/// If the representation cannot be made.
pub fn baseline_stream(
    checkpoint: &BaselineCheckpoint,
    sensor: SensorSize,
    camera: Option<LensCamera>,
) -> Result<PoseStream<BaselineFrontend, BaselinePredictor>, TaskError> {
    let (image, guessed) = (checkpoint.config.body().image, Calibration::guessed(sensor));
    let canonical = CanonicalEvents::new(&image, &guessed);
    let geometry = LiftGeometry::new(camera.unwrap_or(guessed.camera), sensor);
    let frontend = BaselineFrontend {
        representation: start_representation(&image, canonical.size())?,
        canonical,
        geometry: match checkpoint.depths_m {
            Some(depths_m) => geometry.within_depths(depths_m),
            None => geometry,
        },
        torso_m: checkpoint.torso_m.unwrap_or(PUBLISHED_TORSO_M),
        last_pose: None,
    };
    Ok(PoseStream::new(frontend, BaselinePredictor::new(checkpoint)))
}

/// Follows the events of a person.
#[derive(Debug)]
pub struct BaselineFrontend {
    canonical: CanonicalEvents,
    representation: Box<dyn Representation>,
    geometry: LiftGeometry,
    torso_m: f32,
    last_pose: Option<BaselinePose>,
}

impl StreamFrontend for BaselineFrontend {
    type Input = Plane<u8>;
    type Output = BaselineJoints;
    type Pose = BaselinePose;

    fn push(&mut self, events: &EventStream) -> Result<(), StreamError> {
        self.representation.push(self.canonical.push(events));
        Ok(())
    }

    fn input(&mut self, t: Micros, memory: Option<Plane<u8>>) -> Option<Plane<u8>> {
        self.representation.advance(t);
        let mut image = memory.unwrap_or_else(|| Plane::for_sensor(self.canonical.size(), 0));
        self.representation.render_u8(image.data_mut());
        Some(image)
    }

    fn accept(
        &mut self,
        t: Micros,
        image: &Plane<u8>,
        joints: BaselineJoints,
        _now: Micros,
    ) -> Vec<(Micros, BaselinePose)> {
        let size = Vec2::new(image.width() as f32, image.height() as f32);
        let view_px = joints.points.map(|point| Some(point? * size));
        let joints_px = self.canonical.sensor_points(&view_px);
        // The lens is that of the sensor, so that rays start from positions there.
        let joints_m = match &joints.depths {
            Some(depths) => self.geometry.joints_m(&joints_px, depths, self.torso_m),
            None => [None; BODY_JOINTS],
        };
        let pose = BaselinePose { joints_px, scores: joints.scores, joints_m };
        self.last_pose = Some(pose);
        vec![(t, pose)]
    }

    fn estimate(&self, pose: &BaselinePose) -> PoseEstimate {
        let BaselinePose { joints_px, scores, .. } = *pose;
        PoseEstimate::Body { joints_px, scores, score: pose_score(&scores) }
    }

    fn propagate(&mut self, _t: Micros) -> Option<PoseEstimate> {
        Some(self.estimate(&self.last_pose?))
    }

    fn origin_between(&self) -> PoseOrigin {
        PoseOrigin::Held
    }

    fn reset(&mut self) {
        self.canonical.reset();
        self.representation.reset();
        self.last_pose = None;
    }
}

impl InferenceWorker for BaselinePredictor {
    type Input = Plane<u8>;
    type Output = BaselineJoints;

    fn infer(&mut self, image: &Plane<u8>) -> Result<BaselineJoints, StreamError> {
        Ok(self.predict(image))
    }

    fn reset(&mut self) {
        self.forget();
    }
}

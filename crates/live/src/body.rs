//! Bodies online: an EROS asked for at the network's pace, and velocities of events in between.

use evpose_core::{EventStream, Micros, Plane, SensorSize};
use evpose_pose::body::fusion::ScoredPoints;
use evpose_pose::body::{BODY_JOINTS, BodyFollower, BodyJoint};
use evpose_repr::{
    BlurWork, ChannelOrder, GaussianKernel, Representation, StreamWindow, representation_called,
};
use evpose_train::body::{BetweenConfig, BodyCheckpoint, BodyPredictor, BodyPredictorOptions};

use crate::{Answer, Eye, LiveError, Network, Task};

/// Window of representations that have one.
const WINDOW: Micros = Micros(100_000);

/// A network of bodies before events of `sensor`.
///
/// # Errors
/// If the representation is not known, the network cannot be compiled, or a setting is out of range.
pub fn body_task(
    checkpoint: &BodyCheckpoint,
    sensor: SensorSize,
    between: &BetweenConfig,
    options: BodyPredictorOptions,
) -> Result<Task<BodyEye, BodyNetwork>, LiveError> {
    let image = &checkpoint.config.image;
    let window = StreamWindow::new(sensor, WINDOW, ChannelOrder::OffFirst).map_err(failed)?;
    let surface = representation_called(&image.representation).map_err(failed)?.start(window);
    let BetweenConfig { velocity, fusion, fewest_samples, .. } = between;
    let follower = BodyFollower::new(sensor, *velocity, fusion, *fewest_samples).map_err(failed)?;
    let predictor = BodyPredictor::new(checkpoint, options, None).map_err(failed)?;
    Ok(Task {
        eye: BodyEye { sensor, surface, follower, scores: None },
        network: BodyNetwork {
            predictor,
            blur: image.blur,
            work: BlurWork::default(),
            blurred: Plane::filled(0, 0, 0),
        },
    })
}

pub(crate) fn failed(error: impl std::error::Error + Send + Sync + 'static) -> LiveError {
    LiveError::Task(Box::new(error))
}

/// Follows the events of somebody's body.
#[derive(Debug)]
pub struct BodyEye {
    sensor: SensorSize,
    surface: Box<dyn Representation>,
    follower: BodyFollower,
    /// Of the network's last answer.
    scores: Option<[f32; BODY_JOINTS]>,
}

impl Eye for BodyEye {
    type Image = Plane<u8>;
    type Found = Vec<BodyJoint>;

    fn push(&mut self, events: &EventStream) -> Result<(), LiveError> {
        self.surface.push(events);
        self.follower.push(events);
        Ok(())
    }

    fn image(&mut self, t: Micros, memory: Option<Plane<u8>>) -> Option<Plane<u8>> {
        let mut image = memory.unwrap_or_else(|| Plane::for_sensor(self.sensor, 0));
        self.surface.advance(t);
        self.surface.render_u8(image.data_mut());
        Some(image)
    }

    fn found(
        &mut self,
        t: Micros,
        _image: &Plane<u8>,
        joints: Vec<BodyJoint>,
        now: Micros,
    ) -> Vec<(Micros, Answer)> {
        let ScoredPoints { points: joints_px, scores } =
            ScoredPoints::in_image(&joints, self.sensor);
        self.follower.detection(t, &ScoredPoints { points: joints_px, scores }, now);
        self.scores = Some(scores);
        vec![(t, Answer::Body { joints_px, scores })]
    }

    fn between(&mut self, t: Micros) -> Option<Answer> {
        let scores = self.scores?;
        Some(Answer::Body { joints_px: self.follower.at(t), scores })
    }

    fn reset(&mut self) {
        self.surface.reset();
        self.follower.reset();
        self.scores = None;
    }
}

/// Finds joints on surfaces.
pub struct BodyNetwork {
    predictor: BodyPredictor,
    blur: Option<GaussianKernel>,
    work: BlurWork,
    blurred: Plane<u8>,
}

impl Network for BodyNetwork {
    type Image = Plane<u8>;
    type Found = Vec<BodyJoint>;

    fn look(&mut self, image: &Plane<u8>) -> Result<Vec<BodyJoint>, LiveError> {
        let Some(kernel) = self.blur else { return Ok(self.predictor.joints(image)) };
        kernel.blur(image, &mut self.work, &mut self.blurred);
        Ok(self.predictor.joints(&self.blurred))
    }
}

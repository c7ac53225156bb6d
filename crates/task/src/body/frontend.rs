//! The body's stream: a representation at the network's pace, and velocities of events in between.

use evpose_core::{EventStream, Micros, Plane, SensorSize};
use evpose_pose::body::fusion::ScoredPoints;
use evpose_pose::body::{BodyFollower, BodyJoint, BodyPoints, PresenceScore, pose_score};
use evpose_pose::filter::{BodyFilter, BodyFilterConfig};
use evpose_pose::stream::{
    InferenceWorker, PoseStream, RemainingEvents, StreamError, StreamFrontend,
};
use evpose_pose::{PoseEstimate, PoseOrigin};
use evpose_repr::{
    BlurWork, ChannelOrder, GaussianKernel, Representation, StreamWindow, representation_by_name,
};

use super::batch::ImageBatch;
use super::canonical_events::CanonicalEvents;
use super::checkpoint::BodyCheckpoint;
use super::config::BodyImageConfig;
use super::predictor::BodyPredictor;
use super::propagation::PropagationConfig;
use super::recent_events::RecentEvents;
use crate::TaskError;
use evpose_camera::Calibration;

const WINDOW: Micros = Micros(100_000);

/// The representation of a config, for events of `sensor`.
///
/// # Errors
/// If it is not known, or cannot be made for such a sensor.
pub(crate) fn start_representation(
    image: &BodyImageConfig,
    sensor: SensorSize,
) -> Result<Box<dyn Representation>, TaskError> {
    let window = StreamWindow::new(sensor, WINDOW, ChannelOrder::OffFirst)?;
    Ok(representation_by_name(&image.representation)?.start(window))
}

/// The blur of the representation's images, if the config has one.
#[derive(Debug)]
pub(super) struct Blur {
    kernel: Option<GaussianKernel>,
    work: BlurWork,
    blurred: Vec<Plane<u8>>,
}

impl Blur {
    pub(super) fn new(kernel: Option<GaussianKernel>) -> Self {
        Self { kernel, work: BlurWork::default(), blurred: Vec::new() }
    }

    pub(super) fn apply<'a>(&'a mut self, images: &'a [Plane<u8>]) -> Vec<&'a Plane<u8>> {
        let Some(kernel) = self.kernel else { return images.iter().collect() };
        // It never shrinks, so that a batch after a short one allocates nothing.
        let count = self.blurred.len().max(images.len());
        self.blurred.resize_with(count, || Plane::filled(0, 0, 0));
        for (image, blurred) in images.iter().zip(&mut self.blurred) {
            kernel.blur(image, &mut self.work, blurred);
        }
        self.blurred[..images.len()].iter().collect()
    }
}

/// The stream of a network of bodies, for events of the camera of `calibration`. Without
/// `propagation`, a pose stands until the next one.
///
/// # Errors
/// If the representation is not known, the network cannot be compiled, or a setting is out of
/// range.
pub fn body_stream(
    checkpoint: &BodyCheckpoint,
    calibration: &Calibration,
    propagation: Option<&PropagationConfig>,
    predictor: BodyPredictor,
) -> Result<PoseStream<BodyFrontend, BodyWorker>, TaskError> {
    let image = &checkpoint.config.image;
    let sensor = calibration.sensor;
    let canonical = CanonicalEvents::new(image, calibration);
    let follower = propagation
        .map(|PropagationConfig { velocity, fusion, min_samples, .. }| {
            BodyFollower::new(sensor, *velocity, fusion, *min_samples)
        })
        .transpose()?;
    let detection = checkpoint.config.detection;
    let frontend = BodyFrontend {
        representation: start_representation(image, canonical.size())?,
        min_score: detection.min_score,
        // The decoder has applied the confidence of the config already.
        min_joint_score: 0.0,
        presence: PresenceScore::new(1e-3 * f64::from(detection.memory_ms)),
        min_events: detection.min_events(canonical.size()),
        recent: RecentEvents::new(canonical.size()),
        canonical,
        events: 0,
        follower,
        last_pose: None,
        batch: 1,
        pending: ImageBatch::default(),
        skipped: Vec::new(),
        filter: None,
    };
    Ok(PoseStream::new(frontend, BodyWorker { predictor, blur: Blur::new(image.blur) }))
}

/// A pose of a person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPose {
    /// Joints of the network on the sensor, in pixels, with their scores.
    pub detection: ScoredPoints,
    /// The same through the temporal filter; unchanged without one.
    pub joints_px: BodyPoints,
    /// Score of the pose, 0 to 1.
    pub score: f32,
}

/// Follows the events of a person.
#[derive(Debug)]
pub struct BodyFrontend {
    canonical: CanonicalEvents,
    representation: Box<dyn Representation>,
    recent: RecentEvents,
    /// Poses of a lower score are of nobody.
    min_score: f32,
    /// Joints of a lower score are not reported, beside those that the decoder leaves out.
    min_joint_score: f32,
    presence: PresenceScore,
    /// Events of the canonical view so far, and before the first inference.
    events: u64,
    min_events: u64,
    /// None if poses are not propagated.
    follower: Option<BodyFollower>,
    last_pose: Option<BodyPose>,
    /// Images per inference, and those of the next one.
    batch: usize,
    pending: ImageBatch,
    /// Times since the last stride with too few events.
    skipped: Vec<Micros>,
    /// Smooths reported joints; none for those of the network.
    filter: Option<BodyFilter>,
}

impl BodyFrontend {
    /// The same with `batch` images per inference, one of each stride: poses wait for the last one.
    #[must_use]
    pub fn with_batch(self, batch: usize) -> Self {
        Self { batch: batch.max(1), ..self }
    }

    /// Adds the image at `t` to the batch, once there have been enough events.
    fn sample(&mut self, t: Micros) {
        if self.events < self.min_events {
            self.skipped.push(t);
            return;
        }
        self.representation.advance(t);
        let image = self.pending.add(self.canonical.size(), t, self.recent.extent());
        self.representation.render_u8(image.data_mut());
    }

    /// Takes the joints of the image of `t`, known at `now`.
    fn accept_one(&mut self, t: Micros, joints: &[BodyJoint], now: Micros) -> (Micros, BodyPose) {
        let mut detection = ScoredPoints::in_image(joints, self.canonical.size());
        detection.points = self.canonical.sensor_points(&detection.points);
        // Presence takes the scores of all joints, also of those that are not reported.
        let score = self.presence.update(t, pose_score(&detection.scores));
        let detection = self.reported(detection, score);
        if let Some(follower) = &mut self.follower {
            if detection.points.iter().any(Option::is_some) {
                follower.detection(t, &detection, now);
            } else {
                // Somebody who comes back is somewhere else.
                follower.forget_detections();
            }
        }
        let joints_px = match &mut self.filter {
            Some(filter) => filter.update(t, &detection),
            None => detection.points,
        };
        let pose = BodyPose { detection, joints_px, score };
        self.last_pose = Some(pose);
        (t, pose)
    }

    /// The same with the temporal filter of the checkpoint's config on the joints of poses; propagated
    /// ones have a filter of their own.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn with_filter(self, config: BodyFilterConfig) -> Result<Self, TaskError> {
        Ok(Self { filter: Some(BodyFilter::new(config)?), ..self })
    }

    /// The same with a minimum score of poses, instead of the checkpoint's, and of joints.
    #[must_use]
    pub fn with_min_score(self, min_score: f32) -> Self {
        Self { min_score, min_joint_score: min_score, ..self }
    }

    /// Leaves out what scores too low: joints, or all of them in a pose of this score.
    fn reported(&self, mut detection: ScoredPoints, score: f32) -> ScoredPoints {
        let is_there = score >= self.min_score;
        for (point, score) in detection.points.iter_mut().zip(detection.scores) {
            *point = point.filter(|_| is_there && score >= self.min_joint_score);
        }
        detection
    }
}

impl StreamFrontend for BodyFrontend {
    type Input = ImageBatch;
    type Output = Vec<Vec<BodyJoint>>;
    type Pose = BodyPose;

    fn push(&mut self, events: &EventStream) -> Result<(), StreamError> {
        let view_events = self.canonical.push(events);
        self.events += view_events.len() as u64;
        self.representation.push(view_events);
        self.recent.push(view_events);
        if let Some(follower) = &mut self.follower {
            // The follower works in pixels of the sensor, as its joints do.
            follower.push(events);
        }
        Ok(())
    }

    fn stride(&mut self, t: Micros) {
        self.skipped.clear();
        if self.batch > 1 {
            // The network had no time for a full batch: newer images replace it.
            if self.pending.len() >= self.batch {
                self.pending.clear();
            }
            self.sample(t);
        }
    }

    fn input(&mut self, t: Micros, memory: Option<ImageBatch>) -> Option<ImageBatch> {
        // Without a batch, an image is rendered only when the network is free.
        if self.batch == 1 {
            self.pending.clear();
            self.sample(t);
        }
        if self.pending.len() < self.batch {
            return None;
        }
        let mut next = memory.unwrap_or_default();
        next.clear();
        Some(std::mem::replace(&mut self.pending, next))
    }

    fn accept(
        &mut self,
        _t: Micros,
        batch: &ImageBatch,
        joints: Vec<Vec<BodyJoint>>,
        now: Micros,
    ) -> Vec<(Micros, Self::Pose)> {
        let each = batch.times().iter().zip(joints);
        each.map(|(t, joints)| self.accept_one(*t, &joints, now)).collect()
    }

    fn rest(&mut self) -> Option<ImageBatch> {
        let rest = std::mem::take(&mut self.pending);
        (!rest.is_empty()).then_some(rest)
    }

    fn remarks(&self) -> Vec<String> {
        let lost = self.canonical.has_lost_polarities().then(|| {
            "polarities say nothing: events are pooled to the network's view without them"
                .to_owned()
        });
        lost.into_iter().collect()
    }

    fn remaining_events(&self) -> Vec<RemainingEvents> {
        self.canonical.remaining()
    }

    fn skipped(&mut self) -> Vec<Micros> {
        std::mem::take(&mut self.skipped)
    }

    fn estimate(&self, pose: &BodyPose) -> PoseEstimate {
        let BodyPose { detection, joints_px, score } = *pose;
        PoseEstimate::Body { joints_px, scores: detection.scores, score }
    }

    fn propagate(&mut self, t: Micros) -> Option<PoseEstimate> {
        let pose = self.last_pose?;
        let joints_px = self.follower.as_mut().map_or(pose.joints_px, |follower| follower.at(t));
        Some(self.estimate(&BodyPose { joints_px, ..pose }))
    }

    fn origin_between(&self) -> PoseOrigin {
        if self.follower.is_some() { PoseOrigin::Propagated } else { PoseOrigin::Held }
    }

    fn reset(&mut self) {
        self.canonical.reset();
        self.events = 0;
        self.presence.reset();
        self.representation.reset();
        self.recent.reset();
        if let Some(follower) = &mut self.follower {
            follower.reset();
        }
        if let Some(filter) = &mut self.filter {
            filter.reset();
        }
        self.last_pose = None;
        self.pending.clear();
    }
}

/// Detects joints on images of the representation.
pub struct BodyWorker {
    predictor: BodyPredictor,
    blur: Blur,
}

impl BodyWorker {
    /// The network's inputs for a batch, those of the first pass, each `[3][side][side]`.
    pub fn first_inputs(&mut self, batch: &ImageBatch) -> Vec<f32> {
        let images = self.blur.apply(batch.images());
        images.into_iter().flat_map(|image| self.predictor.input(image).to_vec()).collect()
    }
}

impl InferenceWorker for BodyWorker {
    type Input = ImageBatch;
    type Output = Vec<Vec<BodyJoint>>;

    fn infer(&mut self, batch: &ImageBatch) -> Result<Vec<Vec<BodyJoint>>, StreamError> {
        Ok(self.predictor.joints_of(&self.blur.apply(batch.images()), batch.extents()))
    }
}

//! The hand's stream: inputs for the network by a schedule, and a filter of its poses.
//!
//! # Model
//! * Every so often, plain: inputs are inferred in batches and smoothed by the published Kalman filter.
//!   The pose at `k` ms is that of the events before, as in training: record `k` of a `.meta` is the pose at
//!   the end of frame `k`. The first is that of the first full window.
//! * Triggered, the slow-motion mode: an input is taken at the event that triggers one, from the first full
//!   window on. Batches of a scene at rest repeat earlier poses, and the filter has two settings.
//! * The newest when the network is free, online: an input is due when time has passed and events have come. A
//!   network that takes one input gets the newest; one that takes a batch gets the newest batch that is full.
//!   Inputs of a scene at rest are not inferred: the last pose stands. Between two poses the last one is held.
//!
//! # Source
//! EventHands, live pipeline; there the filter's poses come with those of the network alone.

use evpose_core::{EventStream, Micros};
use evpose_io::Windows;
use evpose_pose::stream::{
    InferenceSchedule, InferenceWorker, PoseStream, RemainingEvents, StreamError, StreamFrontend,
};
use evpose_pose::{HandPose, HandSide, PoseEstimate, PoseOrigin};
use evpose_repr::RepresentationTrigger;

use super::batch::InputBatch;
use super::config::HandConfig;
use super::estimator::{HandEstimate, HandEstimator, PresenceCounts};
use super::predictor::Predictor;
use super::view::{HandView, canonical_view};
use crate::event_steps::{denoised, pooled};
use crate::{RecordingStream, TaskError};
use evpose_camera::{Calibration, ViewAdaptor};
use glam::Vec2;

/// A frame of labels, at whose ends the plain pipeline has its poses.
const FRAME: Micros = Micros(1_000);
/// Inputs of one inference of a recording: enough to occupy every thread, few enough for the memory.
const PLAIN_BATCH: usize = 64;

/// The stream of a network of hands, for events of the camera of `calibration`, with `batch` inputs
/// per inference.
///
/// # Errors
/// If the representation is not known, the hand cannot be made, or a setting is out of range.
pub fn hand_stream<P: Predictor>(
    config: &HandConfig,
    predictor: P,
    calibration: &Calibration,
    schedule: InferenceSchedule,
    batch: usize,
) -> Result<PoseStream<HandFrontend, HandWorker<P>>, TaskError> {
    let config = &config.for_camera(calibration);
    let adaptor = ViewAdaptor::new(calibration, &canonical_view(config));
    let sensor = adaptor.view().sensor;
    let window = config.representation.window();
    let is_plain = matches!(schedule, InferenceSchedule::Every(_));
    let estimator = HandEstimator::new(config, sensor, batch, is_plain)?;
    let frontend = HandFrontend {
        schedule,
        window,
        view_events: EventStream::empty(sensor),
        events_in_view: 0,
        estimator,
        trigger: RepresentationTrigger::new(&config.slow_motion.trigger, sensor),
        first_event: None,
        is_due: false,
        repeated: Vec::new(),
        last: None,
        view: HandView::new(config)?.seen_by(&adaptor),
        adaptor,
        // A network of both hands does not distinguish them.
        side: config.simulation.hands.side(0),
    };
    let size = (usize::from(sensor.height), usize::from(sensor.width));
    let mut worker = HandWorker { predictor, size };
    if schedule == InferenceSchedule::NewestWhenFree {
        // The first inference compiles the network: it must not delay the first pose.
        let warm_up = InputBatch::without_events(sensor, frontend.estimator.batch);
        worker.predictor.predict(warm_up.values(), size)?;
    }
    Ok(PoseStream::new(frontend, worker))
}

/// A recording `windows` of a camera through the stream of a network of hands: plain or in slow motion,
/// by the schedule.
///
/// # Errors
/// As [`hand_stream`].
pub fn hand_recording<P: Predictor>(
    config: &HandConfig,
    predictor: P,
    windows: Windows,
    calibration: &Calibration,
    schedule: InferenceSchedule,
) -> Result<RecordingStream<HandFrontend, HandWorker<P>>, TaskError> {
    let batch = match schedule {
        InferenceSchedule::Every(_) => PLAIN_BATCH,
        _ => config.slow_motion.batch_inputs,
    };
    let stream = hand_stream(config, predictor, calibration, schedule, batch)?;
    Ok(RecordingStream::new(windows, stream, schedule))
}

/// Follows the events of a hand.
#[derive(Debug)]
pub struct HandFrontend {
    schedule: InferenceSchedule,
    window: Micros,
    adaptor: ViewAdaptor,
    view_events: EventStream,
    events_in_view: u64,
    estimator: HandEstimator,
    trigger: RepresentationTrigger,
    first_event: Option<Micros>,
    is_due: bool,
    /// Poses of the last batch, of a scene at rest.
    repeated: Vec<HandEstimate>,
    /// The last pose, which stands until the next one. Events between two are in no window yet, and the velocity that
    /// the filter knows is that of its noise: extrapolated by it, poses were three times as wrong as held ones. None
    /// while there is no hand.
    last: Option<HandPose>,
    view: HandView,
    side: HandSide,
}

impl HandFrontend {
    /// Sets whether the network sees the mirror image of the view: of a hand of the other side.
    pub fn mirror(&mut self, is_mirrored: bool) {
        self.view.is_mirrored = is_mirrored;
    }

    /// Sets the length of the hand in metres, from the wrist along the bones to the tip of the middle finger:
    /// positions in metres follow it. The mean hand's otherwise.
    pub fn hand_length(&mut self, length_m: f32) {
        self.view.set_hand_length(length_m);
    }

    /// How often no hand was in view so far.
    pub fn presence(&self) -> PresenceCounts {
        self.estimator.presence
    }

    /// The position in the network's image of one on the sensor, both in pixels; none where the camera's
    /// lens has no inverse.
    pub fn view_from_sensor(&self, sensor_px: Vec2) -> Option<Vec2> {
        self.view.view_from_sensor(sensor_px)
    }

    /// A pose of the network's on the sensor; of the other hand, in the mirror image.
    pub fn pose(&self, pose: HandPose) -> PoseEstimate {
        self.view.estimate(self.side, &pose)
    }

    /// Whether inputs are taken at every stride, whatever the events.
    fn is_plain(&self) -> bool {
        matches!(self.schedule, InferenceSchedule::Every(_))
    }

    /// The batch for the network; none while it is not full, or of a scene at rest.
    fn batch(&mut self, memory: Option<InputBatch>) -> Option<InputBatch> {
        self.repeated = self.estimator.repeat_at_rest().unwrap_or_default();
        self.repeated.is_empty().then(|| self.estimator.take(memory.unwrap_or_default()))
    }
}

impl StreamFrontend for HandFrontend {
    type Input = InputBatch;
    type Output = Vec<HandPose>;
    type Pose = HandEstimate;

    fn push(&mut self, events: &EventStream) -> Result<(), StreamError> {
        self.adaptor.push(events, &mut self.view_events);
        if self.view.is_mirrored {
            self.view_events = mirrored(&self.view_events);
        }
        let events = &self.view_events;
        self.events_in_view += events.len() as u64;
        self.estimator.push(events);
        let Some(&first) = events.t().first().filter(|_| !self.is_plain()) else { return Ok(()) };
        // Recordings wait for a full window; online, the newest counts.
        let first = *self.first_event.get_or_insert(first);
        let is_online = self.schedule == InferenceSchedule::NewestWhenFree;
        let mut from = 0;
        while let Some(taken) = self.trigger.due(&events.t()[from..]) {
            from += taken;
            self.is_due |= is_online || events.t()[from - 1] - first >= self.window;
        }
        Ok(())
    }

    fn stride(&mut self, t: Micros) {
        self.estimator.skipped.clear();
        if self.is_plain() {
            // A stride is a microsecond before the end of a frame, and a label is that of the end.
            self.estimator.sample(t, t + Micros(1));
        } else if self.estimator.batch > 1 && std::mem::take(&mut self.is_due) {
            // The network had no time for a full batch: newer inputs replace it.
            if self.estimator.is_full() {
                self.estimator.pending.clear();
            }
            self.estimator.sample(t, t);
        }
    }

    fn input(&mut self, t: Micros, memory: Option<InputBatch>) -> Option<InputBatch> {
        if self.estimator.batch == 1 && !self.is_plain() {
            if !std::mem::take(&mut self.is_due) {
                return None;
            }
            self.estimator.pending.clear();
            self.estimator.sample(t, t);
        }
        self.estimator.is_full().then(|| self.batch(memory))?
    }

    fn rest(&mut self) -> Option<InputBatch> {
        (!self.estimator.pending.is_empty()).then(|| self.batch(None))?
    }

    fn repeated(&mut self) -> Vec<(Micros, HandEstimate)> {
        self.repeated.drain(..).map(|estimate| (estimate.t, estimate)).collect()
    }

    fn first_stride(&self, begin: Micros, step: Micros) -> Micros {
        // Frames whose number is a multiple of the step.
        let full = frame_end(begin) - FRAME + self.window;
        frame_end(Micros((full.0 + step.0 - 1).div_euclid(step.0) * step.0)) - Micros(1)
    }

    fn earliest_trigger(&self) -> Option<Micros> {
        self.trigger.earliest()
    }

    fn last_stride(&self, last: Micros) -> Micros {
        frame_end(last) - Micros(1)
    }

    fn remarks(&self) -> Vec<String> {
        let lost = self.adaptor.has_lost_polarities().then(|| {
            "polarities say nothing, and a network of hands sees ON and OFF apart: poses are less \
             accurate"
                .to_owned()
        });
        lost.into_iter().collect()
    }

    fn remaining_events(&self) -> Vec<RemainingEvents> {
        let in_view = pooled(&self.adaptor, self.events_in_view);
        let in_view = (!self.adaptor.is_identity()).then_some(in_view);
        in_view.into_iter().chain(self.estimator.events_after_filter().map(denoised)).collect()
    }

    fn skipped(&mut self) -> Vec<Micros> {
        std::mem::take(&mut self.estimator.skipped)
    }

    fn accept(
        &mut self,
        _t: Micros,
        batch: &InputBatch,
        outputs: Vec<HandPose>,
        _now: Micros,
    ) -> Vec<(Micros, HandEstimate)> {
        let estimates = self.estimator.accept(batch, outputs);
        self.last = estimates.last().map(|estimate| estimate.filtered);
        estimates.into_iter().map(|estimate| (estimate.t, estimate)).collect()
    }

    fn estimate(&self, estimate: &HandEstimate) -> PoseEstimate {
        self.pose(estimate.filtered)
    }

    fn propagate(&mut self, _t: Micros) -> Option<PoseEstimate> {
        Some(self.pose(self.last?))
    }

    fn origin_between(&self) -> PoseOrigin {
        PoseOrigin::Held
    }

    fn reset(&mut self) {
        self.adaptor.reset();
        self.estimator.reset();
        self.trigger.reset();
        (self.first_event, self.is_due) = (None, false);
        self.repeated.clear();
        self.last = None;
    }
}

/// The end of the frame of labels that a time is in.
fn frame_end(t: Micros) -> Micros {
    Micros((t.0.div_euclid(FRAME.0) + 1) * FRAME.0)
}

fn mirrored(events: &EventStream) -> EventStream {
    let last = events.sensor().width - 1;
    let mut out = EventStream::empty(events.sensor());
    for mut event in events.iter() {
        event.x = last - event.x;
        // On the sensor and in order, as before.
        let _ = out.push(event);
    }
    out
}

/// Infers poses from batches of inputs.
pub struct HandWorker<P> {
    predictor: P,
    /// Height and width.
    size: (usize, usize),
}

impl<P: Predictor> InferenceWorker for HandWorker<P> {
    type Input = InputBatch;
    type Output = Vec<HandPose>;

    fn infer(&mut self, batch: &InputBatch) -> Result<Vec<HandPose>, StreamError> {
        Ok(self.predictor.follow(batch.times(), batch.values(), self.size)?)
    }
}

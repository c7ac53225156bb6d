//! The hand's stream online: the newest inputs for the network, and a filter that propagates its
//! poses.
//!
//! # Model
//! An input is due when time has passed and events have come. A network that takes one input gets
//! the newest whenever it is free; one that takes a batch gets the newest batch that is full.
//! Inputs of a scene at rest are not inferred: the last pose stands. Outputs go through the filter
//! of the slow-motion mode, with its two settings, at the time stamps of their inputs; propagated
//! poses are the filter's.
//!
//! # Source
//! EventHands, live pipeline; there the filter's poses come with those of the network alone.

use evpose_core::{EventStream, Micros};
use evpose_pose::stream::{InferenceWorker, PoseStream, StreamError, StreamFrontend};
use evpose_pose::{HandParams, HandSide, PoseEstimate};
use evpose_repr::RepresentationTrigger;

use super::batch::InputBatch;
use super::config::HandConfig;
use super::estimator::{HandEstimate, HandEstimator};
use super::predictor::Predictor;
use super::view::{HandView, canonical_view};
use crate::TaskError;
use evpose_camera::{Calibration, ViewAdaptor};

/// The stream of a network of hands, for events of the camera of `calibration`, with `batch` inputs
/// per inference.
///
/// # Errors
/// If the representation is not known, the hand cannot be made, or a setting is out of range.
pub fn hand_stream<P: Predictor + Send>(
    config: &HandConfig,
    predictor: P,
    calibration: &Calibration,
    batch: usize,
) -> Result<PoseStream<HandFrontend, HandWorker<P>>, TaskError> {
    let adaptor = ViewAdaptor::new(calibration, &canonical_view(config));
    let sensor = adaptor.view().sensor;
    let frontend = HandFrontend {
        view_events: EventStream::empty(sensor),
        estimator: HandEstimator::slow_motion(config, sensor, batch)?,
        trigger: RepresentationTrigger::new(&config.slow_motion.trigger, sensor),
        is_due: false,
        view: HandView::new(config)?.seen_by(&adaptor),
        adaptor,
        // A network of both hands does not distinguish them.
        side: config.simulation.hands.side(0),
    };
    let size = (usize::from(sensor.height), usize::from(sensor.width));
    let mut worker = HandWorker { predictor, size };
    // The first inference compiles the network: it must not delay the first pose.
    let warm_up = InputBatch::without_events(sensor, frontend.estimator.batch());
    worker.predictor.predict(warm_up.values(), size)?;
    Ok(PoseStream::new(frontend, worker))
}

/// Follows the events of a hand.
#[derive(Debug)]
pub struct HandFrontend {
    adaptor: ViewAdaptor,
    /// The events of the canonical view.
    view_events: EventStream,
    estimator: HandEstimator,
    trigger: RepresentationTrigger,
    is_due: bool,
    view: HandView,
    side: HandSide,
}

impl HandFrontend {
    fn pose(&self, params: HandParams) -> PoseEstimate {
        self.view.estimate(self.side, params)
    }
}

impl StreamFrontend for HandFrontend {
    type Input = InputBatch;
    type Output = Vec<HandParams>;
    type Pose = HandEstimate;

    fn push(&mut self, events: &EventStream) -> Result<(), StreamError> {
        self.adaptor.push(events, &mut self.view_events);
        let events = &self.view_events;
        self.estimator.push(events);
        let mut from = 0;
        while let Some(taken) = self.trigger.due(&events.t()[from..]) {
            from += taken;
            self.is_due = true;
        }
        Ok(())
    }

    fn stride(&mut self, t: Micros) {
        if self.estimator.batch() > 1 && std::mem::take(&mut self.is_due) {
            // The network had no time for a full batch: newer inputs replace it.
            if self.estimator.is_full() {
                self.estimator.clear();
            }
            self.estimator.sample(t, t);
        }
    }

    fn input(&mut self, t: Micros, memory: Option<InputBatch>) -> Option<InputBatch> {
        if self.estimator.batch() == 1 {
            if !std::mem::take(&mut self.is_due) {
                return None;
            }
            self.estimator.clear();
            self.estimator.sample(t, t);
        }
        if !self.estimator.is_full() || self.estimator.repeat_at_rest().is_some() {
            return None;
        }
        Some(self.estimator.take(memory.unwrap_or_default()))
    }

    fn accept(
        &mut self,
        _t: Micros,
        batch: &InputBatch,
        outputs: Vec<HandParams>,
        _now: Micros,
    ) -> Vec<(Micros, HandEstimate)> {
        let estimates = self.estimator.accept(batch, outputs);
        estimates.into_iter().map(|estimate| (estimate.t, estimate)).collect()
    }

    fn estimate(&self, estimate: &HandEstimate) -> PoseEstimate {
        self.pose(estimate.filtered)
    }

    fn propagate(&mut self, t: Micros) -> Option<PoseEstimate> {
        Some(self.pose(self.estimator.propagate(t)?))
    }

    fn reset(&mut self) {
        self.adaptor.reset();
        self.estimator.reset();
        self.trigger.reset();
        self.is_due = false;
    }
}

/// Infers poses from batches of inputs.
pub struct HandWorker<P> {
    predictor: P,
    /// Height and width.
    size: (usize, usize),
}

impl<P: Predictor + Send> InferenceWorker for HandWorker<P> {
    type Input = InputBatch;
    type Output = Vec<HandParams>;

    fn infer(&mut self, batch: &InputBatch) -> Result<Vec<HandParams>, StreamError> {
        Ok(self.predictor.predict(batch.values(), self.size)?)
    }
}

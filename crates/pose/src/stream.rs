//! The stream from events to poses: a front end that follows events, and a worker that infers.
//!
//! ```text
//!  events ─► StreamFrontend: representation ─► Input ─► InferenceWorker: network, decoder ─► Output
//!                 └──────────── filter, propagated poses ◄──────────────────────────────────────┘
//! ```
//!
//! Both halves run in turn over a recording, and on a thread each over a camera. An [`InferenceSchedule`]
//! says when inputs are taken.

use evpose_core::{EventStream, Micros};

use crate::{PoseEstimate, PoseOrigin};

/// A failure of a stage of a stream.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct StreamError(pub Box<dyn std::error::Error + Send + Sync>);

impl StreamError {
    /// The failure of a stage.
    pub fn new(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self(Box::new(error))
    }
}

/// When inputs of a network are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InferenceSchedule {
    /// At a fixed interval of event time, from [`StreamFrontend::first_stride`] on.
    Every(Micros),
    /// At the triggers of events.
    Triggered,
    /// The newest, whenever the network is free: online.
    NewestWhenFree,
}

/// Events that are left after a step of a front end.
#[derive(Debug, Clone, PartialEq)]
pub struct RemainingEvents {
    /// The step, as the end of "12 events are left …".
    pub step: String,
    /// Their count so far.
    pub events: u64,
    /// The share of events that the step leaves of a moving edge: of sensors with more pixels than the view,
    /// less than 1.
    pub edge_share: f64,
    /// How to lose fewer there, as an imperative.
    pub advice: &'static str,
}

/// Events to inputs of a network, and its outputs to filtered poses.
pub trait StreamFrontend: Send {
    /// Input of the network.
    type Input: Send + 'static;
    /// Output of the network, decoded.
    type Output: Send + 'static;
    /// A pose with what the filter knows of it.
    type Pose;

    /// Takes events, in time order and later than those before.
    ///
    /// # Errors
    /// If a stage cannot process them.
    fn push(&mut self, events: &EventStream) -> Result<(), StreamError>;

    /// A stride has passed: front ends that batch inputs take one at `t`, the time of the last
    /// event.
    fn stride(&mut self, t: Micros) {
        let _ = t;
    }

    /// The input at `t`, in the memory of an earlier one. None if nothing has changed since the
    /// last.
    fn input(&mut self, t: Micros, memory: Option<Self::Input>) -> Option<Self::Input>;

    /// The inputs of a batch that will not be full: the events end. None if there are none.
    fn rest(&mut self) -> Option<Self::Input> {
        None
    }

    /// The poses of the last input that needed no inference, which [`Self::input`] or [`Self::rest`] then
    /// left out: those of a scene at rest.
    fn repeated(&mut self) -> Vec<(Micros, Self::Pose)> {
        Vec::new()
    }

    /// The first time of [`InferenceSchedule::Every`] `step` in events that begin at `begin`.
    fn first_stride(&self, begin: Micros, step: Micros) -> Micros {
        begin + step
    }

    /// The earliest time of the next input of [`InferenceSchedule::Triggered`]; none if any event may trigger it.
    fn earliest_trigger(&self) -> Option<Micros> {
        None
    }

    /// The latest time of such a schedule in events that end at `last`.
    fn last_stride(&self, last: Micros) -> Micros {
        last
    }

    /// Remarks on the events so far, in sentences without a full stop.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }

    /// The events that are left after each step before the network, in order. Empty if all of them are.
    fn remaining_events(&self) -> Vec<RemainingEvents> {
        Vec::new()
    }

    /// The times since the last stride for which nothing was inferred, because too few events had come: nobody
    /// is in view.
    fn skipped(&mut self) -> Vec<Micros> {
        Vec::new()
    }

    /// Takes the output for the input of `t`, which is known at `now`. Returns the poses of the
    /// input with their time stamps.
    fn accept(
        &mut self,
        t: Micros,
        input: &Self::Input,
        output: Self::Output,
        now: Micros,
    ) -> Vec<(Micros, Self::Pose)>;

    /// A pose as sinks take it.
    fn estimate(&self, pose: &Self::Pose) -> PoseEstimate;

    /// The pose propagated to `t`. None before the first output.
    fn propagate(&mut self, t: Micros) -> Option<PoseEstimate>;

    /// Whether [`Self::propagate`] moves poses on or holds them.
    fn origin_between(&self) -> PoseOrigin {
        PoseOrigin::Propagated
    }

    /// Forgets everything: another recording begins.
    fn reset(&mut self);
}

/// A network with its decoder.
pub trait InferenceWorker: Send {
    /// Input of the network.
    type Input;
    /// Output of the network, decoded.
    type Output;

    /// Computes the output for an input.
    ///
    /// # Errors
    /// If the computation fails or yields values that are not finite.
    fn infer(&mut self, input: &Self::Input) -> Result<Self::Output, StreamError>;

    /// Forgets earlier inputs, where an output depends on them.
    fn reset(&mut self) {}
}

/// Events → representation → network → decoding → filter → pose.
pub struct PoseStream<F: StreamFrontend, W> {
    /// Follows events.
    pub frontend: F,
    /// Infers.
    pub worker: W,
    memory: Option<F::Input>,
}

impl<F: StreamFrontend, W> PoseStream<F, W> {
    /// A stream of both halves.
    pub fn new(frontend: F, worker: W) -> Self {
        Self { frontend, worker, memory: None }
    }
}

impl<F, W> PoseStream<F, W>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    /// Infers the input at `t`, if there is one.
    ///
    /// # Errors
    /// If a stage fails.
    pub fn infer(&mut self, t: Micros) -> Result<Vec<(Micros, F::Pose)>, StreamError> {
        let input = self.frontend.input(t, self.memory.take());
        self.complete(input, t)
    }

    /// Infers the inputs that wait for a batch to become full: the events end at `t`.
    ///
    /// # Errors
    /// If a stage fails.
    pub fn finish(&mut self, t: Micros) -> Result<Vec<(Micros, F::Pose)>, StreamError> {
        let rest = self.frontend.rest();
        self.complete(rest, t)
    }

    /// Forgets everything: another recording begins.
    pub fn reset(&mut self) {
        self.frontend.reset();
        self.worker.reset();
    }

    fn complete(
        &mut self,
        input: Option<F::Input>,
        t: Micros,
    ) -> Result<Vec<(Micros, F::Pose)>, StreamError> {
        let Some(input) = input else { return Ok(self.frontend.repeated()) };
        let output = self.worker.infer(&input)?;
        let poses = self.frontend.accept(t, &input, output, t);
        // The next input reuses this memory instead of allocating its own.
        self.memory = Some(input);
        Ok(poses)
    }
}

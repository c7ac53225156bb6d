//! The stream from events to poses: a front end that follows events, and a worker that infers.
//!
//! ```text
//!  events ─► StreamFrontend: representation ─► Input ─► InferenceWorker: network, decoder ─► Output
//!                 └──────────── filter, propagated poses ◄──────────────────────────────────────┘
//! ```
//!
//! Offline, [`PoseStream`] runs both in turn; online, each of its halves has a thread of its own.

use evpose_core::{EventStream, Micros};

use crate::PoseEstimate;

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
    /// Takes the events up to and including `t`, and infers there. Returns the poses that became
    /// known, none while a batch is not full.
    ///
    /// # Errors
    /// If a stage fails.
    pub fn infer_at(
        &mut self,
        events: &EventStream,
        t: Micros,
    ) -> Result<Vec<(Micros, F::Pose)>, StreamError> {
        self.frontend.push(events)?;
        self.frontend.stride(t);
        self.infer(t)
    }

    /// Infers the input at `t`, if there is one.
    ///
    /// # Errors
    /// If a stage fails.
    pub fn infer(&mut self, t: Micros) -> Result<Vec<(Micros, F::Pose)>, StreamError> {
        let Some(input) = self.frontend.input(t, self.memory.take()) else {
            return Ok(Vec::new());
        };
        let output = self.worker.infer(&input)?;
        let poses = self.frontend.accept(t, &input, output, t);
        self.memory = Some(input);
        Ok(poses)
    }
}

//! The hand network as something Burn can train: one step forward, backward and measured.

use std::sync::{Arc, Mutex, PoisonError};

use burn::module::Module;
use burn::tensor::Tensor;
use burn_train::{InferenceStep, Interrupter, TrainOutput, TrainStep};
use evpose_nn::{HandLoss, HandLossParts, HandRegressor};

use crate::metric::StepScalars;

/// Windows of events and the poses at their ends.
#[derive(Debug, Clone)]
pub(crate) struct HandBatch {
    /// Surfaces, `[batch, 2, height, width]`.
    pub surfaces: Tensor<4>,
    /// The 12 parameters, `[batch, 12]`.
    pub poses: Tensor<2>,
    /// Optimiser step this batch is for, from 1.
    pub step: u64,
}

/// A loss that is no longer a number, and where it happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Divergence {
    pub(crate) loss: f64,
    pub(crate) step: u64,
}

/// Stops a training whose loss is no longer a number, before anything of it is saved.
#[derive(Clone)]
pub(crate) struct Guard {
    interrupter: Interrupter,
    seen: Arc<Mutex<Option<Divergence>>>,
}

impl std::fmt::Debug for Guard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Guard").field("seen", &self.seen).finish_non_exhaustive()
    }
}

impl Guard {
    pub(crate) fn new(interrupter: Interrupter) -> Self {
        Self { interrupter, seen: Arc::default() }
    }

    fn check(&self, loss: f64, step: u64) {
        if !loss.is_finite() {
            let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
            seen.get_or_insert(Divergence { loss, step });
            self.interrupter.stop(Some("the loss is no longer a number"));
        }
    }

    pub(crate) fn divergence(&self) -> Option<Divergence> {
        *self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The network together with what judges it.
#[derive(Module, Debug)]
pub(crate) struct HandLearner {
    pub(crate) network: HandRegressor,
    #[module(skip)]
    loss: HandLoss,
    #[module(skip)]
    guard: Guard,
}

impl HandLearner {
    pub(crate) fn new(network: HandRegressor, loss: HandLoss, guard: Guard) -> Self {
        Self { network, loss, guard }
    }

    fn measure(&self, batch: HandBatch) -> (HandLossParts, usize) {
        let [batch_size, ..] = batch.surfaces.dims();
        (self.loss.forward(self.network.forward(batch.surfaces), batch.poses), batch_size)
    }
}

fn scalars(parts: &HandLossParts, batch_size: usize) -> StepScalars {
    let read = |tensor: &Tensor<1>| f64::from(tensor.clone().into_scalar::<f32>());
    let rms = |mean_square: f64, components: f64| (components * mean_square).sqrt();
    StepScalars {
        batch_size,
        loss: read(&parts.total),
        articulation: rms(read(&parts.articulation), 1.0),
        translation_mm: 1e3 * rms(read(&parts.translation_m2), 3.0),
        rotation_deg: rms(read(&parts.rotation_rad2), 3.0).to_degrees(),
    }
}

impl TrainStep for HandLearner {
    type Input = HandBatch;
    type Output = StepScalars;

    fn step(&self, batch: HandBatch) -> TrainOutput<StepScalars> {
        let step = batch.step;
        let (parts, batch_size) = self.measure(batch);
        let measured = scalars(&parts, batch_size);
        self.guard.check(measured.loss, step);
        TrainOutput::new(self, parts.objective.backward(), measured)
    }
}

impl InferenceStep for HandLearner {
    type Input = HandBatch;
    type Output = StepScalars;

    fn step(&self, batch: HandBatch) -> StepScalars {
        let (parts, batch_size) = self.measure(batch);
        scalars(&parts, batch_size)
    }
}

//! A network with its loss: training and validation steps for Burn, for every task.

use std::fmt::Debug;

use burn::module::{Module, ModuleDisplay};
use burn::tensor::Tensor;
use burn_train::{InferenceStep, TrainOutput, TrainStep};
use evpose_task::schedule::TrainingPrecision;

use super::mixed;
use crate::guard::Guard;
use crate::metric::BatchValues;

/// A batch with the optimiser step that it is for.
#[derive(Debug, Clone)]
pub(crate) struct StepBatch<B> {
    /// Inputs and targets.
    pub(crate) batch: B,
    /// The step, from 1.
    pub(crate) step: u64,
}

/// The loss of a task.
pub trait TrainingLoss<N>: Debug + Clone + Send + Sync + 'static {
    /// Inputs and targets of an optimiser step, on the device.
    type Batch: Send + 'static;

    /// The inputs of the network.
    fn inputs(batch: &mut Self::Batch) -> &mut Tensor<4>;

    /// The objective, a single value that is minimised, and the values that are logged, the loss first.
    fn measure(&self, network: &N, batch: Self::Batch) -> (Tensor<1>, BatchValues);
}

/// The network with its loss.
#[derive(Module, Debug)]
pub(crate) struct Learner<N: Module + ModuleDisplay, L> {
    pub(crate) network: N,
    #[module(skip)]
    loss: L,
    #[module(skip)]
    precision: TrainingPrecision,
    #[module(skip)]
    guard: Guard,
}

impl<N: Module + ModuleDisplay, L> Learner<N, L> {
    /// `network` with its loss; `guard` checks every loss.
    pub(crate) fn new(network: N, loss: L, precision: TrainingPrecision, guard: Guard) -> Self {
        Self { network, loss, precision, guard }
    }
}

impl<N: Module + ModuleDisplay, L: TrainingLoss<N>> TrainStep for Learner<N, L> {
    type Input = StepBatch<L::Batch>;
    type Output = BatchValues;

    fn step(&self, StepBatch { mut batch, step }: Self::Input) -> TrainOutput<BatchValues> {
        let inputs = L::inputs(&mut batch);
        *inputs = mixed::rounded(self.precision, inputs.clone());
        let (objective, measured) = self.loss.measure(&self.network, batch);
        self.guard.check(measured.loss(), step);
        TrainOutput { grads: mixed::gradients(self.precision, objective, self), item: measured }
    }
}

impl<N: Module + ModuleDisplay, L: TrainingLoss<N>> InferenceStep for Learner<N, L> {
    type Input = StepBatch<L::Batch>;
    type Output = BatchValues;

    fn step(&self, StepBatch { batch, .. }: Self::Input) -> BatchValues {
        let measured = self.loss.measure(&self.network, batch).1;
        self.guard.check_validation(measured.loss());
        measured
    }
}

//! The interface between a training run and a task.

use std::path::Path;
use std::sync::Arc;

use burn::data::dataloader::DataLoader;
use burn::optim::AdamConfig;
use burn::optim::lr_scheduler::module_lr_scheduler::ModuleLrScheduler;
use burn::tensor::Device;
use burn_train::{InferenceStep, LearnerModel, TrainStep};
use evpose_task::schedule::EarlyStop;

use crate::TrainError;
use crate::guard::Guard;
use crate::metric::{Field, Scalars};

/// Batches of a training.
pub(crate) struct Loaders<B> {
    /// Pass `i` is validation interval `i`.
    pub(crate) train: Arc<dyn DataLoader<B>>,
    /// Every pass is the same.
    pub(crate) valid: Arc<dyn DataLoader<B>>,
}

/// A task as a training run needs it: network, loss, optimiser and checkpoint.
pub(crate) trait TrainingTask {
    /// Inputs and targets of an optimiser step.
    type Batch: Send + 'static;
    /// The values logged for each batch.
    type Scalars: Scalars;
    /// The trained network.
    type Network;
    /// The network with its loss.
    type Learner: LearnerModel
        + TrainStep<Input = Self::Batch, Output = Self::Scalars>
        + InferenceStep<Input = Self::Batch, Output = Self::Scalars>;
    /// The network with everything needed to use it.
    type Checkpoint;

    /// The logged values; checkpoints are ranked by the first.
    const FIELDS: &'static [Field<Self::Scalars>];

    /// A network of the shape of the config, with initial weights.
    fn untrained(&self, device: &Device) -> Result<Self::Network, TrainError>;

    /// The network that the training starts from.
    fn initial_network(&self, device: &Device) -> Result<Self::Network, TrainError> {
        self.untrained(device)
    }

    /// `network` with the loss; `guard` checks every step.
    fn learner(&self, network: Self::Network, guard: Guard) -> Self::Learner;

    /// The network of a learner.
    fn network(learner: Self::Learner) -> Self::Network;

    /// The optimiser.
    fn optimizer(&self) -> AdamConfig;

    /// The learning rate over the steps.
    fn learning_rate(&self) -> ModuleLrScheduler;

    /// The rule by which the training ends early, if it has one.
    fn early_stop(&self) -> Option<EarlyStop> {
        None
    }

    /// The checkpoint of a finished network.
    fn checkpoint(&self, network: Self::Network) -> Self::Checkpoint;

    /// Writes a checkpoint.
    fn save(checkpoint: &Self::Checkpoint, path: &Path) -> Result<(), TrainError>;
}

//! The interface between a training run and a task.

use std::path::Path;

use burn::module::{Module, ModuleDisplay};
use burn::optim::AdamConfig;
use burn::optim::decay::WeightDecayConfig;
use burn::optim::lr_scheduler::module_lr_scheduler::ModuleLrScheduler;
use burn::tensor::Device;
use evpose_task::schedule::EarlyStop;

use super::learner::TrainingLoss;
use crate::TrainError;
use crate::metric::LoggedValue;

/// PyTorch's default; Burn's is 1e-5.
const ADAM_EPSILON: f32 = 1e-8;

/// Adam with PyTorch's epsilon and, above 0, a weight decay.
pub fn adam(weight_decay: f32) -> AdamConfig {
    let decay = (weight_decay > 0.0).then(|| WeightDecayConfig::new(weight_decay));
    AdamConfig::new().with_epsilon(ADAM_EPSILON).with_weight_decay(decay)
}

/// Inputs and targets of a task's steps.
pub(crate) type BatchOf<T> =
    <<T as TrainingTask>::Loss as TrainingLoss<<T as TrainingTask>::Network>>::Batch;

/// A task as a training run needs it: network, loss, optimiser and checkpoint.
pub trait TrainingTask {
    /// The trained network.
    type Network: Module + ModuleDisplay + 'static;
    /// Loss that the run minimises.
    type Loss: TrainingLoss<Self::Network>;
    /// The network with everything needed to use it.
    type Checkpoint;

    /// The logged values, the loss first: checkpoints are ranked by it.
    const VALUES: &'static [LoggedValue];

    /// A network of the shape of the config, with initial weights.
    ///
    /// # Errors
    /// If the config makes none.
    fn untrained(&self, device: &Device) -> Result<Self::Network, TrainError>;

    /// The network that the training starts from.
    ///
    /// # Errors
    /// If it cannot be read, or is of another shape.
    fn initial_network(&self, device: &Device) -> Result<Self::Network, TrainError> {
        self.untrained(device)
    }

    /// Loss that the run minimises.
    fn loss(&self) -> Self::Loss;

    /// Settings of Adam.
    fn optimizer(&self) -> AdamConfig {
        adam(0.0)
    }

    /// The learning rate over the steps.
    fn learning_rate(&self) -> ModuleLrScheduler;

    /// The rule by which the training ends early, if it has one.
    fn early_stop(&self) -> Option<EarlyStop> {
        None
    }

    /// The checkpoint of a finished network.
    fn checkpoint(&self, network: Self::Network) -> Self::Checkpoint;

    /// Completes the best checkpoint, once, before it is written: with what is estimated of the trained network.
    ///
    /// # Errors
    /// If it cannot be.
    fn finish(&self, _best: &mut Self::Checkpoint) -> Result<(), TrainError> {
        Ok(())
    }

    /// Writes a checkpoint.
    ///
    /// # Errors
    /// If it cannot be written.
    fn save(checkpoint: &Self::Checkpoint, path: &Path) -> Result<(), TrainError>;
}

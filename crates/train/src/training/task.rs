//! The interface between a training run and a task.

use std::path::Path;

use burn::module::{Module, ModuleDisplay};
use burn::optim::lr_scheduler::module_lr_scheduler::ModuleLrScheduler;
use burn::tensor::Device;
use evpose_nn::Adam;
use evpose_task::schedule::{EarlyStop, TrainingPrecision};

use super::learner::TrainingLoss;
use crate::TrainError;
use crate::metric::LoggedValue;

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

    /// The number format of the convolutions.
    fn precision(&self) -> TrainingPrecision {
        TrainingPrecision::default()
    }

    /// The optimiser.
    fn optimizer(&self) -> Adam {
        Adam::new(0.0)
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

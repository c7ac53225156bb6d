//! Training of a network of joints.

use std::path::Path;

use burn::optim::lr_scheduler::module_lr_scheduler::ModuleLrScheduler;
use burn::tensor::Device;
use evpose_core::seed_for;
use evpose_nn::{HandNetwork, JointLoss, JointNet, JointNetConfig};
use evpose_task::hand::HandCheckpoint;
use evpose_task::schedule::TrainingPrecision;

use super::loss::JOINT_VALUES;
use super::presence::with_fitted_presence;
use crate::TrainError;
use crate::hand::training::HandTask;
use crate::metric::LoggedValue;
use crate::training::{TrainingTask, check_shape};

/// The task of hands with a network of joints in place of a regressor.
pub(crate) struct JointTask<'a>(pub(crate) HandTask<'a>);

impl JointTask<'_> {
    fn network_config(&self) -> JointNetConfig {
        JointNetConfig { width: self.0.config.network.width }
    }
}

impl TrainingTask for JointTask<'_> {
    type Network = JointNet;
    type Loss = JointLoss;
    type Checkpoint = HandCheckpoint;

    const VALUES: &'static [LoggedValue] = &JOINT_VALUES;

    fn untrained(&self, device: &Device) -> Result<JointNet, TrainError> {
        Ok(self.network_config().init(seed_for(self.0.config.seed, "weights", 0), device)?)
    }

    fn initial_network(&self, device: &Device) -> Result<JointNet, TrainError> {
        let Some(path) = &self.0.config.start_from else { return self.untrained(device) };
        match HandCheckpoint::load(path, device)?.network {
            HandNetwork::Joints(network) => {
                check_shape(path, network.config(), &self.network_config())?;
                Ok(network)
            }
            HandNetwork::Regressor(network) => {
                check_shape(path, network.config(), &self.0.config.network)?;
                unreachable!("a regressor's config is not one of joints")
            }
        }
    }

    fn loss(&self) -> JointLoss {
        JointLoss::new(self.0.config.joint_loss)
    }

    fn precision(&self) -> TrainingPrecision {
        self.0.config.training.precision
    }

    fn learning_rate(&self) -> ModuleLrScheduler {
        self.0.learning_rate()
    }

    fn checkpoint(&self, network: JointNet) -> HandCheckpoint {
        self.0.checkpoint_of(HandNetwork::Joints(network))
    }

    fn finish(&self, best: &mut HandCheckpoint) -> Result<(), TrainError> {
        let HandTask { config, unseen, device, .. } = self.0;
        let draws = (config.training.presence_samples, config.seed);
        if let HandNetwork::Joints(network) = &best.network {
            let network = with_fitted_presence(network.clone(), unseen, draws, device)?;
            best.network = HandNetwork::Joints(network);
        }
        self.0.finish(best)
    }

    fn save(checkpoint: &HandCheckpoint, path: &Path) -> Result<(), TrainError> {
        Ok(checkpoint.save(path)?)
    }
}

#[cfg(test)]
mod tests;

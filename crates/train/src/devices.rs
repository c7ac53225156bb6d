//! Training on several devices of one machine.
//!
//! | strategy | each step | devices |
//! |---|---|---|
//! | `ddp` | a worker and a replica of network and optimiser for each device; gradients are averaged among the devices (NCCL's all-reduce) | CUDA |
//! | `main-device` | the network is copied to every device; gradients are summed on the first, which alone optimises | any |
//!
//! # Source
//! `ExecutionStrategy::DistributedDataParallel` and `ExecutionStrategy::MultiDevice` of burn-train
//! 0.22.1. Only `burn-cubecl` has an all-reduce, and of its runtimes only `cubecl-cuda`.

use burn::tensor::Device;
use burn::tensor::distributed::{DistributedConfig, ReduceOperation};
use burn_train::{
    ExecutionStrategy, Interrupter, LearnerModel, MultiDeviceOptim, TrainingStrategy,
};
use evpose_nn::DeviceKind;

use crate::TrainError;
use crate::barrier::StepBarrier;
use crate::batch_loader::{BatchLoader, BatchSource};
use evpose_task::hand::{DeviceStrategy, TrainingConfig};

/// The devices that train one network together, the first of which validates and saves.
pub(crate) struct DeviceGroup {
    devices: Vec<Device>,
    strategy: DeviceStrategy,
}

impl DeviceGroup {
    /// The devices of kind `kind` that `config` asks for.
    ///
    /// # Errors
    /// If the machine has fewer, or they cannot work together as asked.
    pub(crate) fn new(kind: DeviceKind, config: &TrainingConfig) -> Result<Self, TrainError> {
        let (count, strategy) = (config.devices, config.strategy);
        if count > 1 && strategy == DeviceStrategy::Ddp && !matches!(kind, DeviceKind::Cuda { .. })
        {
            return Err(TrainError::Field {
                field: "training.strategy",
                message: format!(
                    "`ddp` averages gradients among CUDA devices, and this is {count} of {kind}: \
                     use --device cuda, or set training.strategy=main-device"
                ),
            });
        }
        let devices = if count == 1 { vec![kind.resolve()?] } else { kind.resolve_several(count)? };
        Ok(Self { devices, strategy })
    }

    /// One device of kind `kind`.
    ///
    /// # Errors
    /// If this build or this machine lacks it.
    pub(crate) fn single(kind: DeviceKind) -> Result<Self, TrainError> {
        Ok(Self { devices: vec![kind.resolve()?], strategy: DeviceStrategy::default() })
    }

    /// The device that validates.
    pub(crate) fn main(&self) -> &Device {
        &self.devices[0]
    }

    /// The loader, cut into one part of every batch for each device.
    pub(crate) fn share<S: BatchSource>(
        &self,
        loader: BatchLoader<S>,
        interrupter: &Interrupter,
    ) -> BatchLoader<S> {
        let count = self.devices.len();
        // With one thread that reads all loaders in turn, no device can run ahead of another.
        let needs_barrier = count > 1 && self.strategy == DeviceStrategy::Ddp;
        loader.shared_by(count, needs_barrier.then(|| StepBarrier::new(count, interrupter.clone())))
    }

    /// Burn's training strategy; none for one device, which is its default.
    pub(crate) fn strategy<M: LearnerModel>(&self) -> Option<TrainingStrategy<M>> {
        if self.devices.len() == 1 {
            return None;
        }
        let devices = self.devices.iter().map(|device| device.clone().autodiff()).collect();
        let execution = match self.strategy {
            DeviceStrategy::Ddp => {
                let all_reduce_op = ReduceOperation::Mean;
                ExecutionStrategy::ddp(devices, DistributedConfig { all_reduce_op })
            }
            DeviceStrategy::MainDevice => {
                ExecutionStrategy::multi(devices, MultiDeviceOptim::OptimMainDevice)
            }
        };
        Some(execution.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(devices: usize, strategy: DeviceStrategy) -> TrainingConfig {
        TrainingConfig { devices, strategy, ..TrainingConfig::default() }
    }

    #[test]
    fn the_cpu_can_stand_for_several_devices_but_has_no_all_reduce() {
        let group =
            DeviceGroup::new(DeviceKind::Flex, &asked(2, DeviceStrategy::MainDevice)).unwrap();
        assert_eq!(group.devices.len(), 2);
        let refused =
            DeviceGroup::new(DeviceKind::Flex, &asked(2, DeviceStrategy::Ddp)).err().unwrap();
        let message = refused.to_string();
        assert!(message.contains("training.strategy") && message.contains("flex"), "{message}");
        assert!(DeviceGroup::new(DeviceKind::Flex, &asked(1, DeviceStrategy::Ddp)).is_ok());
    }
}

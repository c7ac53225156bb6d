//! Argument groups shared by several commands.

use anyhow::Result;
use burn::tensor::Device;
use evpose_nn::DeviceKind;

use crate::ranges::threads;
use crate::threads::use_threads;

/// A config and changes to it.
#[derive(Debug, clap::Args)]
pub struct ConfigArgs {
    /// A TOML file, or an embedded config: for hands `quick`, `hand-wide`, `hand-joints`, `ablation`,
    /// `eventhands`, for bodies `pretrain`, `finetune`, `body-wide`, `studio`, `pretrain-full`, `finetune-full`, of others `dhp19-cnn`, `lift-mono`
    pub config: String,
    /// Change one field, for example --set training.steps=500 (may be repeated)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
}

/// The device to compute on.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct DeviceArgs {
    /// flex (CPU), ndarray, wgpu or cuda, of several GPUs wgpu:1; all but flex need the Cargo feature of
    /// that name, and `evpose info --devices` lists them
    #[arg(long, default_value = "flex")]
    pub device: DeviceKind,
    /// CPU threads; all cores by default
    #[arg(long, value_parser = threads())]
    pub threads: Option<usize>,
}

impl DeviceArgs {
    /// Opens the device and sets the thread count.
    ///
    /// # Errors
    /// If the device is not part of this build or of this machine, or the thread pool is already
    /// running.
    pub fn open(&self) -> Result<Device> {
        use_threads(self.threads)?;
        Ok(self.device.resolve()?)
    }
}

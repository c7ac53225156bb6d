//! Descriptions of checkpoints.

use std::path::Path;

use crate::args::DeviceArgs;
use anyhow::Result;
use evpose_nn::DeviceKind;

const EXTENSION: &str = "bpk";

/// Whether a file is a checkpoint, by its extension.
pub(super) fn is_likely(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == EXTENSION)
}

/// A description of the network and its training data, and the config.
pub(super) fn describe(path: &Path) -> Result<String> {
    let device = DeviceArgs { device: DeviceKind::Flex, threads: None };
    let model = crate::tasks::open(path, &device)?;
    let config = model.config_toml()?;
    Ok(format!("{}\n{}\nconfig:\n\n{}", path.display(), model.description(), config.trim_end()))
}

//! Descriptions of `.bpk` files.

use std::path::Path;

use anyhow::Result;
use evpose_app::args::DeviceArgs;
use evpose_nn::DeviceKind;

/// Extension of our weight files.
const EXTENSION: &str = "bpk";

/// Whether the name of a file is that of a weight file.
pub(super) fn is_likely(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == EXTENSION)
}

/// The network, the data it was trained on, and the experiment.
pub(super) fn describe(path: &Path) -> Result<String> {
    let device = DeviceArgs { device: DeviceKind::Flex, threads: None };
    let model = evpose_commands::open(path, &device)?;
    let config = model.config_toml()?;
    Ok(format!(
        "{}\n{}\nthe experiment it came from:\n\n{}",
        path.display(),
        model.description(),
        config.trim_end()
    ))
}

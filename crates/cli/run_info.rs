//! What every output directory holds beside its results: resolved config, seed, commit.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_core::atomic_write;
use evpose_train::HandConfig;

/// The commit this binary was built from.
pub(crate) const COMMIT: &str = env!("EVPOSE_COMMIT");

/// Command, seed, commit and version.
pub(crate) fn table(seed: u64) -> Result<toml::Table> {
    let mut run = toml::Table::new();
    let command = std::env::args().collect::<Vec<_>>().join(" ");
    run.insert("command".into(), command.into());
    run.insert("seed".into(), i64::try_from(seed).context("a seed must fit 63 bits")?.into());
    run.insert("commit".into(), COMMIT.into());
    run.insert("version".into(), env!("CARGO_PKG_VERSION").into());
    Ok(run)
}

/// Writes `run.toml` (command, seed, commit, version) and, where given, `config.toml`.
pub(crate) fn write(dir: &Path, seed: u64, config: Option<&HandConfig>) -> Result<()> {
    let run = table(seed)?;
    let path = dir.join("run.toml");
    atomic_write(&path, run.to_string().as_bytes())
        .with_context(|| format!("writing {}", path.display()))?;
    if let Some(config) = config {
        let path = dir.join("config.toml");
        atomic_write(&path, config.to_toml()?.as_bytes())
            .with_context(|| format!("writing {}", path.display()))?;
    }
    Ok(())
}

//! Files of an output directory.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_core::atomic_write;
use serde::Serialize;

/// Scores of a folder, and the table of them.
pub(crate) const SCORES: &str = "scores.json";
pub(crate) const TABLE: &str = "table.md";

pub(crate) fn create(dir: &Path) -> Result<()> {
    std::fs::create_dir_all(dir).with_context(|| format!("creating {}", dir.display()))
}

/// Removes a directory with all that is in it, if it is there.
pub(crate) fn remove(dir: &Path) -> Result<()> {
    if !dir.exists() {
        return Ok(());
    }
    std::fs::remove_dir_all(dir).with_context(|| format!("removing {}", dir.display()))
}

/// Writes a file of a directory through a temporary name.
pub(crate) fn write(dir: &Path, name: &str, bytes: &[u8]) -> Result<()> {
    let path = dir.join(name);
    atomic_write(&path, bytes).with_context(|| format!("writing {}", path.display()))
}

/// The same for data, as JSON that people can read.
pub(crate) fn write_json(dir: &Path, name: &str, data: &impl Serialize) -> Result<()> {
    write(dir, name, json(data)?.as_bytes())
}

/// Data as JSON that people can read.
pub(crate) fn json(data: &impl Serialize) -> Result<String> {
    Ok(format!("{}\n", serde_json::to_string_pretty(data)?))
}

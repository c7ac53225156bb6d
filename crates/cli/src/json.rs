//! Results as JSON files.

use std::path::Path;

use anyhow::{Context, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::outputs::write_file;

/// Writes `report` to `path`, if the user gave one.
///
/// # Errors
/// If the file cannot be written.
pub fn write_json(path: Option<&Path>, report: &impl Serialize) -> Result<()> {
    path.map_or(Ok(()), |path| write_result(path, report))
}

/// Writes a result of a study, atomically.
///
/// # Errors
/// If the file cannot be written.
pub fn write_result(path: &Path, result: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(result)? + "\n";
    write_file(path, text)
}

/// Reads a result of a study; none where it is absent.
///
/// # Errors
/// If the file cannot be read, or was not written by this version.
pub fn read_result<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    if !path.exists() {
        return Ok(None);
    }
    let text = std::fs::read(path).with_context(|| format!("reading {}", path.display()))?;
    serde_json::from_slice(&text).map(Some).with_context(|| {
        format!("{}: not written by this version; remove it to do it again", path.display())
    })
}

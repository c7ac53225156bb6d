//! Results as JSON files.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_core::atomic_write;
use serde::Serialize;

/// Writes `report` to `path`, if the user gave one.
///
/// # Errors
/// If the file cannot be written.
pub fn write_json(path: Option<&Path>, report: &impl Serialize) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(report)? + "\n";
    atomic_write(path, text.as_bytes()).with_context(|| format!("writing {}", path.display()))
}

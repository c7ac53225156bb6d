//! Checkpoints of bodies among others.

use std::path::Path;

use anyhow::Result;
use burn::tensor::Device;
use evpose_task::body::{BodyCheckpoint, BodyConfig};

/// The checkpoint at `path`, if it is one of bodies.
pub fn checkpoint(path: &Path, device: &Device) -> Result<Option<BodyCheckpoint>> {
    if path.is_dir() {
        let config = std::fs::read_to_string(path.join("config.toml")).unwrap_or_default();
        let is_body = BodyConfig::is_one(&config);
        return if is_body { Ok(Some(BodyCheckpoint::load(path, device)?)) } else { Ok(None) };
    }
    // What is no body's may yet be a hand's, whose reader says what is wrong with it.
    Ok(BodyCheckpoint::load(path, device).ok())
}

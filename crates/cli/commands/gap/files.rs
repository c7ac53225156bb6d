//! The files of a run, and how it was made.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_core::atomic_write;
use serde::{Deserialize, Serialize};

/// The answer.
pub(super) const VERDICT: &str = "verdict.json";
/// What the page is drawn from.
pub(super) const REPORT: &str = "report.json";
/// How all of it was made.
pub(super) const RUN: &str = "run.json";
/// The model that was compared, with nominal values.
pub(super) const MODEL: &str = "model.toml";
/// The model with what was found.
pub(super) const CORRECTED: &str = "corrected.toml";

/// How a run was made: what `evpose gap verify` begins with.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct RunInfo {
    /// What was typed.
    pub(super) command: String,
    /// The commit and version of the program.
    pub(super) commit: String,
    pub(super) version: String,
    /// Seed of all noise.
    pub(super) seed: u64,
    /// Whether fewer replicates were made.
    pub(super) quick: bool,
    /// The recording and its scene; none for a recording alone.
    pub(super) measured: PathBuf,
    pub(super) scene: Option<PathBuf>,
    /// The second recording and its scene.
    pub(super) validate: Option<PathBuf>,
    pub(super) validate_scene: Option<PathBuf>,
    /// Poses of what was seen, where light and texture are not known.
    #[serde(default)]
    pub(super) poses: Option<PathBuf>,
    #[serde(default)]
    pub(super) validate_poses: Option<PathBuf>,
    /// Seconds of a config's scene that were rendered.
    #[serde(default)]
    pub(super) scene_seconds: Option<f64>,
    /// The response curve of frames, as typed.
    #[serde(default)]
    pub(super) response: Option<String>,
    /// Whether recordings were taken as they are.
    pub(super) as_is: bool,
    /// What was held out, in seconds, of the second recording or else of the first.
    pub(super) held_s: Option<[f64; 2]>,
    /// Preset or file, as typed.
    pub(super) model: String,
    /// Files in this directory: the model before and after.
    pub(super) model_before: String,
    pub(super) model_after: String,
    /// Effects that were not looked for.
    pub(super) leave_out: Vec<String>,
    /// Seconds that each part took.
    pub(super) seconds: BTreeMap<String, f64>,
    /// When it was done, seconds since 1970.
    pub(super) finished_unix_s: u64,
}

/// Writes a file of a directory through a temporary name.
pub(super) fn write(dir: &Path, name: &str, bytes: &[u8]) -> Result<()> {
    let path = dir.join(name);
    atomic_write(&path, bytes).with_context(|| format!("writing {}", path.display()))
}

/// The same for data as JSON that people can read.
pub(super) fn write_json(dir: &Path, name: &str, data: &impl Serialize) -> Result<()> {
    write(dir, name, format!("{}\n", serde_json::to_string_pretty(data)?).as_bytes())
}

/// A path from the root, so that it holds wherever it is read.
pub(super) fn whole(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path).with_context(|| path.display().to_string())
}

/// Reads `run.json`.
pub(super) fn run_info(dir: &Path) -> Result<RunInfo> {
    let path = dir.join(RUN);
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("{}: is this a directory of `evpose gap run`?", path.display()))?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}

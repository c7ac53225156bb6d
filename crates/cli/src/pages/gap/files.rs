//! How a run was made, and how its files are written.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
pub use evpose_gap::run_files::{CORRECTED, EVIDENCE, MODEL, REPORT, RUN, VERDICT};
use evpose_io::OpenOptions;
use serde::{Deserialize, Serialize};

/// How a run was made: what `evpose gap verify` begins with.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RunInfo {
    /// The command line.
    pub command: String,
    /// The commit and version of the program.
    pub commit: String,
    /// Version of the program.
    pub version: String,
    /// Seed of all noise.
    pub seed: u64,
    /// Whether fewer replicates were made.
    pub quick: bool,
    /// The recording and its scene; none for a recording alone.
    pub measured: PathBuf,
    /// Scene of the recording.
    pub scene: Option<PathBuf>,
    /// The second recording and its scene.
    pub validate: Option<PathBuf>,
    /// Scene of the second recording.
    pub validate_scene: Option<PathBuf>,
    /// Poses of what was seen, where light and texture are not known.
    #[serde(default)]
    pub poses: Option<PathBuf>,
    /// Poses of the second recording.
    #[serde(default)]
    pub validate_poses: Option<PathBuf>,
    /// Seconds of a config's scene that were rendered.
    #[serde(default)]
    pub scene_seconds: Option<f64>,
    /// The response curve of frames, as typed.
    #[serde(default)]
    pub response: Option<String>,
    /// Whether recordings were taken as they are.
    pub as_is: bool,
    /// How recordings were read.
    #[serde(default)]
    pub reading: OpenOptions,
    /// Held-out window in seconds, of the second recording or else of the first.
    pub held_s: Option<[f64; 2]>,
    /// Preset or file, as typed.
    pub model: String,
    /// Files in this directory: the model before and after.
    pub model_before: String,
    /// File of the corrected model.
    pub model_after: String,
    /// Effects that were not looked for.
    pub leave_out: Vec<String>,
    /// Seconds that each part took.
    pub seconds: BTreeMap<String, f64>,
    /// When it was done, seconds since 1970.
    pub finished_unix_s: u64,
}

/// A path from the root, so that it holds wherever it is read.
pub fn whole(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path).with_context(|| path.display().to_string())
}

/// Reads `run.json`.
pub fn run_info(dir: &Path) -> Result<RunInfo> {
    let path = dir.join(RUN);
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("{}: is this a directory of `evpose gap run`?", path.display()))?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}

//! The figure of a training's learning curves, in its directory.

use std::path::Path;

use crate::pages::learning::{self, TrainingLength};
use crate::progress::say;
use anyhow::{Context, Result};
use evpose_train::{TrainError, read_history};

/// In the directory of a training.
const CURVES: &str = "curves.svg";
const HISTORY: &str = "metrics.jsonl";

/// Writes `curves.svg` into the directory of a training that has ended or was interrupted; does
/// nothing if it never began.
///
/// # Errors
/// If the history cannot be read, or the figure not be written.
pub(crate) fn write_after<T>(
    trained: &Result<T, TrainError>,
    run: &Path,
    length: TrainingLength,
) -> Result<()> {
    if !matches!(trained, Ok(_) | Err(TrainError::Stopped(_) | TrainError::Diverged { .. })) {
        return Ok(());
    }
    let history = read_history(&run.join(HISTORY))?;
    if history.is_empty() {
        return Ok(());
    }
    let path = run.join(CURVES);
    let image = learning::image(&history, length)?;
    evpose_core::atomic_write(&path, image.as_bytes())
        .with_context(|| format!("writing {}", path.display()))?;
    say(format!("learning curves: {}", path.display()));
    Ok(())
}

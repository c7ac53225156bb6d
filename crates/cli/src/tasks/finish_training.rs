//! The end of a training of any task.

use std::path::{Path, PathBuf};

use crate::outputs::write_file;
use crate::pages::learning;
use crate::progress::say;
use crate::run_info;
use anyhow::Result;
use evpose_train::training::TrainingSpan;
use evpose_train::{TrainError, TrainSummary, read_history};

/// In the directory of a training.
const CURVES: &str = "curves.svg";
const HISTORY: &str = "metrics.jsonl";

/// Ends `evpose train` in the directory `run`: writes the learning curves and `run.toml`, and says how fast
/// it went, in `samples`: what the task calls them.
///
/// # Errors
/// If the training failed, or a file cannot be written.
pub fn finish_training<C>(
    trained: Result<TrainSummary<C>, TrainError>,
    run: &Path,
    span: TrainingSpan,
    seed: u64,
    samples: &str,
) -> Result<()> {
    // A training that failed is the worse fault.
    let curves = write_curves(&trained, run, span);
    if trained.is_ok() && curves.is_ok() {
        // Before the first line, which may not be writable: a run without its record is no run.
        run_info::write(run, seed, None)?;
    }
    if let Ok(Some(path)) = &curves {
        say(format!("learning curves: {}", path.display()));
    }
    let summary = trained?;
    curves?;
    say(format!(
        "{} {samples} in {:.0} s, {:.0} {samples}/s",
        summary.samples,
        summary.elapsed.as_secs_f64(),
        summary.samples_per_second
    ));
    say(summary.data_wait.to_string());
    if summary.ended_early {
        say("ended early: the validation loss had stopped falling");
    }
    say(format!("checkpoint: {}", summary.path.display()));
    Ok(())
}

/// Writes `curves.svg` into the directory of a training that has ended or was interrupted, and returns its path; does
/// nothing if it never began.
///
/// # Errors
/// If the history cannot be read, or the figure not be written.
fn write_curves<T>(
    trained: &Result<T, TrainError>,
    run: &Path,
    span: TrainingSpan,
) -> Result<Option<PathBuf>> {
    // After other errors, a history that is there may be that of an earlier run.
    if !matches!(trained, Ok(_) | Err(TrainError::Stopped(_) | TrainError::Diverged { .. })) {
        return Ok(None);
    }
    let history = read_history(&run.join(HISTORY))?;
    if history.is_empty() {
        return Ok(None);
    }
    let path = run.join(CURVES);
    let image = learning::image(&history, span)?;
    write_file(&path, image)?;
    Ok(Some(path))
}

//! The files of finished networks in a run directory.

use std::path::{Path, PathBuf};

use crate::TaskError;

/// The network of the lowest validation loss, in a run directory.
pub const BEST: &str = "best.bpk";
/// The network after the last step.
pub const LAST: &str = "last.bpk";

/// The file of weights at `path`: of a run directory its best network, else itself.
///
/// # Errors
/// If it is the directory of a run that has not ended.
pub fn network_file(path: &Path) -> Result<PathBuf, TaskError> {
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    let best = path.join(BEST);
    if !best.exists() {
        let message = format!(
            "no {BEST} here: a run writes it when it ends; finish it with `evpose train … --resume`, \
             or give a file of weights"
        );
        return Err(TaskError::Config { path: path.to_owned(), message });
    }
    Ok(best)
}

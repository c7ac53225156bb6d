//! The directory of a training run.

use std::fs;
use std::path::{Path, PathBuf};

use evpose_task::TaskConfig;

use crate::TrainError;
use crate::checkpoint::newest_checkpoint;

/// The files of a run.
pub(super) struct RunDirectory<'a>(pub(super) &'a Path);

impl RunDirectory<'_> {
    pub(super) fn config(&self) -> PathBuf {
        self.0.join("config.toml")
    }

    pub(super) fn history(&self) -> PathBuf {
        self.0.join("metrics.jsonl")
    }

    pub(super) fn loading(&self) -> PathBuf {
        self.0.join("loading.jsonl")
    }

    pub(super) fn checkpoints(&self) -> PathBuf {
        self.0.join("checkpoint")
    }

    /// Creates the directory and writes its config. Returns the validation interval of the
    /// checkpoint to continue from, 0 for none.
    ///
    /// # Errors
    /// If it holds checkpoints and `resume` is not given, or the run of another config.
    pub(super) fn prepare<C: TaskConfig>(
        &self,
        config: &C,
        resume: bool,
    ) -> Result<usize, TrainError> {
        let newest = newest_checkpoint(&self.checkpoints())?;
        if resume && self.config().exists() {
            let fields = config.differences(&C::read(&self.config())?)?;
            if !fields.is_empty() {
                return Err(TrainError::ConfigDiffers { path: self.config(), fields });
            }
        } else if newest.is_some() {
            return Err(TrainError::HoldsCheckpoints { path: self.0.to_path_buf() });
        }
        fs::create_dir_all(self.checkpoints())
            .map_err(|source| TrainError::Io { path: self.checkpoints(), source })?;
        evpose_core::atomic_write(self.config(), config.to_toml()?.as_bytes())
            .map_err(|source| TrainError::Io { path: self.config(), source })?;
        Ok(if resume { newest.unwrap_or(0) } else { 0 })
    }
}

//! The directory of a training run.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use evpose_nn::NnError;
use evpose_nn::weights::read_checked;
use evpose_task::{BEST, Experiment};

use super::lock::RunLock;
use crate::TrainError;
use crate::checkpoint::{intact_checkpoint, newest_checkpoint, weights_path};
use crate::history::History;
use crate::retention::best_interval;

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

    /// Creates the directory, locks it and writes its config. Returns the lock and the validation interval of the
    /// checkpoint to continue from, 0 for none. Says on standard error which newer checkpoints are damaged.
    ///
    /// # Errors
    /// If another process trains there, if it holds a training and `resume` is not given, or the run of another
    /// config, or if all checkpoints are damaged.
    pub(super) fn prepare<C: Experiment>(
        &self,
        config: &C,
        resume: bool,
    ) -> Result<(RunLock, usize), TrainError> {
        fs::create_dir_all(self.checkpoints())
            .map_err(|source| TrainError::Io { path: self.checkpoints(), source })?;
        // Locked before anything is read, which another process could change.
        let lock = RunLock::acquire(self.0)?;
        let holds_training =
            newest_checkpoint(&self.checkpoints())?.is_some() || self.0.join(BEST).exists();
        if resume && self.config().exists() {
            // A run that continued with another config would be of neither.
            let fields = config.differences(&C::read(&self.config())?)?;
            if !fields.is_empty() {
                return Err(TrainError::ConfigDiffers { path: self.config(), fields });
            }
        } else if holds_training {
            return Err(TrainError::HoldsTraining { path: self.0.to_path_buf() });
        }
        let (newest, damage) = intact_checkpoint(&self.checkpoints())?;
        for damaged in damage {
            let newest = newest.unwrap_or(0);
            let _ = writeln!(
                std::io::stderr(),
                "{damaged}\ntraining goes on from the checkpoint before, of validation {newest}"
            );
        }
        // Last: a refused start leaves the config of the run that is there.
        evpose_core::atomic_write(self.config(), config.to_toml()?.as_bytes())
            .map_err(|source| TrainError::Io { path: self.config(), source })?;
        Ok((lock, newest.unwrap_or(0)))
    }

    /// Excludes networks of `history` whose checkpoint is gone from the choice of the best. Where the best is damaged,
    /// says so on standard error: the best of the others takes its place.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn leave_out_lost_networks(&self, history: &History) -> Result<(), TrainError> {
        let path = |interval| weights_path(&self.checkpoints(), interval);
        for interval in history.validation_losses().into_keys() {
            if !path(interval).exists() {
                history.lose_network(interval);
            }
        }
        // From the best on, until one is intact: reading all networks would take long.
        while let Some(best) = best_interval(&history.losses_of_networks()) {
            match read_checked(&path(best)) {
                Ok(_) => break,
                Err(damaged @ NnError::Damaged { .. }) => {
                    let _ = writeln!(
                        std::io::stderr(),
                        "{damaged}\nthe best network, of validation {best}, is lost: the best of the others counts"
                    );
                    history.lose_network(best);
                }
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }
}

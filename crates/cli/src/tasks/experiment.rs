//! The experiment of a config, step by step: what a study repeats with one thing changed.

use std::path::{Path, PathBuf};

use crate::run_info::CONFIG;
use anyhow::{Result, bail};
use evpose_core::stats::bootstrap::BootstrapConfig;
use evpose_sensor::SensorConfig;
use evpose_task::{BEST, Experiment};
use evpose_train::training::TrainingSpan;
use evpose_train::{LoggedValue, TrainOptions};

/// The weights that a training starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StartWeights<'a> {
    /// Initial ones, whatever the config says.
    Initial,
    /// Those of `start_from` of the config, or else initial ones.
    OfConfig,
    /// Those of a run, or of a file.
    Run(&'a Path),
}

impl StartWeights<'_> {
    /// The field `start_from` of a config that has `there` in it.
    pub(crate) fn field(self, there: Option<PathBuf>) -> Option<PathBuf> {
        match self {
            Self::Initial => None,
            Self::OfConfig => there,
            Self::Run(path) => Some(path.to_owned()),
        }
    }
}

/// Simulation and training of a config.
///
/// Every step continues what an interrupted one left: sequences that are complete are kept, a
/// training goes on from its newest checkpoint, and one that has ended is not repeated.
pub trait PoseExperiment {
    /// Seed of every random stream.
    fn seed(&self) -> u64;

    /// The experiment with another seed.
    fn with_seed(&self, seed: u64) -> Box<dyn PoseExperiment>;

    /// The experiment with another event camera. Scenes, motion and lights stay the same.
    fn with_sensor(&self, sensor: &SensorConfig) -> Box<dyn PoseExperiment>;

    /// The experiment whose sequences are the held-out ones, with seeds of their own.
    fn held_out(&self) -> Box<dyn PoseExperiment>;

    /// The config as TOML.
    ///
    /// # Errors
    /// If it cannot be serialised.
    fn to_toml(&self) -> Result<String>;

    /// The network and the length of its training, in a few words.
    fn description(&self) -> String;

    /// The length of its training.
    fn length(&self) -> TrainingSpan;

    /// The values that its training logs for each batch, the loss first.
    fn logged_values(&self) -> &'static [LoggedValue];

    /// Whether it trains on a directory of recordings, which [`Self::simulate`] makes.
    fn trains_on_recordings(&self) -> bool;

    /// Resamples of confidence intervals.
    fn bootstrap(&self) -> BootstrapConfig;

    /// Simulates the missing sequences into `directory`; `label` names the progress bar. Returns
    /// counts and speed in a line.
    ///
    /// # Errors
    /// If the simulation fails, or the directory holds another config or another build's files.
    fn simulate(&self, directory: &Path, label: &str) -> Result<String>;

    /// Trains on the sequences of `data` in the directory `run`, and leaves its best checkpoint
    /// there, unless it pauses before.
    ///
    /// # Errors
    /// If the data cannot be read, the training fails, or `run` is of another config.
    fn train(&self, data: &Path, run: &Path, options: &TrainOptions) -> Result<()>;
}

/// Whether the training of `config` in `run` has ended.
///
/// # Errors
/// If it has, with another config.
pub(crate) fn is_trained<C: Experiment>(config: &C, run: &Path) -> Result<bool> {
    // The best checkpoint is the last file that a training writes.
    if !run.join(BEST).exists() {
        return Ok(false);
    }
    let path = run.join(CONFIG);
    let fields = config.differences(&C::read(&path)?)?;
    if let Some(field) = fields.first() {
        bail!("{}: of another config ({field}): choose another directory", path.display());
    }
    Ok(true)
}

//! A training of a study: once, whoever needs its network, and timed.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_cli::json::{read_result, write_result};
use evpose_nn::DeviceKind;
use evpose_train::{ProgressCallback, TrainOptions, TrainSummary};
use serde::{Deserialize, Serialize};

use super::exclusively;

/// File with the duration of a training, which marks a finished network.
const TRAINED: &str = "trained.json";

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Trained {
    seconds: Option<f64>,
}

/// A training in a run directory.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Training<'a> {
    pub(crate) run: &'a Path,
    pub(crate) device: DeviceKind,
    pub(crate) samples: u64,
}

impl Training<'_> {
    pub(crate) fn is_finished(run: &Path) -> bool {
        run.join(TRAINED).exists()
    }

    /// Trains unless it is finished, and marks it as finished. Another process that trains it is waited for.
    /// Returns samples per second.
    pub(crate) fn once<C>(
        self,
        progress: ProgressCallback,
        train: impl FnOnce(&TrainOptions) -> Result<TrainSummary<C>>,
    ) -> Result<Option<f64>> {
        exclusively(self.run, || {
            // Another process may have finished it while this one waited for the lock.
            if Self::is_finished(self.run) {
                return Ok(None);
            }
            let trained = train(&options(self.device, progress));
            let summary = trained.with_context(|| format!("training {}", self.run.display()))?;
            // A resumed training was timed in part: its full duration follows from its speed, if there is one.
            let speed = (summary.samples > 0).then_some(summary.samples_per_second);
            let seconds = speed.map(|speed| self.samples as f64 / speed);
            // The mark comes last: a process that is killed before leaves a training that goes on.
            write_result(&self.run.join(TRAINED), &Trained { seconds })?;
            Ok(speed)
        })
    }
}

/// Options of all trainings: one that was interrupted goes on.
pub(crate) fn options(device: DeviceKind, progress: ProgressCallback) -> TrainOptions {
    TrainOptions { resume: true, progress: Some(progress), ..TrainOptions::new(device) }
}

/// Duration of the training of a finished network in seconds; none if it was interrupted.
pub(crate) fn training_s(run: &Path) -> Result<Option<f64>> {
    let trained: Option<Trained> = read_result(&run.join(TRAINED))?;
    Ok(trained.and_then(|trained| trained.seconds))
}

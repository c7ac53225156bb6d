//! The registry of pose tasks, and the commands that every task implements.
//!
//! * [`TASKS`]: the registry; [`open`] finds the task of a checkpoint.
//! * [`PoseTask`], [`PoseModel`]: what a task has to implement so that every command takes it.
//! * [`PoseExperiment`]: the steps of a config's experiment, for studies that repeat them.
//! * [`args`]: arguments of the commands whose work is the task's.
//! * [`opening`]: arguments of opening a recording, and the size of its sensor.
//!
//! ```
//! use evpose_cli::args::DeviceArgs;
//! use evpose_nn::DeviceKind;
//!
//! # fn main() -> anyhow::Result<()> {
//! let names: Vec<&str> = evpose_cli::tasks::TASKS.iter().map(|task| task.name()).collect();
//! assert_eq!(names, ["body", "hand"]);
//!
//! // The task of a checkpoint is found from its contents.
//! let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../checkpoints/body-quick.bpk");
//! let device = DeviceArgs { device: DeviceKind::Flex, threads: None };
//! let model = evpose_cli::tasks::open(shipped.as_ref(), &device)?;
//! assert_eq!(model.task(), "body");
//! let [channels, height, width] = model.input_shape();
//! assert_eq!([channels, height, width], [3, 128, 128]);
//! # Ok(())
//! # }
//! ```

pub mod args;
mod benchmark_recording;
mod body;
mod experiment;
mod hand;
mod learning_curves;
pub mod online;
pub mod opening;
mod scores;
mod task;

use std::path::Path;

use crate::args::{ConfigArgs, DeviceArgs};
use crate::shipped::{checkpoint_path, unknown_checkpoint};
use anyhow::{Context, Result, bail, ensure};

pub use experiment::{PoseExperiment, StartWeights};
pub use scores::{EvaluationScores, Metric, RecordingScores};
pub use task::{DataSetInfo, PoseModel, PoseTask, PrecisionScores};

/// The pose tasks. A checkpoint is offered to each in turn; the last reports files that none can
/// read.
pub const TASKS: &[&dyn PoseTask] = &[&body::Body, &hand::Hand];

/// The task called `name`.
///
/// # Errors
/// If there is none of that name; the message lists those there are.
pub fn task_by_name(name: &str) -> Result<&'static dyn PoseTask> {
    let task = TASKS.iter().copied().find(|task| task.name() == name);
    task.with_context(|| {
        let known: Vec<&str> = TASKS.iter().map(|task| task.name()).collect();
        format!("no task is called `{name}`; there are {}", known.join(", "))
    })
}

/// The model of a checkpoint on a device, of whichever task it is. Sets the thread count.
///
/// # Errors
/// If no task can read it, or this build or this machine lacks the device.
pub fn open(checkpoint: &Path, device: &DeviceArgs) -> Result<Box<dyn PoseModel>> {
    let checkpoint = &checkpoint_path(checkpoint)?;
    ensure!(checkpoint.exists(), unknown_checkpoint(checkpoint));
    let device = device.open()?;
    for task in TASKS {
        if let Some(model) = task.open(checkpoint, &device)? {
            return Ok(model);
        }
    }
    bail!("{}: a checkpoint of no known task", checkpoint.display())
}

/// The experiment of a config, of whichever task it is; see [`PoseTask::experiment`].
///
/// # Errors
/// If no task has such a config.
pub fn experiment(
    config: &ConfigArgs,
    start: StartWeights<'_>,
) -> Result<(&'static dyn PoseTask, Box<dyn PoseExperiment>)> {
    for task in TASKS.iter().copied() {
        if let Some(experiment) = task.experiment(config, start)? {
            return Ok((task, experiment));
        }
    }
    bail!("{}: a config of no known task", config.config)
}

/// The simulated data set in `directory`, by its config, of whichever task it is.
///
/// # Errors
/// If no task can read the config.
pub fn data_set(directory: &Path, config: &Path) -> Result<DataSetInfo> {
    for task in TASKS {
        if let Some(info) = task.data_set(directory, config)? {
            return Ok(info);
        }
    }
    bail!("{}: a config of no known task", config.display())
}

/// A model with the initial weights of a config, of whichever task it is.
///
/// # Errors
/// If no task has such a config.
pub fn untrained(config: &ConfigArgs, device: &burn::tensor::Device) -> Result<Box<dyn PoseModel>> {
    for task in TASKS {
        if let Some(model) = task.untrained(config, device)? {
            return Ok(model);
        }
    }
    bail!("{}: a config of no known task", config.config)
}

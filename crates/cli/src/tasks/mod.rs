//! The registry of pose tasks, and the commands that every task implements.
//!
//! * [`TASKS`]: the registry; [`task_of_config`] and [`open`] find the task of a config, of a checkpoint.
//! * [`PoseTask`], [`PoseModel`]: what a task has to implement so that commands take it.
//! * [`StudiedTask`], [`PoseExperiment`], [`NetworkModel`]: what studies, benchmarks, exports and
//!   quantisation take besides.
//! * [`TaskStream`], [`infer_all()`], [`finish_training()`], [`values`]: what tasks share.
//! * [`args`]: arguments of the commands whose work is the task's.
//! * [`TaskArgs`]: arguments that tasks bring to commands; [`command_of_task`] refuses those of other tasks.
//! * [`opening`]: arguments of opening a recording, and the size of its sensor.
//!
//! ```
//! use evpose_cli::args::DeviceArgs;
//! use evpose_nn::DeviceKind;
//!
//! # fn main() -> anyhow::Result<()> {
//! assert_eq!(evpose_cli::tasks::TASKS.names(), ["body", "hand", "baseline"]);
//!
//! // The task of a checkpoint is found from its contents.
//! let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../checkpoints/body-quick.bpk");
//! let device = DeviceArgs { device: DeviceKind::Flex, threads: None };
//! let model = evpose_cli::tasks::open(shipped.as_ref(), &device)?;
//! assert_eq!(model.task(), "body");
//! let [channels, height, width] = model.network()?.input_shape();
//! assert_eq!([channels, height, width], [3, 128, 128]);
//! # Ok(())
//! # }
//! ```

pub mod args;
mod baseline;
mod benchmark_recording;
mod body;
mod experiment;
mod finish_training;
mod hand;
mod infer_all;
pub mod online;
pub mod opening;
mod own_args;
mod scores;
mod task;
pub mod values;

use std::path::Path;

use crate::args::{ConfigArgs, DeviceArgs};
use crate::configs::toml_of;
use crate::run_info::CONFIG;
use crate::shipped::{checkpoint_path, unknown_checkpoint};
use anyhow::{Context, Result, bail, ensure};
use evpose_core::Registry;
use evpose_nn::weights::task_of;
use evpose_sensor::nearest;
use evpose_task::BEST;

pub use experiment::{PoseExperiment, StartWeights};
pub use finish_training::finish_training;
pub use infer_all::{InferenceCounts, PoseScores, infer_all};
pub use online::TaskStream;
pub use own_args::{
    Eval, Infer, Live, NoArgs, Simulate, TaskArgs, TaskCommand, Train, command_of_task,
};
pub use scores::{EvaluationScores, Metric, RecordingScores};
pub use task::{DataSetInfo, NetworkModel, PoseModel, PoseTask, PrecisionScores, StudiedTask};

/// The pose tasks. Configs and checkpoints name theirs; a program registers its own.
pub static TASKS: Registry<dyn PoseTask> =
    Registry::new(&[&body::Body, &hand::Hand, &baseline::Baseline]);

/// The task called `name`.
///
/// # Errors
/// If there is none of that name; the message lists those there are.
pub fn task_by_name(name: &str) -> Result<&'static dyn PoseTask> {
    TASKS.find(name).with_context(|| {
        let hint = match nearest(name, TASKS.names()).as_slice() {
            [] => String::new(),
            near => format!(": did you mean {}?", near.join(" or ")),
        };
        format!("no task is called `{name}`{hint} (there are {})", TASKS.names().join(", "))
    })
}

/// The task that a config names, by the name of an embedded one or the path of a file.
///
/// # Errors
/// If it cannot be read, or names no task, or one that there is not; the message lists the tasks.
pub fn task_of_config(config: &str) -> Result<&'static dyn PoseTask> {
    let table: toml::Table =
        toml::from_str(&toml_of(config)?).with_context(|| config.to_owned())?;
    let name = table.get("task").and_then(toml::Value::as_str);
    let name = name.with_context(|| {
        let names = TASKS.names().join(", ");
        format!("{config}: names no task: add `task = \"NAME\"` (there are {names})")
    })?;
    task_by_name(name).with_context(|| config.to_owned())
}

/// The task that a weight file, a run directory or its config names; none for weights of others.
fn task_of_checkpoint(checkpoint: &Path) -> Result<Option<&'static dyn PoseTask>> {
    if let Some(task) = task_of(checkpoint).or_else(|| task_of(&checkpoint.join(BEST))) {
        return task_by_name(&task).map(Some);
    }
    // A run that was killed has no finished weights, but its config.
    let config = checkpoint.join(CONFIG);
    config.exists().then(|| task_of_config(&config.to_string_lossy())).transpose()
}

/// The model of a checkpoint on a device, of whichever task it is. Sets the thread count.
///
/// # Errors
/// If no task can read it, or this build or this machine lacks the device.
pub fn open(checkpoint: &Path, device: &DeviceArgs) -> Result<Box<dyn PoseModel>> {
    let checkpoint = &checkpoint_path(checkpoint)?;
    // A misspelt name is reported before a GPU is started for it.
    ensure!(checkpoint.exists(), unknown_checkpoint(checkpoint));
    let device = device.open()?;
    if let Some(task) = task_of_checkpoint(checkpoint)? {
        return task.open(checkpoint, &device);
    }
    // Weights of others name no task: they are of the one whose network they fit.
    let (mut models, mut errors) = (Vec::new(), Vec::new());
    for task in &TASKS {
        match task.open(checkpoint, &device) {
            Ok(model) => models.push(model),
            Err(error) => errors.push(format!("as of the task `{}`: {error:#}", task.name())),
        }
    }
    let fitting: Vec<String> = models.iter().map(|model| format!("`{}`", model.task())).collect();
    match models.pop() {
        Some(model) if models.is_empty() => Ok(model),
        None => bail!("{}: of no known task\n{}", checkpoint.display(), errors.join("\n")),
        Some(_) => bail!(
            "{}: names no task, and the weights fit several: {}",
            checkpoint.display(),
            fitting.join(", ")
        ),
    }
}

/// The experiment of a config, of whichever task it is; see [`StudiedTask::experiment`].
///
/// # Errors
/// If the config names no task, or that task cannot read it.
pub fn experiment(
    config: &ConfigArgs,
    start: StartWeights<'_>,
) -> Result<(&'static dyn PoseTask, Box<dyn PoseExperiment>)> {
    let task = task_of_config(&config.config)?;
    Ok((task, task.studied()?.experiment(config, start)?))
}

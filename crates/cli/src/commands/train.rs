//! `evpose train`, by the task of the config.

use crate::tasks::TASKS;
use crate::tasks::args::TrainArgs;
use anyhow::Result;

/// Runs `evpose train`.
pub fn run(args: &TrainArgs) -> Result<()> {
    evpose_kernels::keep_freed_memory();
    for task in TASKS {
        if task.train(args)? {
            break;
        }
    }
    Ok(())
}

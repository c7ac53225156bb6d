//! `evpose train`, by the task of the config.

use anyhow::Result;
use evpose_commands::TASKS;
use evpose_commands::args::TrainArgs;

pub(crate) fn run(args: &TrainArgs) -> Result<()> {
    evpose_kernels::keep_freed_memory();
    for task in TASKS {
        if task.train(args)? {
            break;
        }
    }
    Ok(())
}

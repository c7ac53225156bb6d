//! `evpose train`, by the task of the config.

use crate::tasks::args::TrainArgs;
use crate::tasks::task_of_config;
use anyhow::Result;

/// Runs `evpose train`.
pub fn run(args: &TrainArgs) -> Result<()> {
    evpose_kernels::keep_freed_memory();
    task_of_config(&args.config.config)?.train(args)
}

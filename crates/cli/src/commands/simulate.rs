//! `evpose simulate`.

use crate::tasks::args::SimulateArgs;
use crate::tasks::task_of_config;
use crate::threads::use_threads;
use anyhow::Result;

/// Runs `evpose simulate`.
pub fn run(args: &SimulateArgs) -> Result<()> {
    use_threads(args.threads)?;
    task_of_config(&args.config.config)?.simulate(args)
}

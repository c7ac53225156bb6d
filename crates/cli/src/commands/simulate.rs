//! `evpose simulate`.

use crate::tasks::TASKS;
use crate::tasks::args::SimulateArgs;
use crate::threads::use_threads;
use anyhow::Result;

/// Runs `evpose simulate`.
pub fn run(args: &SimulateArgs) -> Result<()> {
    use_threads(args.threads)?;
    for task in TASKS {
        if task.simulate(args)? {
            break;
        }
    }
    Ok(())
}

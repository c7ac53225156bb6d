//! `evpose simulate`.

use anyhow::Result;
use evpose_app::threads::use_threads;
use evpose_commands::TASKS;
use evpose_commands::args::SimulateArgs;

pub(crate) fn run(args: &SimulateArgs) -> Result<()> {
    use_threads(args.threads)?;
    for task in TASKS {
        if task.simulate(args)? {
            break;
        }
    }
    Ok(())
}

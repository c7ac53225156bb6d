//! `evpose eval`, by the task of the checkpoint.

use anyhow::Result;
use evpose_commands::args::EvalArgs;

pub(crate) fn run(args: &EvalArgs) -> Result<()> {
    evpose_commands::open(&args.checkpoint, &args.device)?.evaluate(args)
}

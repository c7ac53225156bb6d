//! `evpose eval`, by the task of the checkpoint.

use crate::tasks::args::EvalArgs;
use anyhow::Result;

/// Runs `evpose eval`.
pub fn run(args: &EvalArgs) -> Result<()> {
    crate::tasks::open(&args.checkpoint, &args.device)?.evaluate(args)
}

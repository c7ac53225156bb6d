//! `evpose infer`.

use crate::tasks::args::InferArgs;
use anyhow::Result;

/// Runs `evpose infer`.
pub fn run(args: &InferArgs) -> Result<()> {
    crate::tasks::open(&args.checkpoint, &args.device)?.infer(args)
}

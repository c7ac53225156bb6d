//! `evpose infer`.

use anyhow::Result;
use evpose_commands::args::InferArgs;

pub(crate) fn run(args: &InferArgs) -> Result<()> {
    evpose_commands::open(&args.checkpoint, &args.device)?.infer(args)
}

//! `evpose tune`: hyper-parameter search.

use anyhow::Result;
use evpose_tune::TuneArgs;

pub(crate) fn run(args: &TuneArgs) -> Result<()> {
    evpose_kernels::keep_freed_memory();
    evpose_tune::run(args)
}

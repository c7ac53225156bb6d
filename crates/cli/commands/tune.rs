//! `evpose tune`: hyper-parameter search.

use anyhow::Result;
use evpose_studies::tune::TuneArgs;

pub(crate) fn run(args: &TuneArgs) -> Result<()> {
    evpose_kernels::keep_freed_memory();
    evpose_studies::tune::run(args)
}

//! The arguments of the program.

use clap::Parser;

use crate::commands;

/// Pose estimation from event cameras: simulate, train, evaluate, infer.
#[derive(Debug, Parser)]
#[command(
    name = "evpose",
    version,
    long_version = format!("{} (commit {})", env!("CARGO_PKG_VERSION"), evpose_cli::run_info::COMMIT),
    arg_required_else_help = true,
    after_help = "Start with:\n  evpose demo\n\nThen, step by step:\n  \
        evpose simulate quick --out data/train\n  \
        evpose simulate quick --out data/test --seed 2 --held-out\n  \
        evpose train quick --data data/train --out runs/hand\n  \
        evpose eval --checkpoint runs/hand --data data/test\n  \
        evpose infer --checkpoint runs/hand --events data/test/0000.evc --out poses.csv"
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: commands::Command,
}

//! `evpose average`: the mean of two networks.

use std::path::PathBuf;

use crate::args::DeviceArgs;
use crate::outputs::OutputFile;
use crate::progress::say;
use crate::shipped::checkpoint_path;
use crate::tasks::open;
use anyhow::{Context, Result};
use evpose_nn::DeviceKind;

/// Arguments of `evpose average`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose average body runs/body/wide --out mean.bpk\n\n\
    A network that was trained further on other data forgets some of what it knew. Halfway back it often\n\
    does as well on both: evaluate all three.")]
pub struct AverageArgs {
    /// A run directory, a .bpk file, or the name of a shipped network; its config and thresholds stay
    pub(crate) first: PathBuf,
    /// The other one, of the same shape and trained from the first, or both from a third
    pub(crate) second: PathBuf,
    /// The .bpk file to write
    #[arg(long)]
    pub(crate) out: OutputFile,
}

/// Runs `evpose average`.
pub fn run(args: &AverageArgs) -> Result<()> {
    let first = open(&args.first, &DeviceArgs { device: DeviceKind::Flex, threads: None })?;
    let second = checkpoint_path(&args.second)?;
    let context = || format!("{} and {}", args.first.display(), args.second.display());
    first.network()?.save_average(&second, &args.out).with_context(context)?;
    say(format!("the mean of both: {}", args.out.display()));
    Ok(())
}

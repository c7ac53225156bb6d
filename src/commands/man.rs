//! `evpose man`: manual pages, one of the program and one of every command.

use std::fs::{create_dir_all, read_dir};
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::CommandFactory;
use evpose_cli::progress::say;

use crate::args::Args;

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  evpose man --out ~/.local/share/man/man1")]
pub(crate) struct ManArgs {
    /// Directory of the pages
    #[arg(long)]
    pub(crate) out: PathBuf,
}

pub(crate) fn run(args: &ManArgs) -> Result<()> {
    let directory = args.out.display();
    create_dir_all(&args.out).with_context(|| format!("creating {directory}"))?;
    clap_mangen::generate_to(Args::command(), &args.out)
        .with_context(|| format!("writing manual pages to {directory}"))?;
    let pages = read_dir(&args.out).with_context(|| format!("reading {directory}"))?.count();
    say(format!("{directory}: {pages} pages, the first is evpose.1"));
    Ok(())
}

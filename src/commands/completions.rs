//! `evpose completions`: completions of the command line.

use std::io::{Write, stdout};

use anyhow::{Context, Result};
use clap::CommandFactory;
use clap_complete::{Shell, generate};

use crate::args::Args;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose completions bash > ~/.local/share/bash-completion/completions/evpose\n  \
    evpose completions fish > ~/.config/fish/completions/evpose.fish")]
pub(crate) struct CompletionsArgs {
    /// Shell that completes
    pub(crate) shell: Shell,
}

pub(crate) fn run(args: &CompletionsArgs) -> Result<()> {
    // The generator panics where it cannot write, such as into a closed pipe.
    let mut script = Vec::new();
    generate(args.shell, &mut Args::command(), "evpose", &mut script);
    stdout().write_all(&script).context("writing the completions")
}

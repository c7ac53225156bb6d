//! `evpose gap`: the search for missing effects, and the study of what a correction is worth.

use std::process::ExitCode;

use anyhow::Result;
use clap::Subcommand;
use evpose_cli::commands::gap;
use evpose_studies::payoff;

/// Subcommands of `evpose gap`.
#[derive(Debug, Subcommand)]
pub(crate) enum GapCommand {
    #[command(flatten)]
    Identify(gap::GapCommand),
    /// Train on the model as given and on the corrected one, and report what the correction is worth
    Payoff(payoff::PayoffArgs),
}

pub(crate) fn run(command: &GapCommand) -> Result<ExitCode> {
    match command {
        GapCommand::Identify(command) => gap::run(command),
        GapCommand::Payoff(args) => payoff::run(args).map(|()| ExitCode::SUCCESS),
    }
}

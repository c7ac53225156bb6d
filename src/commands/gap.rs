//! `evpose gap`: the search for missing effects, and the studies and benchmarks of it.

use std::process::ExitCode;

use anyhow::Result;
use clap::Subcommand;
use evpose_bench::gap as bench;
use evpose_cli::commands::gap;
use evpose_studies::payoff;

/// Subcommands of `evpose gap`.
#[derive(Debug, Subcommand)]
pub(crate) enum GapCommand {
    #[command(flatten)]
    Identify(gap::GapCommand),
    /// Train on the model as given and on the corrected one, and report what the correction is worth
    Payoff(payoff::PayoffArgs),
    /// Blind benchmark: identify hidden effects in recordings of an independent pixel model
    Bench(bench::BenchArgs),
    /// Merge the results of all shards of a benchmark: scores, tables and a page
    Score(bench::ScoreArgs),
    /// Identify and score hidden effects in recordings of other programs
    Outside(bench::OutsideArgs),
    /// Test whether the effects identified in recordings of real cameras are consistent: over halves, mirror
    /// images and a stretched time axis
    Real(bench::RealArgs),
    /// Fit the constants of probabilities and intervals to results of a development plan
    Calibrate(bench::CalibrateArgs),
}

pub(crate) fn run(command: &GapCommand) -> Result<ExitCode> {
    match command {
        GapCommand::Identify(command) => return gap::run(command),
        GapCommand::Payoff(args) => payoff::run(args),
        GapCommand::Bench(args) => bench::run(args),
        GapCommand::Score(args) => bench::score(args),
        GapCommand::Outside(args) => bench::outside(args),
        GapCommand::Real(args) => bench::real(args),
        GapCommand::Calibrate(args) => bench::calibrate(args),
    }
    .map(|()| ExitCode::SUCCESS)
}

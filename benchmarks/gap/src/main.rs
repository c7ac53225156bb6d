//! The benchmark of the gap workflow: effects hidden in recordings, and what `evpose gap run` says of them.
//!
//! ```text
//! program  `evpose gap run` as a process, and the files that it leaves
//! naming   every case as the files of a measurement, without its label; a row a case
//!   -> merge    rows of all parts of a plan, each case once
//!   -> opened   the label of each case that has a row
//!   -> group    recall and precision by the count of hidden effects
//!   -> score    rates, power, reliability, estimates -> targets, tables, page
//! own      recordings of our own model: how probable each is
//! outside    recordings that other programs made: every case by `evpose gap run`, then scored
//! real       recordings of real cameras: names do not depend on how they are looked at
//! stored   scores and tables again, from stored rows and opened labels
//! calibrate  fit of probabilities and intervals to all stored cases
//! ```

mod args;
mod bad_input;
mod calibrate;
mod case_files;
mod commands;
mod confusion;
#[cfg(test)]
mod example;
mod files;
mod group;
mod identification;
mod jsonl;
mod merge;
mod naming;
mod opened;
mod outside;
mod own;
mod page;
mod part;
mod program;
mod real;
mod row;
mod score;
mod stats;
mod stored;
mod table;
mod tables;
mod targets;
mod terminal;
mod truth;

use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};

use bad_input::BadInput;

/// Blind benchmark of `evpose gap run`: recordings in which effects are hidden, and how often their names are
/// right.
#[derive(Debug, Parser)]
#[command(
    name = "gapbench",
    version,
    arg_required_else_help = true,
    after_help = "Start with:\n  gapbench run --plan 7 --tier plain --limit 4 --out runs/bench"
)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Identify hidden effects in recordings of an independent pixel model
    Run(args::RunArgs),
    /// Write the files of cases, and identify nothing
    Cases(args::CasesArgs),
    /// Test recordings that are runs of our own model, in which nothing is missing
    Own(args::OwnArgs),
    /// Merge the results of all shards of a plan: scores, tables and a page
    Score(args::ScoreArgs),
    /// Identify and score hidden effects in recordings of other programs
    Outside(outside::OutsideArgs),
    /// Test whether the effects identified in recordings of real cameras are consistent: over halves, mirror
    /// images and a stretched time axis
    Real(real::RealArgs),
    /// Fit the constants of probabilities and intervals to results of a development plan
    Calibrate(args::CalibrateArgs),
}

fn main() -> ExitCode {
    let result = match &Args::parse().command {
        Command::Run(args) => commands::run(args),
        Command::Cases(args) => commands::cases(args),
        Command::Own(args) => own::run(args),
        Command::Score(args) => commands::score(args),
        Command::Outside(args) => outside::run(args),
        Command::Real(args) => real::run(args),
        Command::Calibrate(args) => commands::calibrate(args),
    };
    let Err(error) = result else { return ExitCode::SUCCESS };
    terminal::report_error(format!("{error:#}"));
    if error.is::<BadInput>() { ExitCode::from(2) } else { ExitCode::FAILURE }
}

/// Sets the count of CPU threads of this process, if one is given.
fn use_threads(threads: Option<usize>) -> Result<()> {
    let Some(threads) = threads else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build_global().context("setting the number of threads")
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    /// Pages of the repository with command lines of this program.
    const PAGES: [&str; 6] = [
        include_str!("../../../docs/guide/gap.md"),
        include_str!("../../../docs/guide/gap-examples.md"),
        include_str!("../../../docs/guide/calibrate.md"),
        include_str!("../../../benches/gap/README.md"),
        include_str!("../../../benches/gap/outside.md"),
        include_str!("../README.md"),
    ];

    /// The command lines of a text, without comments behind them.
    fn lines(text: &str) -> impl Iterator<Item = &str> {
        let lines = text.lines().map(|line| line.trim_start().trim_start_matches("$ "));
        lines
            .filter(|line| line.starts_with("gapbench "))
            .map(|line| line.split_once(" #").map_or(line, |(line, _)| line))
    }

    #[test]
    fn every_command_of_the_pages_and_the_help_is_understood() {
        let command = Args::command();
        let helps = command.get_subcommands().map(|inner| inner.get_after_help());
        let helps: Vec<String> = helps.map(|help| help.expect("an example").to_string()).collect();
        let texts = PAGES.into_iter().chain(helps.iter().map(String::as_str));
        let lines: Vec<&str> = texts.flat_map(lines).collect();
        // A lower bound, or a change of the pages' format would make this check nothing.
        assert!(lines.len() > 25, "{lines:?}");
        for line in lines {
            if let Err(error) = Args::try_parse_from(line.split_whitespace()) {
                panic!("{line}\n{error}");
            }
        }
    }
}

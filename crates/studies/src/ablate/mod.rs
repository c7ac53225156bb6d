//! `evpose ablate`: ablation studies of the hand and the body method.
//!
//! Every row of a study retrains the full method with one change, under several seeds, and compares
//! the result with the published statement about that change.
//!
//! * `rows`: the registry of changes, with the published statements; `selection`: rows by name.
//! * `finding`: the test of a published statement.
//! * `directories`: files of a study, and which of its steps are finished.
//! * `trial`: one row under one seed: trained, evaluated, timed.
//! * `hand`, `bodies`: all rows under all seeds. [`Stages`], [`Network`], [`networks`]: what bodies are trained
//!   with, which comparisons with other systems share.
//! * `outcome`: means over seeds with intervals; `table`, `networks_table` and `page` render them.
//!
//! ```
//! use clap::{FromArgMatches as _, Subcommand as _};
//! use evpose_studies::ablate::AblateCommand;
//!
//! # fn main() -> anyhow::Result<()> {
//! let ablate = AblateCommand::augment_subcommands(clap::Command::new("ablate"));
//! let parse = |args: [&str; 6]| ablate.clone().try_get_matches_from(args);
//!
//! // LNES windows of 33 ms, and poses without the Kalman filter, each compared with the full method.
//! let args = ["ablate", "hand", "--rows", "lnes-33,no-filter", "--out", "runs/ablation"];
//! let command = AblateCommand::from_arg_matches(&parse(args)?)?;
//! assert!(matches!(command, AblateCommand::Hand(_)));
//! // `evpose_studies::ablate::run(&command)` simulates, trains and evaluates, and writes the tables and a page.
//!
//! let unknown = ["ablate", "hand", "--rows", "no-such-row", "--out", "runs/ablation"];
//! assert!(parse(unknown).unwrap_err().to_string().contains("no-filter"), "known rows are listed");
//! # Ok(())
//! # }
//! ```

mod args;
mod bodies;
mod directories;
mod finding;
mod hand;
mod networks_table;
mod outcome;
mod page;
mod progress;
mod rows;
mod selection;
mod table;
mod trial;

use anyhow::Result;

pub use args::AblateCommand;
pub use bodies::{Network, StageArgs, Stages, networks};
pub use finding::{Relation, Verdict};

/// Runs an ablation.
///
/// # Errors
/// If a network cannot be trained or evaluated, or a result cannot be written.
pub fn run(command: &AblateCommand) -> Result<()> {
    match command {
        AblateCommand::Hand(args) => hand::run(args),
        AblateCommand::Body(args) => bodies::run(args),
    }
}

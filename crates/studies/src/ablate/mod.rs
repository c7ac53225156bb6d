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

//! `evpose ablate`: ablation studies of the hand and the body method.
//!
//! Every row of a study retrains the full method with one change, under several seeds, and compares
//! the result with the published statement about that change.
//!
//! * `rows`: the registry of changes, with the published statements.
//! * `trial`: one row under one seed: trained, evaluated, timed.
//! * `hand`: all rows under all seeds.
//! * `body`: the rows of bodies, which [`compare`](crate::compare) trains and evaluates as systems.

mod args;
mod body;
mod hand;
mod rows;
mod trial;

use anyhow::Result;

pub use args::AblateCommand;

/// Runs an ablation.
///
/// # Errors
/// If a network cannot be trained or evaluated, or a result cannot be written.
pub fn run(command: &AblateCommand) -> Result<()> {
    match command {
        AblateCommand::Hand(args) => hand::run(args),
        AblateCommand::Body(args) => body::run(args),
    }
}

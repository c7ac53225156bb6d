//! `evpose ablate`: what each part of a method is worth.
//!
//! * [`rows`]: the registry of what is changed, and what was published about it.
//! * [`finding`]: a published statement held against what was found.
//! * [`places`]: where everything lies, and what of it is finished.
//! * [`trial`]: one row under one seed: trained, evaluated, timed.
//! * [`hand`]: all rows under all seeds.
//! * [`bodies`]: the same for bodies.
//! * [`outcome`]: what they come to; [`table`] and [`page`] show it.

mod args;
mod bodies;
mod finding;
mod hand;
mod outcome;
mod page;
mod places;
mod rows;
mod table;
mod trial;
mod watch;

use anyhow::Result;

pub use args::AblateCommand;

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

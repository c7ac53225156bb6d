//! `evpose ablate`: ablation studies of the hand and the body method.
//!
//! Every row of a study retrains the full method with one change, under several seeds, and compares
//! the result with the published statement about that change.
//!
//! * `rows`: the registry of changes, with the published statements.
//! * `trial`: one row under one seed: trained, evaluated, timed.
//! * `hand`: all rows under all seeds.
//! * `body`: the rows of bodies, which [`compare`](crate::compare) trains and evaluates as systems.

mod body;
mod hand;
mod rows;
mod trial;

use anyhow::Result;

/// The ablation studies.
#[derive(Debug, clap::Subcommand)]
#[command(after_help = "Start with:\n  evpose ablate hand --out runs/ablation\n  \
    evpose ablate body --out runs/ablation-body")]
pub enum AblateCommand {
    /// The EventHands method: window lengths, representations, augmentation, filter, networks
    Hand(hand::AblateHandArgs),
    /// The MoveEnet method: representation, stages of training, resolution, moving cameras
    Body(body::AblateBodyArgs),
}

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

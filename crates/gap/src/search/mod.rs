//! Identification of the effects that a sensor model lacks, by forward selection with validation.
//!
//! # Algorithm
//! 1. `refit`: the model's own parameters (thresholds, background rates, clock offset) are fitted from
//!    several initial guesses (`initial_guess`). If that closes the gap, a parameter is wrong and
//!    nothing is missing.
//! 2. `forward_step`: every effect of the catalogue is screened at a grid of strengths on a short part
//!    of the training data (`screening`); the best are fitted in full (`catalogue`), refined
//!    (`refinement`), and scored on held-out data. The best one is added if it explains enough. At
//!    most two effects are added.
//! 3. `pairs`: if that leaves too much, candidates that may only help together are tried in pairs.
//! 4. `swap_move`: with two effects, the first is tested again: dropped, and swapped for its rivals.
//! 5. `decision`: from discrepancies and gaps to an [`Answer`](crate::verdict::Answer).
//!
//! Parameters that a recording shows without a fit are estimated directly (`direct_estimates`).

mod catalogue;
mod decision;
mod direct_estimates;
mod event_distance;
mod forward_step;
mod identification;
mod identify;
mod initial_guess;
mod pairs;
mod recording_marks;
mod refinement;
mod refit;
mod screening;
mod swap_move;

pub use decision::gap_closed;
pub use identification::{
    AddedEffect, Contender, DataSplits, FittedCandidate, Identification, ModelScore,
};

/// Receives a line of text at the beginning of each stage of the search.
pub type StageCallback<'a> = &'a dyn Fn(&str);

//! Identification of the effects that a sensor model lacks: stepwise selection with validation.
//!
//! # Algorithm
//! 1. What the time stamps prove, a readout, a clock or a rate control, is added first, so that it
//!    hides nothing (`direct_estimates`).
//! 2. `refit`: the model's own parameters (thresholds, background rates, clock offset) are fitted
//!    from several initial guesses (`initial_guess`).
//! 3. `screening`: every effect of the catalogue is simulated beside the refitted model at a grid of
//!    strengths, on a short part of the training data.
//! 4. `stepwise`: the best `proposals` beside the model so far are fitted (`candidate_fit`) and
//!    scored on held-out data; the best is added if it is worth its name (`decision`), and all
//!    parameters are fitted together. This repeats until none is.
//! 5. `swap_move`: each effect is tested against its rivals beside the others, its `relatives` among them.
//! 6. `elimination`: effects and parameters that are not worth their names beside the others are
//!    dropped. Effects are tried in the place of changed parameters (`stepwise`), which may have
//!    absorbed what they do.
//! 7. `discovery`: where something is left that no effect explains, a formula with a term of
//!    `formula_terms` is tried.
//! 8. `explanation`: what each explains alone and beside the others, and what is left.
//!
//! Whether a difference is significant is decided by replicates on the scene at hand
//! (`significance`).

mod budget;
mod candidate_fit;
mod decision;
mod direct_estimates;
mod discovery;
mod elimination;
mod explanation;
mod formula_terms;
mod identification;
mod identify;
mod initial_guess;
mod light_steps;
mod paths;
mod places;
mod proposals;
mod rate_ceiling;
mod recording_marks;
mod refinement;
mod refit;
mod relatives;
mod screening;
mod selection;
mod significance;
mod stepwise;
mod swap_move;

pub use budget::Budget;
pub use decision::{excess_closed, is_within_tolerance};
pub(crate) use formula_terms::{FORMULA, Term};
pub use identification::{
    AddedEffect, ChangedParameter, Contender, DataSplits, ExplainedFraction, FittedCandidate,
    Identification, Left, ModelScore,
};
pub(crate) use recording_marks::common_period_us;
pub(crate) use significance::student_upper_tail;

/// Receives a line of text at the beginning of each stage of the search.
pub type StageCallback<'a> = &'a dyn Fn(&str);

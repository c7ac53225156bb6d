//! The workflow from a recording to a verdict, as library calls.
//!
//! ```text
//! Inputs   two recordings with their scenes, a model, nominal values of the sensor
//!   -> Prepared         the model and its reference; reference scenes of training and held-out data
//!   -> Identification   the missing effects, see [`search`](crate::search)
//!   -> Outcome          the verdict with intervals, limits and checks, and its evidence; the corrected model; a report
//! ```
//!
//! Models are scored on held-out data: another recording, or the later part of the only one.

mod ablation;
pub mod calibrate;
mod calibration;
mod chance;
mod directions;
mod errors;
mod evidence;
mod findings;
mod found_formula;
mod frame_nuisance;
mod gap_value;
mod inputs;
mod limits;
mod model;
mod next_step;
mod nuisance;
mod nuisance_spread;
mod outcome;
mod own_run;
mod pose_nuisance;
mod scene_free_verdict;
mod stage_shares;
mod subsets;
mod time_grid;

pub use crate::goodness::test_name;
pub use ablation::ablation;
pub use calibration::{
    CALIBRATION, Calibration, ErrorScale, FEATURES, FindingEvidence, ParameterOwner,
};
pub use chance::p_of_largest_deviation;
pub use directions::{Direction, Directions};
pub use errors::RawError;
pub use evidence::AnswerEvidence;
pub use frame_nuisance::FRAME_NUISANCE;
pub use gap_value::gap_value;
pub use inputs::{ComparisonCase, HeldOut, Inputs, Prepared};
pub use limits::{Limits, limits};
pub use model::{Model, prepared, with_stamp_period};
pub use nuisance::{Nuisance, NuisanceSample};
pub use outcome::{Outcome, answer_score, findings_of_answer, outcome};
pub use own_run::{OwnRun, own_run};
pub use pose_nuisance::POSE_NUISANCE;
pub use scene_free_verdict::{as_effect, scene_free_verdict};

#[cfg(test)]
mod tests;

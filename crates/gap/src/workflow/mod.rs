//! The whole way from a recording to a verdict, as library calls.
//!
//! ```text
//! Inputs   two recordings with their scenes, a model, what its maker says of the sensor
//!   -> Prepared   the model and its reference; stages of what is fitted and what is held out
//!   -> Named      what is missing, see [`naming`](crate::naming)
//!   -> Outcome    the verdict with intervals, limits and checks; the corrected model; a report
//! ```
//!
//! Everything is judged on what was held out: another recording, or the later part of the only one.

mod bare;
pub mod calibrate;
mod calibration;
mod chance;
mod directions;
mod errors;
mod findings;
mod frames;
mod gap_value;
mod inputs;
mod limits;
mod looks;
mod model;
mod outcome;
mod own_run;
mod parts;
mod pose;
mod spread;
mod trials;

pub use bare::{as_effect, bare};
pub use calibration::{CALIBRATION, Calibration, ErrorScale, Evidence, FEATURES, NumberKind};
pub use chance::chance_of_largest;
pub use directions::{Direction, Directions};
pub use errors::RawError;
pub use findings::{Evidenced, evidenced, findings};
pub use frames::OF_FRAMES;
pub use gap_value::gap_value;
pub use inputs::{Case, HeldOut, Inputs, Prepared};
pub use limits::{Limits, limits};
pub use looks::{Look, Unknown};
pub use model::{Model, prepared, stamped};
pub use outcome::{Outcome, answered, effects_of, evidence_of, outcome};
pub use own_run::{OwnRun, own_run};
pub use pose::OF_POSES;
pub use trials::ablation;

#[cfg(test)]
mod tests;

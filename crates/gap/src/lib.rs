//! Finds where simulated and measured events disagree, and names the missing effect.
//!
//! ```text
//! recording + scene + sensor model
//!   -> Stage      the scene, its classes, the reference's events
//!   -> Summary    the same probes on measured and simulated events
//!   -> Null       replicates of the model: what differences chance makes
//!   -> Naming     every effect of the catalogue fitted; parameters first
//!   -> Verdict    no gap, a parameter, effects, none of the catalogue, undecided
//! ```

mod answer;
pub mod c2st;
pub mod candidate;
mod classes;
mod closeness;
pub mod compare;
pub mod davis;
mod error;
mod exchange;
mod finish;
pub mod fit;
mod guess;
mod hint;
pub mod input;
pub mod knob;
mod lab;
mod linear;
pub mod locate;
pub mod naming;
mod normal;
mod pair;
pub mod parameters;
mod polish;
pub mod probe;
pub mod report;
mod scene;
mod screen;
pub mod search;
mod simulate;
mod step;
mod summary;
pub mod surrogate;
pub mod verdict;
mod view;
pub mod workflow;

pub use classes::{Cell, Classes};
pub use compare::{Expectation, by_block, gap, misfit, rho, rho_of_chance};
pub use error::GapError;
pub use lab::Lab;
pub use scene::Scene;
pub use summary::{Block, Entry, Kind, Layout};
pub use view::{Expected, Sight, Stage, View};

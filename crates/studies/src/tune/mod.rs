//! `evpose tune`: hyper-parameter search for the networks of any task.
//!
//! A file names fields of a config and how each is drawn. Trial 0 is the config as it is, every
//! other one has values drawn for it. Random search trains all trials to the end; successive
//! halving trains all of them for a short time, and the best for longer, from their checkpoints.
//!
//! * [`space`]: the file of ranges; [`distribution`]: how one parameter is drawn.
//! * [`plan`]: how many trials are trained, and how long.
//! * `trials`: the configs of the trials.
//! * `directory`: the files of a search; [`rung_result`]: what a trial came to.
//! * `ranking`: the order of trials; `search`: the loop.
//! * `outcome` and `page`: the results as JSON, as a table and as a page.
//!
//! ```
//! use evpose_studies::tune::space::SearchSpace;
//!
//! # fn main() -> Result<(), evpose_studies::tune::space::SpaceError> {
//! let text = "[training]\nlearning_rate = { log_uniform = [1e-4, 1e-2] }\n\
//!             batch_size = { choose = [16, 32] }\n";
//! let space = SearchSpace::parse("over.toml".as_ref(), text)?;
//! let names: Vec<&str> = space.parameters().iter().map(|p| p.field.as_str()).collect();
//! assert_eq!(names, ["training.learning_rate", "training.batch_size"]);
//!
//! // A draw depends on the seed, the field and the trial, and on nothing else.
//! let rate = &space.parameters()[0];
//! assert_eq!(rate.draw(1, 7), rate.draw(1, 7));
//! # Ok(())
//! # }
//! ```

mod args;
mod directory;
pub mod distribution;
mod outcome;
mod page;
pub mod plan;
mod ranking;
pub mod rung_result;
mod search;
pub mod space;
mod trials;

pub use args::{TuneArgs, TuneMethod};
pub use search::run;

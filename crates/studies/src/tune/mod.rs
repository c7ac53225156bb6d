//! `evpose tune`: hyper-parameter search for the networks of any task.
//!
//! A file names fields of a config and how each is drawn. Trial 0 is the config as it is, every
//! other one has values drawn for it. Random search trains all trials to the end; successive
//! halving trains all of them for a short time, and the best for longer, from their checkpoints.
//!
//! * [`space`]: the file of ranges; [`distribution`]: how one parameter is drawn.
//! * [`plan`]: how many trials are trained, and how long; their order.
//! * `trials`: the configs of the trials.
//! * [`rung_result`]: what a trial came to.
//! * `search`: the loop.
//! * `outcome` and `report`: the results as JSON and CSV, as a table and charts.
//!
//! | file | content |
//! |---|---|
//! | `config.toml`, `over.toml`, `tune.toml`, `run.toml` | the config, the ranges, the plan, seed and build |
//! | `data/` | recordings of all trials, without `--data` |
//! | `trials/0007/run` | training run of a trial |
//! | `trials/0007/rung-1.json` | its result at the end of a rung |
//! | `tune.json`, `trials.csv`, `tune.md`, `tune.html`, `best.toml` | results |
//!
//! ```
//! use evpose_studies::tune::space::SearchSpace;
//!
//! # fn main() -> anyhow::Result<()> {
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
pub mod distribution;
mod outcome;
pub mod plan;
mod report;
pub mod rung_result;
mod search;
pub mod space;
mod trials;

pub use args::{TuneArgs, TuneMethod};
pub use search::run;

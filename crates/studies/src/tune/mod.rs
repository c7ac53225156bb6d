//! `evpose tune`: hyper-parameter search for the networks of any task.
//!
//! A file names fields of a config and how each is drawn. Trial 0 is the config as it is, every
//! other one has values drawn for it. Random search trains all trials to the end; successive
//! halving trains all of them for a short time, and the best for longer, from their checkpoints.
//!
//! * `space`: the file of ranges; `distribution`: how one parameter is drawn.
//! * `plan`: how many trials are trained, and how long; their order.
//! * `trials`: the configs of the trials.
//! * `rung_result`: what a trial came to.
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

mod args;
mod distribution;
mod outcome;
mod plan;
mod report;
mod rung_result;
mod search;
mod space;
mod trials;

pub use args::{TuneArgs, TuneMethod};
pub use search::run;

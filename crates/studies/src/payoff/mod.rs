//! `evpose gap payoff`: what closing the gap of a sensor model is worth.
//!
//! Training data are simulated with the model as given and with the corrected one, of the same
//! scenes under the same seeds. A network is trained on each, with the same seed and for the same
//! number of steps, and both are evaluated on recordings of the measured camera. Their difference,
//! paired by recording, is what the correction was worth.
//!
//! * `args`: arguments of the command.
//! * `models`: the sensor models that are compared.
//! * `directory`: files of a study.
//! * `study`: simulates, trains and evaluates.
//! * [`table`]: scores and paired differences, with intervals.
//! * `text` and `page` render the result.

mod args;
mod directory;
mod models;
mod page;
mod study;
pub mod table;
mod text;

pub use args::PayoffArgs;
pub use study::run;

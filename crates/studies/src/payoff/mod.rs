//! `evpose gap payoff`: what closing the gap of a sensor model is worth.
//!
//! Training data are simulated with the model as given and with the corrected one, of the same
//! scenes under the same seeds. A network is trained on each, with the same seed and for the same
//! number of steps, and both are evaluated on recordings of the measured camera. Their difference,
//! paired by recording, is what the correction was worth.
//!
//! * `args`: arguments of the command.
//! * `models`: the sensor models that are compared.
//! * `study`: simulates, trains and evaluates.
//! * `table`: scores and paired differences, with intervals.
//! * `report`: the result as tables and charts.
//!
//! | file | content |
//! |---|---|
//! | `models/given.toml`, `models/corrected.toml`, `models/camera.toml` | sensor models |
//! | `held-out/` | recordings of the camera, with `--camera` |
//! | `seed-1/given/data`, `seed-1/given/network` | training data and network of a model under a seed |
//! | `payoff.json`, `payoff.md`, `report.html` | results |

mod args;
mod models;
mod report;
mod study;
mod table;

pub use args::PayoffArgs;
pub use study::run;

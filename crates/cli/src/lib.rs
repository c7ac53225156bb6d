//! The commands of evpose as a library: what each does, the pose tasks behind them, and what they
//! share. The program has the registry of them.
//!
//! * [`commands`]: one file or folder per command.
//! * [`tasks`]: the registry of pose tasks, and the commands that every task implements.
//! * [`pages`]: reports of experiments, galleries, images of people.
//! * [`args`]: the groups of arguments that several commands take.
//! * [`configs`]: embedded configs and config files.
//! * [`run_info`]: config, seed and commit beside every output.
//! * [`shipped`]: checkpoints that come with the program, by name.
//! * [`sidecar`]: sizes of sensors that files beside recordings state.
//! * [`recorded`]: simulated data sets on disk, made where they are missing.
//! * [`ranges`], [`outputs`]: ranges of numeric arguments, and files that commands write.
//! * [`progress`]: bars and lines on the terminal.
//! * [`machine`], [`provenance`], [`latency`]: measurements, and the machine, program and day they were made on.
//!
//! ```
//! use evpose_task::hand::HandConfig;
//!
//! let changes = ["training.steps=10".to_owned()];
//! let config: HandConfig = evpose_cli::configs::load("quick", &changes)?;
//! assert_eq!(config.training.steps, 10);
//! # Ok::<(), anyhow::Error>(())
//! ```

pub mod args;
pub mod bad_input;
pub mod commands;
pub mod configs;
pub mod json;
pub mod latency;
pub mod machine;
pub mod outputs;
pub mod pages;
pub mod progress;
pub mod provenance;
pub mod ranges;
pub mod recorded;
pub mod run_info;
mod scene_source;
pub mod sensor_source;
pub mod shipped;
pub mod sidecar;
mod signals;
pub mod tasks;
pub mod threads;

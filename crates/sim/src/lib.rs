//! Simulation of hands and people in front of an event camera, with pose labels.
//!
//! * [`SimulationConfig`]: everything but the seed; the default is the published setting.
//! * [`Simulation`]: a run and the state shared by its sequences; [`Simulator`]: one sequence, step
//!   by step.
//! * [`record`], [`record_all`], [`record_shard`]: sequences as `.evc` and `.meta` files, with a
//!   [`SequenceInfo`] beside them.
//! * [`person`]: whole people instead of hands.
//! * [`randomisation`]: fields of a configuration that differ from recording to recording.
//! * [`set`]: a directory that several machines fill, its manifest and its verification.
//! * [`raster`], [`scene`], [`texture`]: rendering of the frames that the sensor is exposed to.
//!
//! One step is: pose, rendering, label, exposure, events. The label of frame k is the pose at its
//! end; its events happened since the end of frame k - 1. Sequences run in parallel, each on one
//! thread, and are a function of the configuration, the seed and their index.
//!
//! ```
//! use evpose_sim::{SimulationConfig, Simulator};
//!
//! let config = SimulationConfig { image_scale: 0.5, ..SimulationConfig::default() };
//! let mut simulator = Simulator::new(&config, 1)?;
//! for _ in 0..10 {
//!     let step = simulator.advance()?;
//!     assert_eq!(step.luminance.width(), 120);
//!     assert!(step.label.translation_m.is_finite());
//! }
//! # Ok::<(), evpose_sim::SimError>(())
//! ```

mod actor;
pub mod config;
mod episode;
mod error;
mod event_format;
mod light;
mod moving_hand;
mod other_hand;
pub mod person;
pub mod randomisation;
pub mod raster;
mod record;
mod recording_time;
pub mod scene;
mod sequence_info;
pub mod set;
mod simulation;
mod simulator;
mod stopwatch;
pub mod texture;

pub use actor::{Actor, HandPoints3};
pub use config::SimulationConfig;
pub use episode::Episode;
pub use error::SimError;
pub use event_format::{EventFormat, StepWriter};
pub use record::{RecordedRun, SequenceFiles, record, record_all, record_shard};
pub use recording_time::RecordingTime;
pub use sequence_info::{EpisodeInfo, SequenceInfo};
pub use set::{SequenceSet, Shard};
pub use simulation::Simulation;
pub use simulator::{HandStep, Simulator};
pub use stopwatch::{SimulationPart, Stopwatch};

/// Appends an ending to a stem; a dot in the stem does not start one.
pub(crate) fn with_ending(stem: &std::path::Path, ending: &str) -> std::path::PathBuf {
    let mut name = stem.as_os_str().to_os_string();
    name.push(".");
    name.push(ending);
    std::path::PathBuf::from(name)
}

#[cfg(test)]
mod shapes;

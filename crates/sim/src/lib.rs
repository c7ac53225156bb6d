//! A hand before an event camera: scenes, a tile-free rasteriser, randomisation and labelled
//! recordings.
pub mod config;
mod episode;
mod error;
pub mod raster;
mod record;
pub mod scene;
mod sequence_info;
mod simulation;
mod simulator;
pub mod texture;

pub use config::SimulationConfig;
pub use episode::Episode;
pub use error::SimError;
pub use record::{Recorded, RecordedRun, record, record_all};
pub use sequence_info::{EpisodeInfo, SequenceInfo};
pub use simulation::Simulation;
pub use simulator::{Simulator, Step};

#[cfg(test)]
mod shapes;

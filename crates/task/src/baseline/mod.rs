//! The networks that MoveEnet is compared with: DHP19's, and LiftMono-HPE.
//!
//! * [`BaselineConfig`]: the file that describes an experiment with one of them.
//! * [`BaselineCheckpoint`]: a network on disk, ours or as distributed.
//! * [`BaselinePredictor`]: images in, joints out.
//! * [`LiftGeometry`]: joints in metres to the network's coordinates and back.
//! * [`baseline_stream`]: events to poses.

mod checkpoint;
mod config;
mod geometry;
mod input;
mod predictor;
mod stream;

pub use checkpoint::{BaselineCheckpoint, PUBLISHED_TORSO_M};
pub use config::{BaselineConfig, BaselineDecodingConfig, BaselineImageConfig, BaselineLossConfig};
pub use geometry::{LiftGeometry, torso_m};
pub use input::BaselineInput;
pub use predictor::{BaselineJoints, BaselinePredictor};
pub use stream::{BaselineFrontend, BaselinePose, baseline_stream};

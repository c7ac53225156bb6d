//! The networks that MoveEnet is compared with: DHP19's, and LiftMono-HPE.
//!
//! * [`BaselineConfig`]: the file that describes an experiment with one of them.
//! * [`BaselineCheckpoint`]: a network on disk, ours or as distributed.
//! * [`BaselinePredictor`]: images in, joints out.
//! * [`LiftGeometry`]: joints in metres to the network's coordinates and back.
//! * [`baseline_stream`]: events to poses.
//!
//! A file or a folder of its name has what one of the two has alone.

mod checkpoint;
mod config;
mod dhp19;
mod input;
mod lift_mono;
mod predictor;
mod stream;

pub use checkpoint::BaselineCheckpoint;
pub use config::{BaselineConfig, BaselineDecodingConfig, BaselineImageConfig, BaselineLossConfig};
pub use input::BaselineInput;
pub use lift_mono::{LiftGeometry, PUBLISHED_TORSO_M, torso_m};
pub use predictor::{BaselineJoints, BaselinePredictor};
pub use stream::{BaselineFrontend, BaselinePose, baseline_stream};

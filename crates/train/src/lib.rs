//! From recordings to a trained and evaluated network.
//!
//! * [`HandDataset`]: recordings as samples and windows.
//! * [`train_hand`]: a run in its directory, resumable to the bit.
//! * [`evaluate`]: networks and baselines on sequences with known poses.
//! * [`evaluate_slow_motion`]: the same for the slow-motion mode.
//! * [`Condition`]: slow hands, little light: other sequences to evaluate on.
//! * [`body`]: the same for bodies: images, targets, training, evaluation.
//! * [`baseline`]: the same for the networks that MoveEnet is compared with.
//!
//! ```
//! use evpose_nn::DeviceKind;
//! use evpose_sim::{Simulation, record_all};
//! use evpose_task::hand::HandConfig;
//! use evpose_train::{ProgressCallback, TrainOptions, train_hand};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut config = HandConfig::default();
//! config.simulation.image_scale = 0.15;
//! config.simulation.sequences = 1;
//! config.simulation.seconds = 0.6;
//! config.network.width = 0.0625;
//! config.training.batch_size = 4;
//! config.training.steps = 2;
//! config.training.steps_per_validation = 2;
//! config.training.validation_s = 0.2;
//! config.training.validation_samples = 4;
//!
//! let directory = tempfile::tempdir()?;
//! let (data, run) = (directory.path().join("data"), directory.path().join("run"));
//! record_all(&Simulation::new(&config.simulation, config.seed)?, &data, &|_| {})?;
//! let options = TrainOptions {
//!     device: DeviceKind::Flex,
//!     resume: false,
//!     plain: true,
//!     progress: Some(ProgressCallback::new(|progress| assert!(progress.samples <= 8))),
//!     pause_after: None,
//! };
//! let summary = train_hand(&config, &data, &run, &options)?;
//! assert_eq!(summary.samples, 8);
//! assert!(run.join("best.bpk").exists());
//! # Ok(())
//! # }
//! ```

mod barrier;
pub mod baseline;
mod batch_loader;
pub mod body;
mod checkpoint;
#[cfg(feature = "tui")]
mod dashboard;
mod devices;
mod error;
mod guard;
mod hand;
mod history;
mod listing;
mod metric;
mod order;
mod passes;
mod plain_renderer;
mod prefetch;
mod progress_renderer;
mod retention;
pub mod training;
mod waiting;

pub use checkpoint::newest_checkpoint;
pub use error::TrainError;
pub use hand::{
    CONDITIONS, Condition, ConditionEntry, HAND_VALUES, HandDataset, HandLabelTrack, HandPoseTrack,
    HandSequence, JOINT_VALUES, JointBatch, JointLabel, Method, MethodResults, Sample,
    SlowMotionResults, SlowMotionUsage, evaluate, evaluate_slow_motion, evaluated_pose_count,
    foreign, train_hand, untrained,
};
pub use history::{HistoryLine, HistorySplit, read_history, validation_losses, validation_means};
pub use metric::{LOSS, LoggedValue};
pub use progress_renderer::{Progress, ProgressCallback};
pub use training::{TrainOptions, TrainSummary};
pub use waiting::DataWait;

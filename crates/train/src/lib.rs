//! From recordings to a trained and judged network.
//!
//! * [`HandDataset`]: recordings as samples and windows.
//! * [`train_hand`]: a run in its directory, resumable to the bit.
//! * [`evaluate`]: networks and baselines on sequences with known poses.
//! * [`evaluate_slow_motion`]: the same for the slow-motion mode.
//! * [`Condition`]: slow hands, little light: other sequences to judge on.
//! * [`body`]: the same for bodies: images, targets, training, evaluation.

mod barrier;
pub mod body;
mod checkpoint;
mod condition;
mod dataset;
mod devices;
mod error;
mod evaluation;
mod guard;
mod hand_learner;
mod hand_training;
mod history;
mod loader;
mod metric;
mod order;
mod passes;
mod plain_renderer;
mod prefetch;
mod progress_renderer;
mod retention;
mod slow_motion;
mod training;
mod waiting;

pub use checkpoint::newest_checkpoint;
pub use condition::{CONDITIONS, Condition};
pub use dataset::{HandDataset, HandSequence, Sample};
pub use error::TrainError;
pub use evaluation::{Method, MethodResults, Track, evaluate, evaluated_pose_count};
pub use hand_training::{train_hand, untrained};
pub use history::{HistoryLine, Part, read_history, validation_losses};
pub use progress_renderer::{Progress, ProgressCallback};
pub use slow_motion::{SlowMotionResults, SlowMotionUsage, evaluate_slow_motion};
pub use training::{TrainOptions, TrainSummary};
pub use waiting::DataWait;

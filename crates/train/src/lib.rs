//! From recordings to a trained and judged network.
//!
//! * [`HandConfig`]: the file that describes an experiment.
//! * [`HandDataset`]: recordings as samples and windows.
//! * [`train_hand`]: a run in its directory, resumable to the bit.
//! * [`Predictor`], [`evaluate`]: networks and baselines on sequences with known poses.
//! * [`Quantized`]: what a network has to know to compute in 8 bits.
//! * [`SlowMotionTracker`], [`evaluate_slow_motion`]: the mode for slow hands, and how good it is.
//! * [`Condition`]: slow hands, little light: other sequences to judge on.
//! * [`body`]: the same for bodies: images, targets, training, evaluation.

mod ahead;
pub mod body;
mod checkpoint;
mod condition;
mod config;
mod dataset;
mod devices;
mod differences;
mod error;
mod evaluation;
mod guard;
mod hand_task;
mod history;
mod loader;
mod meeting;
mod metric;
mod order;
mod plain_renderer;
mod predictor;
mod quantized;
mod retention;
mod saved;
mod slow_motion;
mod told_renderer;
mod toml_text;
mod training;
mod waiting;

pub use checkpoint::newest_checkpoint;
pub use condition::{CONDITIONS, Condition};
pub use config::{EvaluationConfig, HandConfig, RepresentationConfig, TrainingConfig};
pub use dataset::{HandDataset, HandSequence, Sample};
pub use devices::DeviceStrategy;
pub use differences::FieldDifference;
pub use error::TrainError;
pub use evaluation::{Evaluated, Method, Stage, Track, evaluate, poses_to_judge};
pub use history::{HistoryLine, Part, read_history, validation_losses};
pub use predictor::{ConstantPose, NetworkPredictor, Predictor};
pub use quantized::Quantized;
pub use saved::Checkpoint;
pub use slow_motion::{
    SlowMotionConfig, SlowMotionEvaluated, SlowMotionPose, SlowMotionTracker, SlowMotionUsage,
    SurfaceBatch, evaluate_slow_motion,
};
pub use told_renderer::{HowFar, Told};
pub use training::{TrainOptions, TrainSummary, train_hand, untrained};
pub use waiting::DataWait;

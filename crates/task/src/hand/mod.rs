//! The hand task: EventHands.

mod batch;
mod camera_turns;
mod checkpoint;
mod config;
mod estimator;
mod frontend;
mod look;
mod looks;
mod predictor;
mod slow_motion;
mod tracker;
mod view;

pub use batch::{InputBatch, render_channels};
pub use camera_turns::CameraTurnConfig;
pub use checkpoint::{BEST, HandCheckpoint, LAST};
pub use config::{
    DeviceStrategy, EvaluationConfig, HandConfig, RepresentationConfig, TrainingConfig,
};
pub use estimator::{HandEstimate, HandEstimator};
pub use frontend::{HandFrontend, HandWorker, hand_stream};
pub use look::Look;
pub use looks::{LookErrors, Looks, LooksConfig};
pub use predictor::{ConstantPose, NetworkPredictor, Predictor};
pub use slow_motion::SlowMotionConfig;
pub use tracker::{SlowMotionTracker, poses_every_ms};
pub use view::{HandView, calibration_for, canonical_view};

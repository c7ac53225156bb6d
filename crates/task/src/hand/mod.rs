//! The hand task: EventHands.

mod batch;
mod camera_turns;
mod checkpoint;
mod config;
mod detection;
mod estimator;
mod evidence;
mod frontend;
mod joint_decoder;
mod joint_grid;
mod joint_observation;
mod perspective_crop;
mod predictor;
mod slow_motion;
mod smoothing;
mod two_pass;
mod view;

pub use batch::{InputBatch, render_channels};
pub use camera_turns::CameraTurnConfig;
pub use checkpoint::HandCheckpoint;
pub use config::{
    DeviceStrategy, EvaluationConfig, HandConfig, RepresentationConfig, TrainingConfig,
};
pub use detection::HandDetectionConfig;
pub use estimator::{HandEstimate, PresenceCounts};
pub use frontend::{HandFrontend, HandWorker, hand_recording, hand_stream};
pub use joint_decoder::JointDecoder;
pub use joint_grid::JointGrid;
pub use joint_observation::joint_observation;
pub use perspective_crop::PerspectiveCrop;
pub use predictor::{ConstantPose, NetworkPredictor, Predictor};
pub use slow_motion::SlowMotionConfig;
pub use two_pass::{CropErrors, TrainingView, TwoPass, TwoPassConfig};
pub use view::{HandView, calibration_for, canonical_view};

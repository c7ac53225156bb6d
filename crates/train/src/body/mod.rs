//! Bodies: what networks of MoveEnet are trained on and measured by.
//!
//! * [`BodyConfig`]: the file that describes an experiment.
//! * [`BodyFrames`], [`BodyRecordings`], [`Film`]: images with labels, from recordings or from photographs.
//! * [`train_body`]: a run in its directory, resumable to the bit; [`BodyCheckpoint`]: what comes of it.
//! * [`BodyPredictor`], [`evaluate_body`]: a network at work, and how good it is.
//! * [`BodyAugmentation`], [`BodyView`]: images and labels, each time a little different.
//! * [`BodyGrid`]: what the maps of a network should be for a label.
//! * [`BodyBatch`]: the same for many labels, and as tensors.
//! * [`BodyAccuracy`]: how many joints are found.

mod accuracy;
mod annotated;
mod augmentation;
mod batch;
mod config;
mod evaluation;
mod frames;
mod fused;
mod loader;
mod predictor;
mod recordings;
mod saved;
mod schedule;
mod targets;
mod task;
mod training;

pub use accuracy::{BodyAccuracy, BodyAccuracyConfig, BodyMeasure};
pub use augmentation::{BodyAugmentation, BodyView, Interpolation, resize_grey};
pub use batch::BodyBatch;
pub use config::{
    BodyConfig, BodyDataConfig, BodyDecodingConfig, BodyEvaluationConfig, BodyImageConfig,
    BodySourceKind, BodyTargetConfig, BodyTrainingConfig, LabelMoment,
};
pub use evaluation::{
    BodyEvaluated, BodyJudged, evaluate_body, judge_frames, mean_pose_of, truth_of,
};
pub use frames::{BodyFrame, BodyFrames};
pub use fused::{BetweenConfig, BetweenEvaluated, BetweenPose, evaluate_between, poses_between};
pub use predictor::{BodyPredictor, BodyPredictorOptions, joints_in_pixels};
pub use recordings::{BodyRecordings, Film, PoseTrack};
pub use saved::BodyCheckpoint;
pub use schedule::{EarlyStop, Schedule};
pub use targets::{BodyGrid, BodyTargetSlices};
pub use training::{BodyTrainSummary, first_network, train_body};

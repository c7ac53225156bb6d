//! Bodies: what networks of MoveEnet are trained on and measured by.
//!
//! * [`BodyFrames`], [`BodyRecordings`]: images with labels, from recordings or from photographs.
//! * [`train_body`]: a run in its directory, resumable to the bit.
//! * [`evaluate_body`]: evaluation of a network.
//! * [`evaluate_spatial`]: evaluation of joints in the world, from several cameras.
//! * [`BodyView`]: images and labels, each time a little different.
//! * [`BodyGrid`]: what the maps of a network should be for a label.
//! * [`BodyBatch`]: the same for many labels, and as tensors.
//! * [`BodyAccuracy`]: how many joints are found.

mod accuracy;
mod annotated;
mod augmentation;
mod batch;
mod confidence;
mod detections;
mod evaluation;
mod filter_noise;
mod frames;
mod loader;
mod loss;
mod propagation;
mod recordings;
mod spatial;
mod targets;
mod training;

pub use accuracy::{BodyAccuracy, BodyAccuracyConfig, BodyMeasure};
pub use annotated::holds_annotations;
pub use augmentation::BodyView;
pub use batch::BodyBatch;
pub use detections::DetectionCounts;
pub use evaluation::{
    BodyRecordingResult, BodyResults, evaluate_body, evaluate_frames, evaluate_frames_with,
    ground_truth, mean_pose_of_recordings,
};
pub use filter_noise::{ScoredPose, estimate_filter};
pub use frames::{BodyFrame, BodyFrames, CameraJoints};
pub use loss::BODY_VALUES;
pub use propagation::{PropagatedPose, PropagationResults, evaluate_propagation, propagated_poses};
pub use recordings::{BodyRecordings, PoseTrack};
pub use spatial::{CalibratedScene, calibrated_scenes, evaluate_spatial};
pub use targets::{BodyGrid, BodyTargetSlices};
pub use training::{first_network, train_body, train_body_validated_on};

//! The body task: MoveEnet.

mod augmentation;
mod batch;
mod canonical_events;
mod checkpoint;
mod config;
mod consensus;
mod detection;
mod frontend;
mod inference;
mod predictor;
mod propagation;
mod reader;
mod recent_events;
mod resample;
mod spatial;

pub use augmentation::BodyAugmentation;
pub use batch::ImageBatch;
pub(crate) use canonical_events::CanonicalEvents;
pub use checkpoint::BodyCheckpoint;
pub(crate) use checkpoint::{pose_as_text, pose_from_text};
pub use config::{
    BodyConfig, BodyDataConfig, BodyDecodingConfig, BodyEvaluationConfig, BodyImageConfig,
    BodySourceKind, BodyTargetConfig, BodyTrainingConfig, BodyViewKind, LabelTime, NoiseHistory,
    SecondPass,
};
pub use detection::BodyDetectionConfig;
pub(crate) use frontend::start_representation;
pub use frontend::{BodyFrontend, BodyPose, BodyWorker, body_stream};
pub use predictor::{BodyPredictor, BodyPredictorOptions};
pub use propagation::PropagationConfig;
pub use reader::RepresentationReader;
pub use resample::{Interpolation, resize_grey, sample};
pub use spatial::{PlacedRecording, SpatialConfig, SpatialPose, SpatialRecordings};

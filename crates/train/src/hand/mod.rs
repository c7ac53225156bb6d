//! Hands: recordings as samples, targets and loss, training, evaluation.

mod batches;
mod camera_turn;
mod condition;
mod dataset;
mod evaluation;
mod filter_noise;
pub mod foreign;
mod joints;
mod loss;
mod packed_events;
mod sequence_events;
mod slow_motion;
mod training;

pub use condition::{CONDITIONS, Condition};
pub use dataset::{HandDataset, HandLabelTrack, HandSequence, Sample};
pub use evaluation::{HandPoseTrack, Method, MethodResults, evaluate, evaluated_pose_count};
pub use joints::{JOINT_VALUES, JointBatch, JointLabel};
pub use loss::HAND_VALUES;
pub use slow_motion::{SlowMotionResults, SlowMotionUsage, evaluate_slow_motion};
pub use training::{train_hand, untrained};

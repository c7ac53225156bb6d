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

pub use condition::{CONDITIONS, Condition, ConditionEntry};
pub use dataset::{HandDataset, HandLabelTrack, HandSequence, Sample};
pub use evaluation::{HandPoseTrack, Method, MethodResults, evaluate, evaluated_pose_count};
pub use joints::{JOINT_VALUES, JointBatch, JointLabel};
pub use loss::HAND_VALUES;
pub use slow_motion::{SlowMotionResults, SlowMotionUsage, evaluate_slow_motion};
pub use training::{train_hand, untrained};

/// A config of one short sequence of small images, on which tests take a second.
#[cfg(test)]
fn small_config(image_scale: f32, seconds: f64) -> evpose_task::hand::HandConfig {
    let mut config = evpose_task::hand::HandConfig::default();
    config.simulation.image_scale = image_scale;
    config.simulation.sequences = 1;
    config.simulation.seconds = seconds;
    config.simulation.skin.texels = 64;
    config.network.width = 0.0625;
    config.training.steps_per_validation = 2;
    config.training.validation_s = 0.15;
    config.training.validation_samples = 4;
    config
}

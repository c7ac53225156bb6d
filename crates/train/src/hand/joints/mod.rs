//! Networks of joints: labels, batches, loss and training.
//!
//! * [`JointLabeller`]: the joints of a sample from `STEM.joints.npy`, or from the pose of its label.
//! * [`JointBatches`], [`JointBatch`]: samples as batches.
//! * [`JointTask`]: the training.

mod batches;
mod label;
mod loss;
mod no_hand;
mod presence;
mod training;

pub(crate) use batches::JointBatches;
pub use label::JointLabel;
pub(crate) use label::JointLabeller;
pub use loss::{JOINT_VALUES, JointBatch};
pub(crate) use no_hand::scramble;
pub(crate) use training::JointTask;

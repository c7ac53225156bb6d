//! Accuracy of bodies in images, with confidence intervals.
//!
//! From two lists of poses to a table:
//!
//! * [`BodyTruth`], [`BodyPrediction`]: true and predicted joints.
//! * [`BodyProtocol`]: the instants compared, and the treatment of missing joints.
//! * [`BodySequence`]: the errors of one sequence, at evenly spaced instants and at those of the
//!   predictions; [`BodyEvaluation`]: of all of them, and [`BodySummary`] the table.
//! * [`BodyErrors`]: joint by joint [`BodyPck`], MPJPE and [`RootMeanSquare`]; they add up over sequences.
//! * [`SpatialErrors`], [`SpatialSummary`]: MPJPE in millimetres of joints in the world.
//! * [`MeanBody`]: the baseline that ignores the events.

mod errors;
#[cfg(test)]
mod golden;
mod mean_body;
mod pck;
mod protocol;
mod root_mean_square;
mod sample;
mod sequence;
mod spatial;
mod summary;
mod track;

pub use errors::{BodyErrors, JointErrors};
pub use mean_body::MeanBody;
pub use pck::{BODY_THRESHOLDS, BodyPck};
pub use protocol::{BodyProtocol, MissingJoints};
pub use root_mean_square::RootMeanSquare;
pub use sample::{BodyPrediction, BodyTruth};
pub use sequence::BodySequence;
pub use spatial::{SpatialErrors, SpatialJoint, SpatialSummary};
pub use summary::{BodyEvaluation, BodyScores, BodySummary, JointScores};

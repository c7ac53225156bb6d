//! How good bodies in images are, and how sure that is.
//!
//! From two lists of poses to a table:
//!
//! * [`BodyTruth`], [`BodyPrediction`]: where joints were, and where a method saw them.
//! * [`BodyProtocol`]: which instants are compared, and how joints that are missing are treated.
//! * [`BodySequence`]: the errors of one sequence, at evenly spaced instants and at those of the
//!   predictions; [`BodyEvaluation`]: of all of them, and [`BodySummary`] the table.
//! * [`BodyErrors`]: joint by joint [`BodyPck`], MPJPE and [`RootMeanSquare`]; they add up over sequences.
//! * [`VelocityErrors`]: how fast joints are; [`SavitzkyGolay`] smooths that.
//! * [`MeanBody`]: the predictor to beat, which never looks at an event.

mod errors;
#[cfg(test)]
mod golden;
mod mean_body;
mod pck;
mod protocol;
mod root_mean_square;
mod sample;
mod savitzky_golay;
mod sequence;
mod summary;
mod track;
mod velocity;

pub use errors::{BodyErrors, JointErrors};
pub use mean_body::MeanBody;
pub use pck::{BODY_THRESHOLDS, BodyPck};
pub use protocol::{BodyProtocol, MissingJoints};
pub use root_mean_square::RootMeanSquare;
pub use sample::{BodyPrediction, BodyTruth};
pub use savitzky_golay::SavitzkyGolay;
pub use sequence::BodySequence;
pub use summary::{BodyEvaluation, BodyScores, BodySummary, JointScores};
pub use velocity::{PredictedVelocity, VelocityErrors, VelocityProtocol};

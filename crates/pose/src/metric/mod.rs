//! Accuracy of poses, with confidence intervals (`evpose_core::stats`).
//!
//! From one frame to a table:
//!
//! * [`HandError`]: wrist position, rotation and articulation of one predicted hand.
//! * [`palm_errors_percent`], [`root_aligned_errors_mm`]: errors of its points.
//! * [`FingerScores`]: which fingers are extended, and which gestures are taken for which.
//! * [`Pck`]: the share of point errors below each threshold, and the area under that curve.
//! * [`SequenceScores`]: all of the above over one sequence; [`HandEvaluation`]: over all of them.
//! * [`MeanPose`]: the baseline that ignores the events.
//! * [`body`]: the same for bodies in images.

pub mod body;
mod fingers;
mod hand_error;
mod mean_pose;
mod pck;
mod points;
mod summary;

pub use fingers::{DIGITS, FingerScores, FingerState, GestureConfusion, finger_states, gesture_of};
pub use hand_error::HandError;
pub use mean_pose::MeanPose;
pub use pck::{ErrorCounts, Pck, THRESHOLDS};
pub use points::{HandPoints, PALM_POINTS, palm_errors_percent, root_aligned_errors_mm};
pub use summary::{
    FingerSummary, HandEvaluation, HandRatios, HandSummary, PckCurves, SequenceScores,
};

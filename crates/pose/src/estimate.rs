//! Poses of any task.

use crate::HandParams;
use crate::body::{BODY_JOINTS, BodyPoints};
use crate::metric::HandPoints;

/// A pose of a task.
#[derive(Debug, Clone, PartialEq)]
pub enum PoseEstimate {
    /// Joints of a person in pixels of the sensor, with their scores.
    Body {
        /// Positions of joints; none for those that were not detected.
        joints_px: BodyPoints,
        /// Scores of the joints, 0 to 1.
        scores: [f32; BODY_JOINTS],
    },
    /// A hand.
    Hand {
        /// Its 12 parameters.
        params: HandParams,
        /// Its 21 points.
        points: Box<HandPoints>,
    },
}

//! Poses that come out.

use std::time::Duration;

use evpose_core::Micros;
use evpose_pose::HandParams;
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_pose::metric::HandPoints;

/// Who made a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Origin {
    /// A network, from an image of events.
    Network,
    /// A filter, between two poses of the network: never counted as one of these.
    Between,
}

/// A pose.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// Joints of a person in pixels of the sensor, and how sure the network was of each.
    Body {
        /// Where joints are; none that was not found.
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

/// A pose, when it was so, and how late it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct LivePose {
    /// Time of the newest event that it takes into account, by the clock of the events.
    pub t: Micros,
    /// From when that event happened to when the pose was known.
    pub latency: Duration,
    /// Who made it.
    pub origin: Origin,
    /// The pose.
    pub answer: Answer,
}

//! Poses that come out.

use std::time::Duration;

use evpose_core::Micros;
use evpose_pose::PoseEstimate;

/// Who made a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Origin {
    /// A network, from an image of events.
    Network,
    /// A filter, between two poses of the network: never counted as one of these.
    Propagated,
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
    pub pose: PoseEstimate,
}

//! Poses of the online pipeline.

use std::time::Duration;

use evpose_core::Micros;
use evpose_pose::PoseEstimate;

/// Origin of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PoseOrigin {
    /// Inferred by the network from a representation of events.
    Network,
    /// Propagated by the filter after an inferred pose; counted separately.
    Propagated,
}

/// A pose with its event time stamp and latency.
#[derive(Debug, Clone, PartialEq)]
pub struct LivePose {
    /// Event time of the newest event that it depends on.
    pub t: Micros,
    /// Host time from that event to the pose.
    pub latency: Duration,
    /// Origin.
    pub origin: PoseOrigin,
    /// The pose.
    pub pose: PoseEstimate,
}

//! Poses of the online pipeline.

use std::time::Duration;

use evpose_core::Micros;
use evpose_io::poses::{PoseKind, TimedPose};
use evpose_pose::{PoseEstimate, PoseOrigin};

/// A pose with its event time stamp and latency.
#[derive(Debug, Clone, PartialEq)]
pub struct LivePose {
    /// Event time of the newest event that it depends on.
    pub t: Micros,
    /// Host time from that event to the pose.
    pub latency: Duration,
    /// Origin.
    pub origin: PoseOrigin,
    /// Estimated pose, with its event time stamp.
    pub pose: PoseEstimate,
}

impl LivePose {
    /// Kind of the pose.
    pub fn kind(&self) -> PoseKind {
        match self.pose {
            PoseEstimate::Body { .. } => PoseKind::Body,
            PoseEstimate::Hand { .. } => PoseKind::Hand,
            PoseEstimate::Values { layout, .. } => PoseKind::Values(layout),
        }
    }

    /// The pose as tables and JSON have it.
    pub fn timed(&self) -> TimedPose {
        TimedPose {
            latency_ms: Some(1e3 * self.latency.as_secs_f64()),
            // Also of nobody: whether a network said so is counted by it.
            origin: Some(self.origin),
            ..TimedPose::new(self.t, &self.pose)
        }
    }
}

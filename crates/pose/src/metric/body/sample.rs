//! One instant of a body: ground truth and prediction.

use crate::body::{BodyPoints, torso};

/// Ground truth of the joints of a body, and the length that normalises their errors.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyTruth {
    /// Time in seconds from the beginning of the sequence.
    pub t_s: f64,
    /// Joints in pixels, in the order of networks; none where not labelled.
    pub joints_px: BodyPoints,
    /// Reference length of the PCK's thresholds: the torso's diagonal or the size of the head. The
    /// PCK leaves out instants without it.
    pub size_px: Option<f32>,
}

impl BodyTruth {
    /// A body whose reference length is the diagonal of its torso.
    pub fn by_torso(t_s: f64, joints_px: BodyPoints) -> Self {
        Self { t_s, joints_px, size_px: torso(&joints_px) }
    }
}

/// Predicted joints of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyPrediction {
    /// Time stamp of the input, in seconds from the beginning of the sequence.
    pub t_s: f64,
    /// Latency of the prediction, in seconds.
    pub delay_s: f64,
    /// Joints in pixels, in the order of networks; none where not detected.
    pub joints_px: BodyPoints,
}

//! One instant of a body: as it was, and as a method saw it.

use crate::body::{BodyPoints, torso};

/// Where the joints of a body were, and the length that their errors are measured with.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyTruth {
    /// When, in seconds from the beginning of the sequence.
    pub t_s: f64,
    /// In pixels, in the order of networks; none where nobody labelled a joint.
    pub joints_px: BodyPoints,
    /// What the thresholds of the PCK are shares of: the torso's diagonal or the size of the head. The
    /// PCK leaves out instants where it is not known.
    pub size_px: Option<f32>,
}

impl BodyTruth {
    /// A body that is measured with the diagonal of its own torso.
    pub fn by_torso(t_s: f64, joints_px: BodyPoints) -> Self {
        Self { t_s, joints_px, size_px: torso(&joints_px) }
    }
}

/// Where a method saw the joints of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyPrediction {
    /// The instant this is about, in seconds from the beginning of the sequence.
    pub t_s: f64,
    /// How long it took to find, in seconds.
    pub delay_s: f64,
    /// In pixels, in the order of networks; none where a joint was not found.
    pub joints_px: BodyPoints,
}

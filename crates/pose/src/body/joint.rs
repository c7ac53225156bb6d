//! Joints of a body in an image.

use glam::Vec2;

/// A joint detected in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyJoint {
    /// Column and row relative to the width and the height of the image; none if the joint was not
    /// detected.
    pub position: Option<Vec2>,
    /// Confidence of the network, 0 to 1; 0 below the threshold.
    pub score: f32,
}

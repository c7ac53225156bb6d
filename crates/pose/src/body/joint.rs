//! Joints of a body in an image.

use glam::Vec2;

/// Stands for an unknown coordinate.
const MISSING: f32 = -1.0;

/// A joint detected in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyJoint {
    /// Column and row relative to the width and the height of the image; none if the joint was not
    /// detected.
    pub position: Option<Vec2>,
    /// Confidence of the network, 0 to 1; 0 below the threshold.
    pub score: f32,
}

impl BodyJoint {
    fn xy(&self) -> [f32; 2] {
        self.position.map_or([MISSING; 2], Vec2::into)
    }
}

/// `x0, y0, x1, y1, ...` relative to the image, both -1 for joints that were not detected: the published
/// mode `output`, and `label` for joints of labels.
pub fn positions(joints: &[BodyJoint]) -> Vec<f32> {
    joints.iter().flat_map(BodyJoint::xy).collect()
}

/// `x0, y0, score0, x1, ...`, otherwise as [`positions`]: the published mode `occlusion`.
pub fn positions_and_scores(joints: &[BodyJoint]) -> Vec<f32> {
    let row = |joint: &BodyJoint| {
        let [x, y] = joint.xy();
        [x, y, joint.score]
    };
    joints.iter().flat_map(row).collect()
}

//! A hand as a network sees it: parameters, and joints of networks that find them.

use glam::Vec3;

use crate::{EVALUATION_JOINTS, HandParams};

/// Count of joints.
const JOINTS: usize = EVALUATION_JOINTS.len();

/// A hand as a network sees it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HandPose {
    /// Its 12 parameters: of a network of joints, those fitted to them.
    pub params: HandParams,
    /// Its joints, of networks that find them. Twelve parameters cannot make most gestures; these can.
    pub joints: Option<HandJoints>,
}

/// Count of joints of the digits: of [`EVALUATION_JOINTS`] those behind the wrist and the fingertips.
pub const DIGIT_JOINTS: usize = JOINTS - 6;

/// The joints of a hand, in the order of [`EVALUATION_JOINTS`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandJoints {
    /// Positions in metres in the frame of the camera: x right, y up, looking along -z.
    pub camera_m: [Vec3; JOINTS],
    /// Likelihood of each joint near its position, 0 to 1.
    pub scores: [f32; JOINTS],
    /// Likelihood of a hand being in view, 0 to 1.
    pub presence: f32,
    /// Axis-angles of the joints of the digits relative to their parents, in radians, of the hand that is fitted to
    /// the positions: the 45 values of a full MANO pose, in the order of its files.
    pub rotations: [Vec3; DIGIT_JOINTS],
}

impl HandPose {
    /// Mean score of the joints, 0 to 1; none of networks that find none.
    pub fn mean_score(&self) -> Option<f32> {
        let mean = |scores: [f32; JOINTS]| scores.iter().sum::<f32>() / JOINTS as f32;
        self.joints.map(|joints| mean(joints.scores))
    }

    /// Likelihood of a hand being in view, 0 to 1; none of networks that do not say.
    pub fn presence(&self) -> Option<f32> {
        self.joints.map(|joints| joints.presence)
    }
}

impl From<HandParams> for HandPose {
    fn from(params: HandParams) -> Self {
        Self { params, joints: None }
    }
}

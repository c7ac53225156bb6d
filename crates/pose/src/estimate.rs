//! Poses of any task.

use crate::body::{BODY_JOINTS, BodyPoints};
use crate::metric::HandPoints;
use crate::{HandParams, PoseLayout};
use glam::Vec3;

/// A pose of a task.
#[derive(Debug, Clone, PartialEq)]
pub enum PoseEstimate {
    /// Joints of a person in pixels of the sensor, with their scores.
    Body {
        /// Positions of joints; none for those that were not detected, and none at all where nobody
        /// was.
        joints_px: BodyPoints,
        /// Scores of the joints, 0 to 1.
        scores: [f32; BODY_JOINTS],
        /// Score of the pose, 0 to 1: whether somebody is there.
        score: f32,
    },
    /// A hand.
    Hand {
        /// Its 12 parameters.
        params: HandParams,
        /// Its 21 points.
        points: Box<HandPoints>,
        /// The points in metres in the camera's frame: x right, y down, z forwards.
        camera_m: Box<[Vec3; 21]>,
        /// Likelihood of a hand being in view, 0 to 1; none of networks that do not say.
        score: Option<f32>,
    },
    /// Of another task.
    Values {
        /// The names of its values.
        layout: &'static PoseLayout,
        /// The values, in the order of the layout.
        values: Vec<f32>,
    },
}

impl PoseEstimate {
    /// Score of the pose, 0 to 1: see [`pose_score`](crate::body::pose_score); of hands that a
    /// hand is in view. None for hands of regressors, which see one in every input, and for other tasks.
    pub fn score(&self) -> Option<f32> {
        match self {
            Self::Body { score, .. } => Some(*score),
            Self::Hand { score, .. } => *score,
            Self::Values { .. } => None,
        }
    }
}

/// Origin of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PoseOrigin {
    /// Inferred by the network from a representation of events.
    Network,
    /// Propagated by the filter after an inferred pose; counted separately.
    Propagated,
    /// The last inferred pose once more, where nothing that is known of the motion makes it better; counted with those
    /// propagated.
    Held,
    /// Of a row that says that nobody is in view: there is no pose.
    Nobody,
}

impl PoseOrigin {
    /// All origins.
    pub const ALL: [Self; 4] = [Self::Network, Self::Propagated, Self::Held, Self::Nobody];

    /// Name in tables and JSON: `network`, `propagated`, `held` or `nobody`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Network => "network",
            Self::Propagated => "propagated",
            Self::Held => "held",
            Self::Nobody => "nobody",
        }
    }
}

/// Frame of coordinates of joints in metres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum JointFrame {
    /// The camera's, as OpenCV has it: x right, y down, z forwards.
    #[default]
    Camera,
    /// The world of the simulation.
    World,
}

impl JointFrame {
    /// All frames.
    pub const ALL: [Self; 2] = [Self::Camera, Self::World];

    /// Name in tables and JSON: `camera` or `world`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::World => "world",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_and_hands_that_were_looked_for_have_a_score() {
        let (joints_px, scores) = ([None; BODY_JOINTS], [0.5; BODY_JOINTS]);
        let body = PoseEstimate::Body { joints_px, scores, score: 0.25 };
        assert_eq!(body.score(), Some(0.25));
        let hand = PoseEstimate::Hand {
            params: HandParams::default(),
            points: Box::new(HandPoints { world_m: [Vec3::ZERO; 21], image_px: [None; 21] }),
            camera_m: Box::new([Vec3::ZERO; 21]),
            score: Some(0.75),
        };
        assert_eq!(hand.score(), Some(0.75));
        assert_eq!(
            PoseOrigin::ALL.map(PoseOrigin::name),
            ["network", "propagated", "held", "nobody"]
        );
        assert_eq!(JointFrame::ALL.map(JointFrame::name), ["camera", "world"]);
    }
}

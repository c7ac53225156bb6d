//! Poses of a hand, a person or another thing over time.

use evpose_core::Micros;
use evpose_pose::body::{BODY_JOINTS, BodyPoints, JOINT_NAMES};
use evpose_pose::{
    EVALUATION_JOINTS, HandParams, JointFrame, PoseEstimate, PoseLayout, PoseOrigin,
};
use glam::{Vec2, Vec3};

/// Kind of the poses of a sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PoseKind {
    /// Of a person: 13 joints.
    Body,
    /// Of a hand: 21 joints and 12 parameters.
    Hand,
    /// Of another task: values.
    Values(&'static PoseLayout),
}

impl PoseKind {
    /// Names of the joints, in the order of [`TimedPose::joints`].
    pub fn joint_names(self) -> &'static [&'static str] {
        match self {
            Self::Body => &JOINT_NAMES,
            Self::Hand => &EVALUATION_JOINTS,
            Self::Values(_) => &[],
        }
    }

    /// Names of the values, in the order of [`TimedPose::values`].
    pub(super) fn value_names(self) -> &'static [&'static str] {
        match self {
            Self::Values(layout) => layout.values,
            Self::Body | Self::Hand => &[],
        }
    }

    /// The subject in messages.
    pub(super) fn subject(self) -> &'static str {
        match self {
            Self::Body => "people",
            Self::Hand => "hands",
            Self::Values(layout) => layout.name,
        }
    }
}

/// A joint of a pose.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PoseJoint {
    /// Position on the sensor in pixels; none if it was not detected, not labelled or is behind the
    /// camera.
    pub image_px: Option<Vec2>,
    /// Score, 0 to 1, where there is one.
    pub score: Option<f32>,
    /// Position in metres, in the frame of the sequence.
    pub position_m: Option<Vec3>,
}

/// A pose at a time stamp.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedPose {
    /// Time stamp.
    pub t: Micros,
    /// Whether a network inferred it or a filter propagated it, where that is known.
    pub origin: Option<PoseOrigin>,
    /// Latency in milliseconds, where it is known.
    pub latency_ms: Option<f64>,
    /// Score, 0 to 1, where there is one.
    pub score: Option<f32>,
    /// Parameters of a hand.
    pub params: Option<HandParams>,
    /// Joints, as many and in the order of [`PoseKind::joint_names`].
    pub joints: Vec<PoseJoint>,
    /// Values of another task, in the order of its layout; none if one of them is missing.
    pub values: Option<Vec<f32>>,
}

impl TimedPose {
    /// A pose without any value.
    pub fn empty(kind: PoseKind, t: Micros) -> Self {
        Self {
            t,
            origin: None,
            latency_ms: None,
            score: None,
            params: None,
            joints: vec![PoseJoint::default(); kind.joint_names().len()],
            values: None,
        }
    }

    /// A pose of a task; joints of hands are in the camera's frame.
    pub fn new(t: Micros, estimate: &PoseEstimate) -> Self {
        let mut values = None;
        let (params, joints) = match estimate {
            PoseEstimate::Values { values: known, .. } => {
                values = Some(known.clone());
                (None, Vec::new())
            }
            PoseEstimate::Body { joints_px, scores, .. } => {
                let joint = |(image_px, score): (&Option<Vec2>, &f32)| PoseJoint {
                    image_px: *image_px,
                    score: Some(*score),
                    position_m: None,
                };
                (None, joints_px.iter().zip(scores).map(joint).collect())
            }
            PoseEstimate::Hand { params, points, camera_m, .. } => {
                let joint = |(image_px, camera_m): (&Option<Vec2>, &Vec3)| PoseJoint {
                    image_px: *image_px,
                    score: None,
                    position_m: Some(*camera_m),
                };
                (Some(*params), points.image_px.iter().zip(&**camera_m).map(joint).collect())
            }
        };
        Self { t, origin: None, latency_ms: None, score: estimate.score(), params, joints, values }
    }

    /// The same with its origin, which is [`PoseOrigin::Nobody`] if it has no value.
    #[must_use]
    pub fn with_origin(self, origin: PoseOrigin) -> Self {
        let origin = if self.is_nobody() { PoseOrigin::Nobody } else { origin };
        Self { origin: Some(origin), ..self }
    }

    /// The row of a time at which nobody is in view.
    pub fn nobody(kind: PoseKind, t: Micros) -> Self {
        Self::empty(kind, t).with_origin(PoseOrigin::Nobody)
    }

    /// Whether it has neither parameters, nor values, nor a joint with a position.
    pub fn is_nobody(&self) -> bool {
        let has_position =
            |joint: &PoseJoint| joint.image_px.is_some() || joint.position_m.is_some();
        self.params.is_none() && self.values.is_none() && !self.joints.iter().any(has_position)
    }

    /// The joints of a person; none of them for a hand.
    pub fn body_px(&self) -> BodyPoints {
        let mut points = [None; BODY_JOINTS];
        if self.joints.len() == BODY_JOINTS {
            for (point, joint) in points.iter_mut().zip(&self.joints) {
                *point = joint.image_px;
            }
        }
        points
    }

    /// The joints of a hand in pixels; none if one of them has no position.
    pub fn hand_px(&self) -> Option<[Vec2; 21]> {
        let points: Option<Vec<Vec2>> = self.joints.iter().map(|joint| joint.image_px).collect();
        points?.try_into().ok()
    }
}

/// Poses of one hand, person or other thing over time.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseSequence {
    /// Kind of the poses.
    pub kind: PoseKind,
    /// Frame of positions in metres, where the file states it.
    pub frame: Option<JointFrame>,
    /// Poses, in the order of the file.
    pub poses: Vec<TimedPose>,
}

impl PoseSequence {
    /// An empty sequence; joints of hands are in the camera's frame.
    pub fn new(kind: PoseKind) -> Self {
        let frame = match kind {
            PoseKind::Body | PoseKind::Values(_) => None,
            PoseKind::Hand => Some(JointFrame::Camera),
        };
        Self { kind, frame, poses: Vec::new() }
    }
}

//! Persons on photographs, as the readers of all sets hand them over.

use evpose_pose::body::{BODY_JOINTS, BodyPoints, Visibility};
use glam::DVec2;

use super::SkipReason;

/// Persons of fewer joints are not cut out.
const MIN_JOINTS: usize = 6;
/// Nor those whose points are less wide and high together, in pixels: their windows are less than
/// half of what networks take, and edges as thick as limbs.
const MIN_EXTENT_PX: f64 = 64.0;

/// An annotated photograph.
#[derive(Debug)]
pub(crate) struct Photograph {
    /// Index of the photograph in the release, from 0.
    pub(crate) index: usize,
    pub(crate) name: String,
    /// The persons on it, or what is wrong with one of them.
    pub(crate) persons: Vec<Result<Person, PersonFault>>,
}

/// A person that cannot be read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PersonFault {
    pub(crate) reason: SkipReason,
    pub(crate) detail: Option<String>,
}

/// A joint of a person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Joint {
    /// Its place, in pixels of the photograph.
    pub(crate) at: DVec2,
    /// Whether it can be seen; none where that must be said and is not.
    pub(crate) visibility: Option<Visibility>,
}

/// A person, in pixels of the photograph.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Person {
    /// All annotated points, of which joints are made: the window is around them.
    pub(crate) points: Vec<DVec2>,
    /// The joints, in the order of networks.
    pub(crate) joints: [Option<Joint>; BODY_JOINTS],
    /// Two corners of the head's box.
    pub(crate) head_box: Option<[DVec2; 2]>,
    /// Rough position of the person.
    pub(crate) center: Option<DVec2>,
    /// Why it is not to be cut out; it is somebody else on the images of others all the same.
    pub(crate) fault: Option<SkipReason>,
}

impl Person {
    /// A person of joints alone: its middle is their mean.
    pub(crate) fn of_joints(points: Vec<DVec2>, joints: [Option<Joint>; BODY_JOINTS]) -> Self {
        let known: Vec<DVec2> = joints.iter().flatten().map(|joint| joint.at).collect();
        let center = (!known.is_empty()).then(|| known.iter().sum::<DVec2>() / known.len() as f64);
        let low = points.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let fault = if known.len() < MIN_JOINTS {
            Some(SkipReason::FewJoints)
        } else {
            ((high - low).element_sum() < MIN_EXTENT_PX).then_some(SkipReason::Small)
        };
        Self { points, joints, head_box: None, center, fault }
    }

    /// Positions of its joints.
    pub(crate) fn joints_px(&self) -> BodyPoints {
        self.joints.map(|joint| joint.map(|joint| joint.at.as_vec2()))
    }
}

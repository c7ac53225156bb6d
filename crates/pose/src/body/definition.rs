//! Definitions of joints by data sets that put them elsewhere than this project.
//!
//! # Model
//! Joints are the centres about which limbs turn, and the head is its middle. DHP19 labels markers on
//! the skin: that of the head is on top of it, those of the hips are on the crest of the pelvis, a
//! tenth of a metre above the joints. Either way is a fixed share of the way between two joints.
//!
//! # Source
//! Calabrese et al.: *DHP19*, CVPRW 2019; Goyal et al.: *MoveEnet*, CVPRW 2023, on the head. The shares are
//! of proportions: heights between the top of the head, 0, and the ankles, 1, in medians over
//! the labels of one subject of DHP19 (shoulders 0.196, hips 0.472) and over standing people of
//! the simulator (middle of the head 0.056, shoulders 0.196, hips 0.535). No prediction was
//! looked at.

use super::BodyPoints;
use super::number::{HEAD, HIP_L, HIP_R, SHOULDER_L, SHOULDER_R};

/// From the shoulders' middle to the middle of the head, and as much further to its top.
const HEAD_TOP: f32 = 0.056 / (0.196 - 0.056);
/// Of the way from a hip to the shoulder of its side.
const HIP_CREST: f32 = (0.535 - 0.472) / (0.535 - 0.196);

/// A set whose labels put some joints elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointDefinition {
    /// Markers of DHP19.
    Dhp19,
}

impl JointDefinition {
    /// Joints of this project, in any unit, where this definition puts them. A joint moves only
    /// where those are known that it moves along.
    #[must_use]
    pub fn place(self, joints: &BodyPoints) -> BodyPoints {
        let Self::Dhp19 = self;
        let shoulders = joints[SHOULDER_L].zip(joints[SHOULDER_R]);
        let middle = shoulders.map(|(left, right)| left.midpoint(right));
        let moves = [
            (HEAD, middle, -HEAD_TOP),
            (HIP_L, joints[SHOULDER_L], HIP_CREST),
            (HIP_R, joints[SHOULDER_R], HIP_CREST),
        ];
        // Every move starts from the given joints, so that their order does not matter.
        let mut placed = *joints;
        for (joint, towards, share) in moves {
            if let Some((at, towards)) = joints[joint].zip(towards) {
                placed[joint] = Some(at + share * (towards - at));
            }
        }
        placed
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::body::BODY_JOINTS;

    #[test]
    fn markers_of_dhp19_are_on_top_of_the_head_and_above_the_hips() {
        let mut joints: BodyPoints = [None; BODY_JOINTS];
        for (joint, x, y) in [
            (HEAD, 0.0, 0.056),
            (SHOULDER_L, 0.1, 0.196),
            (SHOULDER_R, -0.1, 0.196),
            (HIP_L, 0.1, 0.535),
        ] {
            joints[joint] = Some(Vec2::new(x, y));
        }
        let markers = JointDefinition::Dhp19.place(&joints);
        let near = |joint: usize, x: f32, y: f32| {
            let at = markers[joint].map_or(f32::INFINITY, |at| at.distance(Vec2::new(x, y)));
            assert!(at < 1e-6, "{joint}: {markers:?}");
        };
        near(HEAD, 0.0, 0.0);
        near(SHOULDER_L, 0.1, 0.196);
        near(HIP_L, 0.1, 0.472);
        assert_eq!(markers[HIP_R], None);
        joints[SHOULDER_L] = None;
        let markers = JointDefinition::Dhp19.place(&joints);
        assert_eq!((markers[HEAD], markers[HIP_L]), (joints[HEAD], joints[HIP_L]));
    }
}

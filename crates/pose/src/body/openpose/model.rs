//! The two networks for bodies that OpenPose distributes: parts, limbs and channels of their maps.

use crate::body::coco::COCO_KEYPOINTS;

/// Parts that a network of OpenPose detects.
///
/// # Source
/// `poseParameters.cpp` of OpenPose 1.7.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OpenPoseModel {
    /// 18 parts: COCO's, and a neck. Lightweight OpenPose has the same.
    Coco18,
    /// 25 parts: those, the middle of the hips, and six of the feet.
    Body25,
}

/// A pair of parts, and the part-affinity field between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Limb {
    /// Indices of the two parts; the field points from the first to the second.
    pub(super) parts: [usize; 2],
    /// Channel of the field's x; that of its y follows.
    pub(super) channel: usize,
}

const fn limb(a: usize, b: usize, channel: usize) -> Limb {
    Limb { parts: [a, b], channel }
}

const COCO_18_LIMBS: [Limb; 19] = [
    limb(1, 2, 12),
    limb(1, 5, 20),
    limb(2, 3, 14),
    limb(3, 4, 16),
    limb(5, 6, 22),
    limb(6, 7, 24),
    limb(1, 8, 0),
    limb(8, 9, 2),
    limb(9, 10, 4),
    limb(1, 11, 6),
    limb(11, 12, 8),
    limb(12, 13, 10),
    limb(1, 0, 28),
    limb(0, 14, 30),
    limb(14, 16, 34),
    limb(0, 15, 32),
    limb(15, 17, 36),
    limb(2, 16, 18),
    limb(5, 17, 26),
];

const BODY_25_LIMBS: [Limb; 26] = [
    limb(1, 8, 0),
    limb(1, 2, 14),
    limb(1, 5, 22),
    limb(2, 3, 16),
    limb(3, 4, 18),
    limb(5, 6, 24),
    limb(6, 7, 26),
    limb(8, 9, 6),
    limb(9, 10, 2),
    limb(10, 11, 4),
    limb(8, 12, 8),
    limb(12, 13, 10),
    limb(13, 14, 12),
    limb(1, 0, 30),
    limb(0, 15, 32),
    limb(15, 17, 36),
    limb(0, 16, 34),
    limb(16, 18, 38),
    limb(2, 17, 20),
    limb(5, 18, 28),
    limb(14, 19, 40),
    limb(19, 20, 42),
    limb(14, 21, 44),
    limb(11, 22, 46),
    limb(22, 23, 48),
    limb(11, 24, 50),
];

impl OpenPoseModel {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Coco18, Self::Body25];

    /// Its name in OpenPose.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coco18 => "COCO",
            Self::Body25 => "BODY_25",
        }
    }

    /// Number of parts.
    pub fn parts(self) -> usize {
        match self {
            Self::Coco18 => 18,
            Self::Body25 => 25,
        }
    }

    /// Channels of the heatmaps: one for each part, and one for the background, the last.
    pub fn heatmap_channels(self) -> usize {
        self.parts() + 1
    }

    /// Channels of the part-affinity fields: x and y of each limb.
    pub fn field_channels(self) -> usize {
        2 * self.limbs().len()
    }

    pub(super) fn limbs(self) -> &'static [Limb] {
        match self {
            Self::Coco18 => &COCO_18_LIMBS,
            Self::Body25 => &BODY_25_LIMBS,
        }
    }

    /// The part that each keypoint of COCO is.
    pub(super) fn coco_parts(self) -> [usize; COCO_KEYPOINTS] {
        match self {
            Self::Coco18 => [0, 15, 14, 17, 16, 5, 2, 6, 3, 7, 4, 11, 8, 12, 9, 13, 10],
            Self::Body25 => [0, 16, 15, 18, 17, 5, 2, 6, 3, 7, 4, 12, 9, 13, 10, 14, 11],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_channel_is_of_one_limb_and_every_part_is_reached() {
        for model in OpenPoseModel::ALL {
            let mut channels: Vec<usize> = model.limbs().iter().map(|limb| limb.channel).collect();
            channels.sort_unstable();
            let even: Vec<usize> = (0..model.limbs().len()).map(|k| 2 * k).collect();
            assert_eq!(channels, even, "{}", model.name());
            for part in 0..model.parts() {
                assert!(model.limbs().iter().any(|limb| limb.parts.contains(&part)), "{part}");
            }
        }
        assert_eq!(OpenPoseModel::ALL.map(OpenPoseModel::field_channels), [38, 52]);
    }
}

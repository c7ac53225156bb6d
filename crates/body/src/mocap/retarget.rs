//! From the bones of a recorded skeleton to SMPL+H's joints.
//!
//! # Model
//! A limb points where the recorded one does: a joint turns by the recorded bone's rotation from its
//! rest, after the rotation from this skeleton's rest pose to the recorded one's. Trunk and head are
//! upright in both. Lengths are relative to the legs', so that they fit a person of any size.

use std::path::Path;

use glam::{Mat3, Quat, Vec3};

use crate::activity::SOLE;
use crate::folder_error::FolderError;
use crate::procedural::rest_joints;
use crate::skeleton::{BODY_JOINTS, LEFT_HAND, RIGHT_HAND, parents};

use super::acclaim::{Skeleton, SkeletonPose};

/// Frames per second of a recorded motion, and of the ones that are used.
const RECORDED_HZ: f32 = 120.0;
const EVERY: usize = 2;

/// The recorded bone of every joint. Forearms turn about themselves with the wrist.
const BONES: &str = "root lfemur rfemur lowerback ltibia rtibia upperback lfoot rfoot thorax ltoes \
    rtoes upperneck lclavicle rclavicle head lhumerus rhumerus lwrist rwrist lhand rhand";

/// A recorded motion of SMPL+H's joints.
#[derive(Debug, Clone)]
pub(super) struct Clip {
    frames: Vec<ClipFrame>,
}

/// One pose. Lengths are in leg lengths.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClipFrame {
    /// Rotation of each joint relative to its parent.
    pub(super) rotations: [Quat; BODY_JOINTS],
    /// Position of the pelvis along x and z; along y, that of the lower sole.
    pub(super) place: Vec3,
}

/// Length of the left leg, hip to ankle.
pub(super) fn leg_length(joints_m: &[Vec3]) -> f32 {
    joints_m[1].distance(joints_m[4]) + joints_m[4].distance(joints_m[7])
}

/// How a recorded skeleton is mapped.
struct Mapping {
    /// Its bone for each joint.
    bones: [usize; BODY_JOINTS],
    /// Rotation of each joint from this rest pose to the recorded one.
    alignments: [Mat3; BODY_JOINTS],
    leg: f32,
}

impl Mapping {
    fn new(skeleton: &Skeleton) -> Option<Self> {
        let mut bones = [0; BODY_JOINTS];
        for (bone, name) in bones.iter_mut().zip(BONES.split_whitespace()) {
            *bone = skeleton.bone(name)?;
        }
        let rest_m = rest_joints();
        let along = |joint: usize, end: usize| (rest_m[end] - rest_m[joint]).normalize();
        let mut alignments = [Mat3::IDENTITY; BODY_JOINTS];
        let recorded = |joint: usize| &skeleton.bones[bones[joint]];
        let ends = [(1, 4), (4, 7), (18, 20), (2, 5), (5, 8), (19, 21)];
        for (joint, end) in ends.into_iter().chain([(20, LEFT_HAND + 3), (21, RIGHT_HAND + 3)]) {
            let arc = Quat::from_rotation_arc(along(joint, end), recorded(joint).direction);
            alignments[joint] = Mat3::from_quat(arc);
        }
        // Feet stay as they are beside the shanks.
        for (foot, shank) in [(7, 4), (8, 5), (10, 4), (11, 5)] {
            alignments[foot] = alignments[shank];
        }
        // Upper arms also turn about themselves: an elbow bends forwards here, and there about the
        // first axis of the bone below.
        for (joint, forearm, hinge) in
            [(16, skeleton.bone("lradius")?, Vec3::NEG_Y), (17, skeleton.bone("rradius")?, Vec3::Y)]
        {
            let from = frame(along(joint, joint + 2), hinge);
            let to = frame(recorded(joint).direction, skeleton.bones[forearm].axes.x_axis);
            alignments[joint] = to * from.transpose();
        }
        let leg = recorded(1).length + recorded(4).length;
        (leg > 0.0).then_some(Self { bones, alignments, leg })
    }

    /// The joints of a recorded pose.
    fn map(&self, pose: &SkeletonPose) -> ClipFrame {
        let world: [Mat3; BODY_JOINTS] =
            std::array::from_fn(|joint| pose.rotations[self.bones[joint]] * self.alignments[joint]);
        let parents = parents();
        let rotations = std::array::from_fn(|joint| {
            let parent = parents[joint].map_or(Mat3::IDENTITY, |parent| world[parent]);
            Quat::from_mat3(&(parent.transpose() * world[joint]))
        });
        let leg_m = leg_length(&rest_joints());
        let soles = SOLE.iter().map(|&(joint, below_m)| {
            // A joint is at the end of the bone above its own.
            let origin = pose.ends[self.bones[joint - 3]] / self.leg;
            (origin + world[joint] * below_m / leg_m).y
        });
        let root = pose.ends[0] / self.leg;
        ClipFrame { rotations, place: root.with_y(soles.fold(f32::INFINITY, f32::min)) }
    }
}

/// Axes of a limb along `direction` that bends about `hinge`.
fn frame(direction: Vec3, hinge: Vec3) -> Mat3 {
    let aside = direction.cross(hinge).normalize();
    Mat3::from_cols(direction, aside, direction.cross(aside))
}

impl Clip {
    /// Parses a motion (AMC) of a skeleton.
    pub(super) fn parse(skeleton: &Skeleton, path: &Path, text: &str) -> Result<Self, FolderError> {
        let other = || FolderError::content(path, "its skeleton has not the bones of CMU's");
        let mapping = Mapping::new(skeleton).ok_or_else(other)?;
        let mut frames = Vec::new();
        skeleton.frames(path, text, EVERY, |pose| frames.push(mapping.map(pose)))?;
        if frames.is_empty() {
            return Err(FolderError::content(path, "no frames"));
        }
        Ok(Self { frames })
    }

    /// Length in seconds.
    pub(super) fn seconds(&self) -> f32 {
        (self.frames.len() - 1) as f32 * EVERY as f32 / RECORDED_HZ
    }

    /// The frame before a time, and how far the time is from it to the next.
    fn place(&self, t_s: f32) -> (usize, f32) {
        let last = (self.frames.len() - 1) as f32;
        let at = (t_s * RECORDED_HZ / EVERY as f32).max(0.0);
        // To and fro.
        let at = (last - (at.rem_euclid(2.0 * last.max(1.0)) - last).abs()).max(0.0);
        let before = (at.floor() as usize).min(self.frames.len() - 1);
        (before, at - before as f32)
    }

    /// The pose at a time, interpolated.
    pub(super) fn at(&self, t_s: f32) -> ClipFrame {
        let (before, share) = self.place(t_s);
        let a = &self.frames[before];
        let b = &self.frames[(before + 1).min(self.frames.len() - 1)];
        ClipFrame {
            rotations: std::array::from_fn(|k| a.rotations[k].slerp(b.rotations[k], share)),
            place: a.place.lerp(b.place, share),
        }
    }

    /// Opposite corners of the box around the places between two times.
    pub(super) fn bounds(&self, from_s: f32, to_s: f32) -> (Vec3, Vec3) {
        let steps = ((to_s - from_s).max(0.0) * 30.0) as usize;
        let places = (0..=steps).map(|k| self.at(from_s + k as f32 / 30.0).place);
        places.fold((Vec3::MAX, Vec3::MIN), |(low, high), place| (low.min(place), high.max(place)))
    }
}

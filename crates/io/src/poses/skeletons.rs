//! Skeletons of YARP: a folder with `info.log` and `data.log`, see [`yarp`](crate::yarp). With
//! confidences, which are the scores of joints.

use std::path::Path;

use evpose_pose::JointFrame;
use evpose_pose::body::{file_from_network, network_from_file, torso};

use super::format::{PoseFormat, PoseIterator};
use super::{PoseJoint, PoseKind, PoseSequence, TimedPose};
use crate::yarp::{CoordinateFormat, YarpSkeleton, read_skeletons_from, write_skeletons};
use crate::{Input, IoError};

/// Channel of the skeletons that are written.
const CHANNEL: &str = "skeleton";

/// The format.
pub(super) static FORMAT: PoseFormat = PoseFormat {
    name: "yarp",
    summary: "a folder of YARP with the skeletons of a person, whole pixels, with confidences",
    endings: &[],
    detect: |start| start.split(|byte| *byte == b'\n').next().is_some_and(is_skeleton),
    read,
    write: Some(write),
};

fn is_skeleton(line: &[u8]) -> bool {
    line.windows(6).any(|word| word == b" SKLT ")
}

fn read(path: &Path, bytes: &[u8]) -> Result<PoseSequence, IoError> {
    let mut sequence = PoseSequence::new(PoseKind::Body);
    for skeleton in read_skeletons_from(Input::memory(path, bytes.to_vec()))? {
        let scores = skeleton.confidences.map(|scores| network_from_file(&scores));
        let joints = skeleton.points_px().into_iter().enumerate().map(|(k, image_px)| PoseJoint {
            image_px,
            score: scores.map(|scores| scores[k]),
            position_m: None,
        });
        let joints = joints.collect();
        let pose = TimedPose { joints, ..TimedPose::empty(PoseKind::Body, skeleton.t) };
        sequence.poses.push(pose);
    }
    Ok(sequence)
}

fn write(
    path: &Path,
    kind: PoseKind,
    _: Option<JointFrame>,
    poses: PoseIterator<'_>,
) -> Result<(), IoError> {
    if kind != PoseKind::Body {
        return Err(IoError::unwritable(
            path,
            format!("YARP has no skeletons of {}", kind.subject()),
        ));
    }
    let skeletons: Vec<YarpSkeleton> = poses.map(|pose| skeleton(&pose)).collect();
    write_skeletons(path, CHANNEL, &skeletons, CoordinateFormat::Whole)
}

fn skeleton(pose: &TimedPose) -> YarpSkeleton {
    let joints_px = pose.body_px();
    let mut scores = [0.0; crate::yarp::JOINTS];
    for (score, joint) in scores.iter_mut().zip(&pose.joints) {
        *score = joint.score.unwrap_or(0.0);
    }
    let has_scores = pose.joints.iter().any(|joint| joint.score.is_some());
    YarpSkeleton {
        t: pose.t,
        joints: file_from_network(&joints_px)
            // hpe-core's own sign of a joint that is not there.
            .map(|joint| joint.map_or([-1.0; 2], |at| at.to_array())),
        confidences: has_scores.then(|| file_from_network(&scores)),
        head_size_px: None,
        torso_size_px: torso(&joints_px),
    }
}

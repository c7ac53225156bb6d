//! Joints that do not move at all.

use std::ops::Range;

use evpose_pose::body::{BODY_JOINTS, JOINT_NAMES};

use super::{CheckOptions, LabelFault, LabelTrack, TrackFrame};
use crate::runs::runs;

/// Hands `report` the first frame, the joint and for how long it is frozen.
pub(super) fn check(
    track: &LabelTrack,
    torsos: &[Option<f32>],
    options: &CheckOptions,
    report: &mut impl FnMut(usize, Vec<&'static str>, LabelFault),
) {
    // A frame by itself is a run of one, and cannot be frozen.
    let is_long = |run: &Range<usize>| run.len() >= options.frozen_frames.max(2);
    for run in runs(&track.frames, |a, b| a.joints == b.joints).into_iter().filter(is_long) {
        // Someone without labels does not move either.
        if track.frames[run.start].joints.iter().any(Option::is_some) {
            report(run.start, Vec::new(), LabelFault::FrozenBody { frames: run.len() });
        }
    }
    for (joint, name) in JOINT_NAMES.into_iter().enumerate() {
        let is_still = |a: &TrackFrame, b: &TrackFrame| {
            let at = a.joint(joint);
            at.is_some() && at == b.joint(joint)
        };
        for run in runs(&track.frames, is_still).into_iter().filter(is_long) {
            let Some(torso) = torsos[run.start] else { continue };
            // Joints of somebody who stands still are no fault: others have to move meanwhile.
            if motion(&track.frames[run.clone()]) > options.frozen_motion * torso {
                report(run.start, vec![name], LabelFault::FrozenJoint { frames: run.len() });
            }
        }
    }
}

/// How far the joint that goes furthest gets from where it was in the first frame.
fn motion(frames: &[TrackFrame]) -> f32 {
    let distances = (0..BODY_JOINTS).flat_map(|joint| {
        let from = frames[0].joint(joint);
        frames.iter().filter_map(move |frame| Some(frame.joint(joint)?.distance(from?)))
    });
    distances.fold(0.0, f32::max)
}

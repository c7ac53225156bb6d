//! Joints that do not move at all.

use evpose_pose::body::{BODY_JOINTS, JOINT_NAMES};

use super::{CheckOptions, LabelFault, LabelTrack};

/// Hands `report` the first frame, the joint and for how long it is frozen.
pub(super) fn check(
    track: &LabelTrack,
    torsos: &[Option<f32>],
    options: &CheckOptions,
    report: &mut impl FnMut(usize, Vec<&'static str>, LabelFault),
) {
    let frames = &track.frames;
    for (start, length) in runs(frames.len(), |a, b| frames[a].joints == frames[b].joints) {
        // Someone without labels does not move either.
        let is_known = frames[start].joints.iter().any(Option::is_some);
        if length >= options.frozen_frames.max(2) && is_known {
            report(start, Vec::new(), LabelFault::FrozenBody { frames: length });
        }
    }
    for (joint, name) in JOINT_NAMES.into_iter().enumerate() {
        let at = |frame: usize| track.joint(frame, joint);
        for (start, length) in runs(frames.len(), |a, b| at(a).is_some() && at(a) == at(b)) {
            if length < options.frozen_frames.max(2) {
                continue;
            }
            let Some(torso) = torsos[start] else { continue };
            // Joints of somebody who stands still are no fault: others have to move meanwhile.
            if motion(track, start, length) > options.frozen_motion * torso {
                let fault = LabelFault::FrozenJoint { frames: length };
                report(start, vec![name], fault);
            }
        }
    }
}

/// Runs of equal frames: the first frame and the length of each.
fn runs(frames: usize, is_same: impl Fn(usize, usize) -> bool) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    let mut start = 0;
    for frame in 1..=frames {
        if frame == frames || !is_same(frame - 1, frame) {
            runs.push((start, frame - start));
            start = frame;
        }
    }
    runs
}

/// How far the joint that goes furthest gets from where it was at `start`.
fn motion(track: &LabelTrack, start: usize, length: usize) -> f32 {
    let distances = (0..BODY_JOINTS).flat_map(|joint| {
        let from = track.joint(start, joint);
        (start..start + length)
            .filter_map(move |frame| Some(track.joint(frame, joint)?.distance(from?)))
    });
    distances.fold(0.0, f32::max)
}

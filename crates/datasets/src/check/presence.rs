//! Joints that are missing, not on the image or not finite, and times out of order.

use evpose_pose::body::JOINT_NAMES;
use glam::Vec2;

use super::{JointSummary, LabelFault, LabelTrack, TrackFrame};
use crate::runs::runs;

/// Counts every joint, and hands `report` the frame, the joints and what is wrong.
pub(super) fn check(
    track: &LabelTrack,
    joints: &mut [JointSummary],
    report: &mut impl FnMut(usize, Vec<&'static str>, LabelFault),
) {
    for (frame, body) in track.frames.iter().enumerate() {
        for (joint, summary) in joints.iter_mut().enumerate() {
            let Some(point) = body.joints[joint] else {
                summary.missing += 1;
                continue;
            };
            summary.labelled += 1;
            // A position that is not finite lies nowhere: it is not outside as well.
            if !point.is_finite() {
                summary.not_finite += 1;
                report(frame, vec![JOINT_NAMES[joint]], LabelFault::NotFinite);
            } else if track.image_size.is_some_and(|size| is_outside(point, size)) {
                summary.outside += 1;
                let fault = LabelFault::Outside { x: point.x, y: point.y };
                report(frame, vec![JOINT_NAMES[joint]], fault);
            }
        }
    }
    // A photograph need not show all of a person.
    if track.frames.len() > 1 {
        missing(track, report);
        times(track, report);
    }
}

fn is_outside(point: Vec2, size: Vec2) -> bool {
    point.cmplt(Vec2::ZERO).any() || point.cmpgt(size).any()
}

fn missing(track: &LabelTrack, report: &mut impl FnMut(usize, Vec<&'static str>, LabelFault)) {
    for (joint, name) in JOINT_NAMES.into_iter().enumerate() {
        let is_missing = |body: &TrackFrame| body.joints[joint].is_none();
        for run in runs(&track.frames, |a, b| is_missing(a) == is_missing(b)) {
            if is_missing(&track.frames[run.start]) {
                report(run.start, vec![name], LabelFault::Missing { frames: run.len() });
            }
        }
    }
}

fn times(track: &LabelTrack, report: &mut impl FnMut(usize, Vec<&'static str>, LabelFault)) {
    for (index, pair) in track.frames.windows(2).enumerate() {
        if let (Some(before_s), Some(now)) = (pair[0].t_s, pair[1].t_s) {
            // Not a number is not later either.
            if before_s.partial_cmp(&now) != Some(std::cmp::Ordering::Less) {
                report(index + 1, Vec::new(), LabelFault::TimeOrder { before_s });
            }
        }
    }
}

//! Fourteen points into thirteen joints.

use evpose_pose::body::{BODY_JOINTS, Visibility, number};
use glam::DVec2;

use super::table::{LSP_POINTS, LspPoint};
use crate::stills::{Joint, Person};

/// LSP's indices of the joints after the head, in the order of networks.
const LSP_INDEX: [usize; BODY_JOINTS - 1] = [9, 8, 10, 7, 11, 6, 3, 2, 4, 1, 5, 0];
const NECK: usize = 12;
const HEAD_TOP: usize = 13;
/// Part of the way from the middle of the shoulders to the top of the head at which the middle of
/// neck and top is: the median of the extended set's 4,876 persons of whom all are annotated, whose
/// neck is at 0.19 of the way.
const HEAD_FROM_SHOULDERS: f64 = 0.6;

/// The person of some points.
///
/// The head is the middle of neck and top of the head, where MPII's box has its middle; without a
/// neck, six tenths of the way from the middle of the shoulders to the top.
pub(super) fn person(points: &[LspPoint; LSP_POINTS]) -> Person {
    let at = |index: usize| points[index].map(|(at, _)| at);
    let mut joints = [None; BODY_JOINTS];
    for (joint, index) in (1..).zip(LSP_INDEX) {
        joints[joint] = points[index].map(|(at, seen)| Joint { at, visibility: Some(seen) });
    }
    let shoulders = || Some(at(LSP_INDEX[0])?.midpoint(at(LSP_INDEX[1])?));
    let head = |top: DVec2| match at(NECK) {
        Some(neck) => Some(neck.midpoint(top)),
        None => Some(shoulders()?.lerp(top, HEAD_FROM_SHOULDERS)),
    };
    joints[number::HEAD] =
        at(HEAD_TOP).and_then(head).map(|at| Joint { at, visibility: Some(Visibility::Visible) });
    Person::of_joints(points.iter().flatten().map(|(at, _)| *at).collect(), joints)
}

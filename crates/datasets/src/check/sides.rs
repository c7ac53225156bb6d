//! Left and right exchanged.
//!
//! # Model
//! Of each pair of joints, the way that both go from one frame to the next is compared with the way
//! they would go had they been exchanged. Two joints that cross go on as they went: where they
//! would be at the velocity they had is as good as where they were.

use std::collections::BTreeMap;
use std::ops::Range;

use evpose_pose::body::{BODY_JOINTS, JOINT_NAMES, MIRRORED};
use glam::Vec2;

use super::{CheckOptions, LabelFault, LabelTrack};

/// Hands `report` the first frame, the joints and for how long they seem to be exchanged.
pub(super) fn check(
    track: &LabelTrack,
    torsos: &[Option<f32>],
    options: &CheckOptions,
    report: &mut impl FnMut(usize, Vec<&'static str>, LabelFault),
) {
    for segment in track.segments(options) {
        // Pairs that are exchanged together are one finding.
        let mut spans: BTreeMap<(usize, usize), Vec<&'static str>> = BTreeMap::new();
        for left in 0..BODY_JOINTS {
            let right = MIRRORED[left];
            if left < right {
                for span in exchanged(track, [left, right], segment.clone(), torsos, options) {
                    let joints = spans.entry((span.start, span.end)).or_default();
                    joints.extend([JOINT_NAMES[left], JOINT_NAMES[right]]);
                }
            }
        }
        for ((start, end), joints) in spans {
            report(start, joints, LabelFault::SwappedSides { frames: end - start });
        }
    }
}

/// Frames in which a pair seems to be exchanged: from one exchange to the next, or to the end.
fn exchanged(
    track: &LabelTrack,
    pair: [usize; 2],
    segment: Range<usize>,
    torsos: &[Option<f32>],
    options: &CheckOptions,
) -> Vec<Range<usize>> {
    let at = |frame: usize| {
        let [left, right] = pair.map(|joint| track.joint(frame, joint));
        Some([left?, right?])
    };
    let exchanges: Vec<usize> = segment
        .clone()
        .skip(1)
        .filter(|&frame| {
            let (Some(now), Some(before), Some(torso)) = (at(frame), at(frame - 1), torsos[frame])
            else {
                return false;
            };
            let earlier = (frame >= segment.start + 2).then(|| at(frame - 2)).flatten();
            let expected =
                earlier.map(|earlier| [0, 1].map(|side| 2.0 * before[side] - earlier[side]));
            let kept = way(now, before).min(expected.map_or(f32::INFINITY, |then| way(now, then)));
            let swapped = way([now[1], now[0]], before);
            swapped < options.swap_ratio * kept && kept - swapped > options.swap_gain * torso
        })
        .collect();
    let span = |pair: &[usize]| pair[0]..pair.get(1).copied().unwrap_or(segment.end);
    exchanges.chunks(2).map(span).collect()
}

/// How far two joints go.
fn way(now: [Vec2; 2], before: [Vec2; 2]) -> f32 {
    now[0].distance(before[0]) + now[1].distance(before[1])
}

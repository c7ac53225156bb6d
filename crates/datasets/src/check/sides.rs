//! Left and right exchanged.
//!
//! # Model
//! On a photograph, nothing is before or behind: there, shoulders and hips that face opposite ways,
//! and limbs that are much shorter from each joint to the next one of the other side, are suspected.
//!
//! Of each pair of joints, the way that both go from one frame to the next is compared with the way
//! they would go had they been exchanged. Two joints that cross go on as they went: where they
//! would be at the velocity they had is as good as where they were.

use std::collections::BTreeMap;
use std::ops::Range;

use evpose_pose::body::number::{
    ANKLE_L, ANKLE_R, ELBOW_L, ELBOW_R, HIP_L, HIP_R, KNEE_L, KNEE_R, SHOULDER_L, SHOULDER_R,
    WRIST_L, WRIST_R,
};
use evpose_pose::body::{BODY_JOINTS, BodyPoints, JOINT_NAMES, MIRRORED};
use glam::Vec2;

use super::{CheckOptions, LabelFault, LabelTrack};

const SHOULDERS: [usize; 2] = [SHOULDER_L, SHOULDER_R];
const HIPS: [usize; 2] = [HIP_L, HIP_R];
const ELBOWS: [usize; 2] = [ELBOW_L, ELBOW_R];
const KNEES: [usize; 2] = [KNEE_L, KNEE_R];
/// Pairs of joints, left and right, from the trunk outwards.
const LIMB_PAIRS: [[[usize; 2]; 2]; 4] =
    [[SHOULDERS, ELBOWS], [ELBOWS, [WRIST_L, WRIST_R]], [HIPS, KNEES], [KNEES, [ANKLE_L, ANKLE_R]]];

/// Hands `report` the first frame, the joints and for how long they seem to be exchanged.
pub(super) fn check(
    track: &LabelTrack,
    torsos: &[Option<f32>],
    options: &CheckOptions,
    report: &mut impl FnMut(usize, Vec<&'static str>, LabelFault),
) {
    // A photograph has no time before it: sides are compared within the body.
    if let ([frame], [Some(torso)]) = (&track.frames[..], torsos) {
        let joints = exchanged_on_photograph(&frame.joints, *torso, options);
        if !joints.is_empty() {
            report(0, joints, LabelFault::SwappedSides { frames: 1 });
        }
    }
    for segment in track.segments(options) {
        // Pairs that are exchanged together are one finding.
        let mut spans: BTreeMap<(usize, usize), Vec<&'static str>> = BTreeMap::new();
        for left in 0..BODY_JOINTS {
            let right = MIRRORED[left];
            // Each pair once.
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
            // Limbs cross in motion: the place at constant velocity is an alternative.
            let earlier = (frame >= segment.start + 2).then(|| at(frame - 2)).flatten();
            let expected =
                earlier.map(|earlier| [0, 1].map(|side| 2.0 * before[side] - earlier[side]));
            let kept = way(now, before).min(expected.map_or(f32::INFINITY, |then| way(now, then)));
            let swapped = way([now[1], now[0]], before);
            // The ratio alone would report the jitter of joints that lie close together.
            swapped < options.swap_ratio * kept && kept - swapped > options.swap_gain * torso
        })
        .collect();
    let span = |pair: &[usize]| pair[0]..pair.get(1).copied().unwrap_or(segment.end);
    // Every second exchange puts the sides back.
    exchanges.chunks(2).map(span).collect()
}

/// Joints of a single body that seem to be exchanged.
fn exchanged_on_photograph(
    joints: &BodyPoints,
    torso: f32,
    options: &CheckOptions,
) -> Vec<&'static str> {
    let at = |[left, right]: [usize; 2]| {
        let both = [joints[left]?, joints[right]?];
        both.iter().all(|point| point.is_finite()).then_some(both)
    };
    let mut found = Vec::new();
    if let (Some(shoulders), Some(hips)) = (at(SHOULDERS), at(HIPS)) {
        // Shoulders and hips face the same way, unless one of the pairs is exchanged.
        let [across_shoulders, across_hips] = [shoulders, hips].map(|[left, right]| left - right);
        let narrower = across_shoulders.length().min(across_hips.length());
        let is_opposed = across_shoulders.normalize_or_zero().dot(across_hips.normalize_or_zero())
            < options.opposed_cosine;
        // Seen from the side both are narrow, and may point either way.
        if is_opposed && narrower > options.min_width * torso {
            found.extend(SHOULDERS.iter().chain(&HIPS).map(|&joint| JOINT_NAMES[joint]));
        }
    }
    for [inner, outer] in LIMB_PAIRS {
        let (Some(before), Some(now)) = (at(inner), at(outer)) else { continue };
        let (kept, swapped) = (way(now, before), way([now[1], now[0]], before));
        // By a ratio and by a distance: short ways have ratios by chance.
        if swapped < options.swap_ratio * kept && kept - swapped > options.swap_gain * torso {
            found.extend(outer.map(|joint| JOINT_NAMES[joint]));
        }
    }
    found
}

/// How far two joints go.
fn way(now: [Vec2; 2], before: [Vec2; 2]) -> f32 {
    now[0].distance(before[0]) + now[1].distance(before[1])
}

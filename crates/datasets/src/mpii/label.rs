//! The label of a person in its window.

use evpose_pose::body::{BODY_JOINTS, BodyLabel, Keypoint, Visibility};
use glam::{DVec2, Vec2};

use super::SkipReason;
use super::person::{PART_OF_JOINT, Person};
use super::window::Window;

/// The size of the head is this part of its box's diagonal.
///
/// # Source
/// MPII's evaluation: 0.8 · 0.75.
const HEAD_SIZE_OF_DIAGONAL: f64 = 0.6;

/// The label of `person` in `window`, with what else is in there of `others`.
pub(super) fn label(
    person: &Person,
    others: &[&Person],
    window: &Window,
    parity: bool,
) -> Result<BodyLabel, SkipReason> {
    let Some([corner, opposite]) = person.head else { return Err(SkipReason::NoHeadBox) };
    let Some(center) = person.center else { return Err(SkipReason::NoCenter) };
    let diagonal = opposite - corner;
    if !diagonal.is_finite() || !center.is_finite() {
        return Err(SkipReason::PointsOutside);
    }
    if parity && others.iter().any(|other| is_incomplete(other)) {
        return Err(SkipReason::IncompleteCompanion);
    }
    let keypoints = (0..BODY_JOINTS)
        .map(|joint| keypoint(person, joint, window, parity))
        .collect::<Result<_, _>>()?;
    let inside = |point: DVec2| {
        let relative = window.relative(point);
        let is_inside = relative.cmpgt(DVec2::ZERO).all() && relative.cmplt(DVec2::ONE).all();
        is_inside.then(|| relative.as_vec2())
    };
    let joints = |joint| others.iter().filter_map(|other| inside(other.joint(joint)?)).collect();
    let size = |diagonal: DVec2| (HEAD_SIZE_OF_DIAGONAL * diagonal.length()) as f32;
    Ok(BodyLabel {
        keypoints,
        center: window.relative(center).as_vec2(),
        head_size: Some(size(diagonal)),
        head_size_scaled: Some(size(diagonal / window.size())),
        torso_size: None,
        other_centers: others.iter().filter_map(|other| inside(other.center?)).collect(),
        other_keypoints: (0..BODY_JOINTS).map(joints).collect(),
    })
}

/// Faults of another person on which the published program fails, and with it on the whole
/// photograph.
fn is_incomplete(other: &Person) -> bool {
    // A single point is no list there.
    other.head.is_none() || other.center.is_none() || other.points.len() < 2
}

fn keypoint(
    person: &Person,
    joint: usize,
    window: &Window,
    parity: bool,
) -> Result<Keypoint, SkipReason> {
    let known = match PART_OF_JOINT[joint] {
        None => person.head_center().map(|at| (at, Visibility::Visible)),
        Some(part) => match person.point(part) {
            Some(point) => {
                let visibility = point.is_visible.visibility(parity);
                Some((point.at, visibility.ok_or(SkipReason::NoVisibility)?))
            }
            None => None,
        },
    };
    let Some((at, visibility)) = known else { return Ok(Keypoint::default()) };
    let position = window.relative(at).as_vec2();
    // A joint that is not on the image is none that can be found there.
    let is_inside = position.cmpge(Vec2::ZERO).all() && position.cmple(Vec2::ONE).all();
    Ok(if is_inside || parity { Keypoint { position, visibility } } else { Keypoint::default() })
}

//! The label of a person in its window.

use evpose_pose::body::{BODY_JOINTS, BodyLabel, Keypoint};
use glam::{DVec2, Vec2};

use super::window::Window;
use super::{Person, SkipReason};

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
    if let Some(fault) = person.fault {
        return Err(fault);
    }
    let Some(center) = person.center else { return Err(SkipReason::NoCenter) };
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
    let joints =
        |joint: usize| others.iter().filter_map(|other| inside(other.joints[joint]?.at)).collect();
    let size = |diagonal: DVec2| (HEAD_SIZE_OF_DIAGONAL * diagonal.length()) as f32;
    let diagonal = person.head_box.map(|[corner, opposite]| opposite - corner);
    Ok(BodyLabel {
        keypoints,
        center: window.relative(center).as_vec2(),
        head_size: diagonal.map(size),
        head_size_scaled: diagonal.map(|diagonal| size(diagonal / window.size())),
        torso_size: None,
        other_centers: others.iter().filter_map(|other| inside(other.center?)).collect(),
        other_keypoints: (0..BODY_JOINTS).map(joints).collect(),
    })
}

/// Faults of another person on which the published program fails, and with it on the whole
/// photograph.
fn is_incomplete(other: &Person) -> bool {
    // A single point is no list there.
    other.head_box.is_none() || other.center.is_none() || other.points.len() < 2
}

fn keypoint(
    person: &Person,
    joint: usize,
    window: &Window,
    parity: bool,
) -> Result<Keypoint, SkipReason> {
    let Some(known) = person.joints[joint] else { return Ok(Keypoint::default()) };
    let visibility = known.visibility.ok_or(SkipReason::NoVisibility)?;
    let position = window.relative(known.at).as_vec2();
    // A joint that is not on the image is none that can be found there.
    let is_inside = position.cmpge(Vec2::ZERO).all() && position.cmple(Vec2::ONE).all();
    Ok(if is_inside || parity { Keypoint { position, visibility } } else { Keypoint::default() })
}

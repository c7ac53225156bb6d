//! One pose of several inferences of a person: crops of other sizes, and mirror images.

use evpose_pose::body::{BodyJoint, MIRRORED};
use glam::{DAffine2, DVec2, Vec2};

/// Sides of the crops that are inferred, relative to that of the second pass.
pub(super) const SCALES: [f64; 3] = [1.0, 1.25, 0.8];
/// Distance, relative to the crop, up to which two inferences found the same joint.
const SAME_JOINT: f32 = 0.1;

/// The pose that inferences agree on: each joint is where those of the highest total score lie together,
/// at their mean by score. All are in the coordinates of one crop; a joint that none found is the first's.
pub(super) fn agreed(inferences: &[Vec<BodyJoint>]) -> Vec<BodyJoint> {
    let Some(first) = inferences.first() else { return Vec::new() };
    (0..first.len()).map(|k| agreed_joint(inferences, k).unwrap_or(first[k])).collect()
}

fn agreed_joint(inferences: &[Vec<BodyJoint>], k: usize) -> Option<BodyJoint> {
    let found = || {
        let of =
            |inferred: &Vec<BodyJoint>| inferred.get(k).and_then(|j| Some((j.position?, j.score)));
        inferences.iter().filter_map(of)
    };
    let near = |at: Vec2| found().filter(move |(other, _)| other.distance(at) <= SAME_JOINT);
    let score_near = |at: Vec2| near(at).map(|(_, score)| score).sum::<f32>();
    // Of equals the first: the order of inferences is fixed.
    let best = found().map(|(at, _)| (at, score_near(at)));
    let (at, total) = best.reduce(|best, other| if other.1 > best.1 { other } else { best })?;
    let mean = near(at).map(|(at, score)| at * score).sum::<Vec2>() / total;
    // Without any score there is no mean by score.
    let position = Some(if total > 0.0 { mean } else { at });
    Some(BodyJoint { position, score: total / near(at).count() as f32 })
}

/// A crop about the middle of another, `scale` times as large, within the image.
pub(super) fn resized(crop: &DAffine2, scale: f64) -> DAffine2 {
    let side = (crop.matrix2.x_axis.x * scale).min(1.0);
    let middle = crop.transform_point2(DVec2::splat(0.5));
    let start = (middle - 0.5 * side).clamp(DVec2::ZERO, DVec2::splat(1.0 - side));
    DAffine2::from_scale_angle_translation(DVec2::splat(side), 0.0, start)
}

/// Joints of a person from those of the mirror image.
pub(super) fn mirrored(joints: &[BodyJoint]) -> Vec<BodyJoint> {
    let back = |at: Vec2| Vec2::new(1.0 - at.x, at.y);
    let of = |k: &usize| joints.get(*k);
    MIRRORED
        .iter()
        .filter_map(of)
        .map(|joint| BodyJoint { position: joint.position.map(back), ..*joint })
        .collect()
}

/// Joints under a map of their positions.
pub(super) fn mapped(joints: &[BodyJoint], map: &DAffine2) -> Vec<BodyJoint> {
    let to = |at: Vec2| map.transform_point2(at.as_dvec2()).as_vec2();
    joints.iter().map(|joint| BodyJoint { position: joint.position.map(to), ..*joint }).collect()
}

#[cfg(test)]
mod tests {
    use evpose_pose::body::BODY_JOINTS;

    use super::*;

    fn joint(x: f32, score: f32) -> BodyJoint {
        BodyJoint { position: Some(Vec2::splat(x)), score }
    }

    #[test]
    fn joints_of_the_mirror_image_come_back() {
        let joints: Vec<BodyJoint> =
            (0..BODY_JOINTS).map(|k| joint(0.05 * k as f32, 0.5)).collect();
        let seen_in_mirror = mirrored(&joints);
        for (k, joint) in seen_in_mirror.iter().enumerate() {
            let from = joints[MIRRORED[k]].position.unwrap_or_default();
            assert_eq!(joint.position, Some(Vec2::new(1.0 - from.x, from.y)));
        }
        for (a, b) in mirrored(&seen_in_mirror).iter().zip(&joints) {
            assert!(a.position.unwrap_or_default().distance(b.position.unwrap_or_default()) < 1e-6);
        }
    }

    #[test]
    fn the_highest_total_score_decides_and_near_joints_are_averaged() {
        let none = BodyJoint { position: None, score: 0.0 };
        // Two that agree outweigh a surer one that lies elsewhere.
        let inferences = [[joint(0.9, 0.7)], [joint(0.50, 0.6)], [joint(0.53, 0.3)], [none]];
        let agreed = agreed(&inferences.map(|inferred| inferred.to_vec()));
        assert!((agreed[0].position.unwrap_or_default().x - 0.51).abs() < 1e-6, "{agreed:?}");
        assert!((agreed[0].score - 0.45).abs() < 1e-6, "{agreed:?}");
        assert_eq!(super::agreed(&[vec![none], vec![none]]), [none]);
    }

    #[test]
    fn a_crop_changes_its_size_about_its_middle_and_stays_within_the_image() {
        let of = |side: f64, x: f64| {
            DAffine2::from_scale_angle_translation(DVec2::splat(side), 0.0, DVec2::splat(x))
        };
        let near = |a: DAffine2, b: DAffine2| assert!(a.abs_diff_eq(b, 1e-12), "{a} for {b}");
        near(resized(&of(0.5, 0.25), 0.8), of(0.4, 0.3));
        near(resized(&of(0.5, 0.0), 1.2), of(0.6, 0.0));
        near(resized(&of(0.9, 0.1), 1.25), of(1.0, 0.0));
    }
}

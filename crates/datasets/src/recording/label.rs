//! Joints in pixels as the label of an image.

use evpose_core::SensorSize;
use evpose_pose::body::number::{HIP_L, HIP_R, SHOULDER_L, SHOULDER_R, WRIST_L, WRIST_R};
use evpose_pose::body::{BodyLabel, BodyPoints, Keypoint, Visibility};
use glam::Vec2;

/// Joints that define the size of a torso.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TorsoRule {
    /// The mean of both diagonals, from each hip to the shoulder of the other side.
    #[default]
    Diagonals,
    /// The mean of the lengths from each wrist to the shoulder of the other side: what the
    /// published exporter takes for the diagonals, since it counts joints in the order of another
    /// skeleton.
    Published,
}

/// The label of an image of `sensor` with these joints.
///
/// Joints that are known are visible: no data set of events says which are hidden. The middle is
/// the mean of those that are known. Lengths are relative to the image, along each axis by itself,
/// as published trainings measure them.
///
/// # Source
/// hpe-core, `datasets/utils/export.py`.
pub fn body_label(points_px: &BodyPoints, sensor: SensorSize, torso: TorsoRule) -> BodyLabel {
    let size = Vec2::new(sensor.width.into(), sensor.height.into());
    let points = points_px.map(|point| point.map(|point| point / size));
    let keypoint = |point: Option<Vec2>| match point {
        Some(position) => Keypoint { position, visibility: Visibility::Visible },
        None => Keypoint::default(),
    };
    let known: Vec<Vec2> = points.into_iter().flatten().collect();
    let length = |a: usize, b: usize| Some(points[a]?.distance(points[b]?));
    let [first, second] = match torso {
        TorsoRule::Diagonals => [length(HIP_L, SHOULDER_R), length(HIP_R, SHOULDER_L)],
        TorsoRule::Published => [length(WRIST_R, SHOULDER_L), length(WRIST_L, SHOULDER_R)],
    };
    BodyLabel {
        keypoints: points.into_iter().map(keypoint).collect(),
        center: known.iter().sum::<Vec2>() / known.len().max(1) as f32,
        torso_size: first.zip(second).map(|(first, second)| 0.5 * (first + second)),
        ..BodyLabel::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 100, height: 200 };

    fn points() -> BodyPoints {
        let mut points = [Some(Vec2::new(50.0, 100.0)); 13];
        points[SHOULDER_L] = Some(Vec2::new(60.0, 80.0));
        points[SHOULDER_R] = Some(Vec2::new(40.0, 80.0));
        points[HIP_L] = Some(Vec2::new(70.0, 160.0));
        points[HIP_R] = Some(Vec2::new(40.0, 80.0));
        points
    }

    #[test]
    fn lengths_are_relative_to_the_image() {
        let label = body_label(&points(), SENSOR, TorsoRule::Diagonals);
        assert_eq!(label.keypoints[HIP_L].position, Vec2::new(0.7, 0.8));
        // (0.3, 0.4) and (0.2, 0).
        assert!((label.torso_size.unwrap() - 0.5 * (0.5 + 0.2)).abs() < 1e-6);
        let label = body_label(&points(), SENSOR, TorsoRule::Published);
        // (0.1, 0.1) on both sides.
        assert!((label.torso_size.unwrap() - 0.02_f32.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn what_is_not_known_is_not_labelled_and_not_counted() {
        let mut points = [None; 13];
        points[3] = Some(Vec2::new(10.0, 20.0));
        points[4] = Some(Vec2::new(30.0, 60.0));
        let label = body_label(&points, SENSOR, TorsoRule::Diagonals);
        assert_eq!(label.keypoints.iter().filter(|joint| joint.is_labelled()).count(), 2);
        assert!(label.center.distance(Vec2::new(0.2, 0.2)) < 1e-6);
        assert_eq!(label.torso_size, None);
        assert_eq!(body_label(&[None; 13], SENSOR, TorsoRule::Diagonals).center, Vec2::ZERO);
    }
}

//! How a network of hands expresses rotations, and its outputs as poses.

use evpose_pose::rotation::{axis_angle_from_matrix, matrix_from_axis_angle};
use evpose_pose::{HandParams, PARAMETERS};
use glam::{Mat3, Vec3};
use serde::{Deserialize, Serialize};

/// Parameters of a hand before its rotation: six of articulation, three of translation.
const BEFORE_ROTATION: usize = 9;

/// How the outputs of a network express the rotation of the wrist.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RotationOutput {
    /// An axis-angle vector, as published: it jumps at a turn of 180 degrees.
    #[default]
    AxisAngle,
    /// The first two columns of the rotation matrix, which are continuous.
    ///
    /// # Source
    /// Zhou et al.: *On the Continuity of Rotation Representations in Neural Networks*, CVPR 2019.
    SixD,
}

impl RotationOutput {
    /// Outputs of a network of hands: 12 or 15.
    pub fn outputs(self) -> usize {
        match self {
            Self::AxisAngle => PARAMETERS,
            Self::SixD => BEFORE_ROTATION + 6,
        }
    }

    /// Appends the outputs of a perfect network for a pose.
    pub fn push_targets(self, pose: &[f32; PARAMETERS], targets: &mut Vec<f32>) {
        if self == Self::AxisAngle {
            targets.extend_from_slice(pose);
            return;
        }
        let (before, rotation) = pose.split_at(BEFORE_ROTATION);
        let matrix = matrix_from_axis_angle(Vec3::from_slice(rotation));
        targets.extend_from_slice(before);
        // The third column is the cross product of the two.
        targets.extend(matrix.x_axis.to_array());
        targets.extend(matrix.y_axis.to_array());
    }

    /// The poses of outputs, one after another.
    pub fn poses(self, outputs: &[f32]) -> Vec<HandParams> {
        outputs.chunks_exact(self.outputs()).map(|output| self.pose(output)).collect()
    }

    fn pose(self, output: &[f32]) -> HandParams {
        let mut pose = [0.0; PARAMETERS];
        pose[..BEFORE_ROTATION].copy_from_slice(&output[..BEFORE_ROTATION]);
        let rotation = match self {
            Self::AxisAngle => Vec3::from_slice(&output[BEFORE_ROTATION..]),
            Self::SixD => axis_angle_of_columns(
                Vec3::from_slice(&output[BEFORE_ROTATION..]),
                Vec3::from_slice(&output[BEFORE_ROTATION + 3..]),
            ),
        };
        pose[BEFORE_ROTATION..].copy_from_slice(&rotation.to_array());
        HandParams::from_array(pose)
    }
}

/// The rotation whose first two columns are nearest to these, by Gram and Schmidt.
fn axis_angle_of_columns(first: Vec3, second: Vec3) -> Vec3 {
    let x = first.normalize_or(Vec3::X);
    let y = (second - x * x.dot(second)).normalize_or(x.any_orthonormal_vector());
    axis_angle_from_matrix(Mat3::from_cols(x, y, x.cross(y)))
}

#[cfg(test)]
mod tests {
    use evpose_pose::rotation::geodesic_rad;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn targets_return_to_their_pose(
            pose in prop::array::uniform12(-1.0f32..1.0), turn in 0.0f32..3.0,
        ) {
            let mut pose = pose;
            let axis = Vec3::from_slice(&pose[9..]).normalize_or(Vec3::X);
            pose[9..].copy_from_slice(&(axis * turn).to_array());
            for output in [RotationOutput::AxisAngle, RotationOutput::SixD] {
                let mut targets = Vec::new();
                output.push_targets(&pose, &mut targets);
                prop_assert_eq!(targets.len(), output.outputs());
                let back = output.poses(&targets);
                prop_assert_eq!(back.len(), 1);
                let want = HandParams::from_array(pose);
                prop_assert_eq!(back[0].translation_m, want.translation_m);
                prop_assert!(geodesic_rad(back[0].rotation, want.rotation) < 2e-3);
            }
        }
    }

    #[test]
    fn targets_are_continuous_where_axis_angles_jump() {
        let targets = |angle: f32| {
            let mut pose = [0.0; PARAMETERS];
            pose[11] = angle;
            let mut targets = Vec::new();
            RotationOutput::SixD.push_targets(&pose, &mut targets);
            targets
        };
        let (before, after) = (targets(3.13), targets(-3.13));
        let largest = before.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(largest < 0.03, "{largest}");
    }

    #[test]
    fn outputs_without_a_direction_have_a_rotation_nevertheless() {
        let poses = RotationOutput::SixD.poses(&[0.0; 15]);
        assert!(poses[0].rotation.is_finite());
    }
}

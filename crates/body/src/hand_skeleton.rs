//! The evaluated points of a hand from its articulation alone, without a surface.
//!
//! Fitting poses asks for these points thousands of times a second. Skinning whole bodies for them takes
//! hundreds of times as long.

use std::ops::Range;

use evpose_pose::EVALUATION_JOINTS;
use evpose_pose::rotation::matrix_from_axis_angle;
use glam::{Affine3A, Vec3};

use crate::fingers::HandRotations;
use crate::skeleton::HAND_JOINTS;
use crate::{BodyModel, HandBasis, ShapedBody};

/// Number of fingertips.
const TIPS: usize = 5;
/// The wrist and the fingertips come before the joints of the fingers.
const FIRST_JOINT: usize = 1 + TIPS;

/// The joints of a hand with the tips of its fingers, in the frame of its wrist.
///
/// # Model
/// Joints are chained as in [`BodyModel::pose`]. A tip is its vertex, skinned as all others are but without
/// the pose correctives that files of the SMPL family have, which move it by a millimetre or two.
#[derive(Debug, Clone)]
pub struct HandSkeleton {
    basis: HandBasis,
    /// The parent of each joint; none for the wrist.
    parents: [Option<usize>; HAND_JOINTS],
    /// Position of each joint at rest, relative to the wrist, in metres.
    rest_m: [Vec3; HAND_JOINTS],
    tips: [Tip; TIPS],
}

/// A fingertip.
#[derive(Debug, Clone)]
struct Tip {
    /// Its position at rest, relative to the wrist, in metres.
    rest_m: Vec3,
    /// The joints that move it, none for the wrist, and by how much.
    moved_by: Vec<(Option<usize>, f32)>,
}

impl HandSkeleton {
    /// That of the hand of `model` in a shape.
    pub fn new(model: &BodyModel, shaped: &ShapedBody) -> Self {
        let (first, wrist_m) = (model.right_hand.first_joint, shaped.joints_m[model.wrist]);
        // Joints of the arm do not move against the wrist, whose frame this is.
        let in_hand = |joint: usize| joint.checked_sub(first).filter(|&k| k < HAND_JOINTS);
        let tip = |vertex: u32| {
            let further = model.further_weights.iter().filter(|further| further.vertex == vertex);
            let further = further.map(|further| (usize::from(further.joint), further.weight));
            let joints = model.skin[vertex as usize].iter().chain(further);
            let rest_m = shaped.vertices_m[vertex as usize] - wrist_m;
            let moved_by = joints.map(|(joint, weight)| (in_hand(joint), weight)).collect();
            Tip { rest_m, moved_by }
        };
        Self {
            basis: model.right_hand.clone(),
            parents: std::array::from_fn(|k| model.parents[first + k].and_then(in_hand)),
            rest_m: std::array::from_fn(|k| shaped.joints_m[first + k] - wrist_m),
            tips: model.fingertips.map(tip),
        }
    }

    /// The points of an articulation in the frame of the wrist, in metres, in the order of
    /// [`EVALUATION_JOINTS`].
    pub fn points(&self, articulation: &[f32; 6]) -> [Vec3; EVALUATION_JOINTS.len()] {
        self.points_of(&std::array::from_fn(|k| self.basis.rotation(k, articulation)))
    }

    /// The points of rotations of the joints, as [`Self::points`].
    pub fn points_of(&self, rotations: &HandRotations) -> [Vec3; EVALUATION_JOINTS.len()] {
        let mut joints = [Affine3A::IDENTITY; HAND_JOINTS];
        self.turn(0..HAND_JOINTS, rotations, &mut joints);
        std::array::from_fn(|point| self.point(point, &joints))
    }

    /// The coefficients of the articulation that come closest to rotations of the joints.
    pub fn coefficients(&self, rotations: &HandRotations) -> [f32; 6] {
        self.basis.coefficients(rotations)
    }

    /// Places some joints, consecutive ones that follow their parents, by rotations of theirs.
    pub(crate) fn turn(
        &self,
        joints: Range<usize>,
        rotations: &[Vec3],
        placed: &mut [Affine3A; HAND_JOINTS],
    ) {
        for (k, rotation) in joints.zip(rotations) {
            let matrix = matrix_from_axis_angle(*rotation);
            placed[k] = match self.parents[k] {
                None => Affine3A::from_mat3_translation(matrix, self.rest_m[k]),
                Some(parent) => {
                    let offset_m = self.rest_m[k] - self.rest_m[parent];
                    placed[parent] * Affine3A::from_mat3_translation(matrix, offset_m)
                }
            };
        }
    }

    /// An evaluated point of a hand whose joints are `placed`.
    pub(crate) fn point(&self, point: usize, placed: &[Affine3A; HAND_JOINTS]) -> Vec3 {
        match point {
            0 => Vec3::ZERO,
            1..FIRST_JOINT => {
                let Tip { rest_m, moved_by } = &self.tips[point - 1];
                let by = |&(joint, weight): &(Option<usize>, f32)| {
                    let moved_m = match joint {
                        None => *rest_m,
                        Some(k) => placed[k].transform_point3(*rest_m - self.rest_m[k]),
                    };
                    moved_m * weight
                };
                moved_by.iter().map(by).sum()
            }
            _ => placed[point - FIRST_JOINT].translation.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::CounterRng;
    use evpose_pose::HandParams;

    use super::*;
    use crate::PosedBody;

    #[test]
    fn points_are_those_of_the_posed_surface() {
        let model = BodyModel::procedural_arm();
        for sample in 0..20 {
            let mut rng = CounterRng::new(4, "hand skeletons", sample);
            let shaped = model.shaped(&[rng.uniform(-2.0, 2.0), rng.uniform(-2.0, 2.0)]);
            let params = HandParams {
                articulation: [(); 6].map(|()| rng.uniform(-2.0, 2.0)),
                translation_m: Vec3::new(0.1, -0.2, 0.3),
                rotation: Vec3::from_array([(); 3].map(|()| rng.uniform(-1.5, 1.5))),
            };
            let mut posed = PosedBody::default();
            model.pose_hand(&shaped, &params, &mut posed);
            let want_m = posed.evaluation_points(&model);
            let turn = matrix_from_axis_angle(params.rotation);
            let points_m = HandSkeleton::new(&model, &shaped).points(&params.articulation);
            for (point, (own_m, want_m)) in points_m.into_iter().zip(want_m).enumerate() {
                let own_m = turn * own_m + params.translation_m;
                assert!(own_m.distance(want_m) < 1e-5, "{sample}, {point}: {own_m} {want_m}");
            }
        }
    }
}

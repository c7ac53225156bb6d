//! A posed body, the 12 pose parameters of its hand and its 21 points.

use evpose_pose::rotation::axis_angle_from_matrix;
use evpose_pose::{EVALUATION_JOINTS, HandParams};
use glam::{Affine3A, Vec3};

use crate::BodyModel;
use crate::skeleton::HAND_JOINTS;

/// A body in a pose, in world coordinates. Reused from pose to pose, it allocates once.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PosedBody {
    /// Vertices in metres.
    pub vertices_m: Vec<Vec3>,
    /// Outward unit normals.
    pub normals: Vec<Vec3>,
    /// `world_from_joint` of every joint.
    pub joints: Vec<Affine3A>,
}

impl PosedBody {
    /// Turns the body about the vertical axis through the origin by an angle in radians, from z to x.
    pub fn turn(&mut self, angle_rad: f32) {
        let turn = Affine3A::from_rotation_y(angle_rad);
        for vertex_m in &mut self.vertices_m {
            *vertex_m = turn.transform_point3(*vertex_m);
        }
        for normal in &mut self.normals {
            *normal = turn.transform_vector3(*normal);
        }
        for joint in &mut self.joints {
            *joint = turn * *joint;
        }
    }

    /// The points that are evaluated, in the order of [`EVALUATION_JOINTS`], in metres.
    pub fn evaluation_points(&self, model: &BodyModel) -> [Vec3; EVALUATION_JOINTS.len()] {
        self.points_with(model, model.fingertips.map(|tip| self.vertices_m[tip as usize]))
    }

    /// The same with these fingertips.
    pub(crate) fn points_with(
        &self,
        model: &BodyModel,
        tips_m: [Vec3; 5],
    ) -> [Vec3; EVALUATION_JOINTS.len()] {
        let tips = 1 + tips_m.len();
        let origin = |joint: usize| Vec3::from(self.joints[joint].translation);
        std::array::from_fn(|point| match point {
            0 => origin(model.wrist),
            _ if point < tips => tips_m[point - 1],
            _ => origin(model.right_hand.first_joint + point - tips),
        })
    }

    /// Every joint, then the tips of thumb, index, middle, ring and pinky, in metres: 57 points of
    /// a body with hands, in the order of the published simulator, 21 of a hand.
    pub fn output_points(&self, model: &BodyModel) -> Vec<Vec3> {
        let joints = self.joints.iter().map(|joint| Vec3::from(joint.translation));
        joints.chain(model.fingertips.map(|tip| self.vertices_m[tip as usize])).collect()
    }

    /// Position and rotation of the wrist, with the `articulation` the hand was posed with.
    pub fn hand_params(&self, model: &BodyModel, articulation: [f32; 6]) -> HandParams {
        let wrist = &self.joints[model.wrist];
        HandParams {
            articulation,
            translation_m: wrist.translation.into(),
            rotation: axis_angle_from_matrix(wrist.matrix3.into()),
        }
    }
}

// The wrist, five tips and the joints of one hand.
const _: () = assert!(EVALUATION_JOINTS.len() == 1 + 5 + HAND_JOINTS);

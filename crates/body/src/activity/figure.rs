//! A posture in the words of anatomy, and the body's rotations that make it.
//!
//! # Model
//! Angles are in radians and zero for somebody who stands upright with hanging arms. Limbs of the
//! right side are mirror images of those of the left. Shoulders turn as
//! `Rx(-flexion)·Rz(abduction - π/2)·Rx(twist)` from the T-pose, hips as
//! `Rx(-flexion)·Rz(abduction)·Ry(turn)`.

use std::f32::consts::FRAC_PI_2;

use evpose_pose::rotation::axis_angle_from_matrix;
use glam::{Mat3, Vec2, Vec3};

use crate::{BodyModel, BodyPose, PosedBody, ShapedBody};

/// How an arm is held, in radians.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Arm {
    /// Upper arm forwards, 0 hanging, π/2 level.
    pub flexion: f32,
    /// Upper arm away from the body, 0 hanging, π/2 level.
    pub abduction: f32,
    /// Upper arm about itself; -π/2 makes a bent forearm of a level arm point up.
    pub twist: f32,
    /// Elbow, 0 straight.
    pub elbow: f32,
    /// Hand about the wrist.
    pub wrist: f32,
}

/// How a leg is held, in radians.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Leg {
    /// Thigh forwards.
    pub flexion: f32,
    /// Thigh away from the other.
    pub abduction: f32,
    /// Foot outwards.
    pub turn: f32,
    /// Knee, 0 straight.
    pub knee: f32,
    /// Toes down.
    pub ankle: f32,
}

/// Part that stays in place while the body bends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Anchor {
    /// The middle between both ankles.
    #[default]
    Feet,
    /// The hips: the anchor of walking.
    Pelvis,
    /// The left (0) or the right (1) ankle.
    Foot(usize),
}

/// Posture and position of a person. Angles in radians.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figure {
    /// Position of the anchor in metres: to the left of a body that faces +z, and along z.
    pub place_m: Vec2,
    /// Height of the lower foot above the floor, in metres.
    pub rise_m: f32,
    /// Part that stands at `place_m`.
    pub anchor: Anchor,
    /// Turn of the whole body to its left; 0 looks along z.
    pub heading: f32,
    /// Hips forwards and to the side.
    pub pelvis: [f32; 2],
    /// Trunk forwards, to the right, and turned to its left.
    pub spine: [f32; 3],
    /// Head forwards, to the right, and turned to its left.
    pub head: [f32; 3],
    /// Left and right.
    pub arms: [Arm; 2],
    /// Left and right.
    pub legs: [Leg; 2],
}

/// How far the sole is below the ankle and the toes' joint, in metres.
pub(crate) const SOLE: [(usize, Vec3); 4] = [
    (7, Vec3::new(0.0, -0.085, -0.045)),
    (8, Vec3::new(0.0, -0.085, -0.045)),
    (10, Vec3::new(0.0, -0.030, 0.04)),
    (11, Vec3::new(0.0, -0.030, 0.04)),
];

/// Share of an arm's lift that the collar bone does.
const COLLAR: f32 = 0.18;

/// Height of the lower foot of a body with posed joints, in metres.
pub(crate) fn lowest_sole_m(posed: &PosedBody) -> f32 {
    let soles = SOLE.iter().map(|&(joint, below)| posed.joints[joint].transform_point3(below).y);
    soles.fold(f32::INFINITY, f32::min)
}

impl Figure {
    /// The rotations of SMPL+H's joints, and the displacement that puts the feet on the floor at
    /// height zero. `posed` is memory to work in; its joints are those of the pose afterwards.
    ///
    /// # Panics
    /// If the model is no body with both hands.
    pub fn pose(&self, model: &BodyModel, shaped: &ShapedBody, posed: &mut PosedBody) -> BodyPose {
        let mut pose = BodyPose::rest(model);
        for (basis, side) in [(&model.left_hand, 0), (&Some(model.right_hand.clone()), 1)] {
            if let Some(basis) = basis {
                pose.set_hand(basis, &[]);
            }
            self.set_side(&mut pose, side);
        }
        let turned = |rotation: Mat3| axis_angle_from_matrix(rotation);
        let [forwards, aside] = self.pelvis;
        // The heading comes last: bends are relative to the body's own front.
        pose.joints[0] = turned(
            Mat3::from_rotation_y(self.heading)
                * Mat3::from_rotation_x(forwards)
                * Mat3::from_rotation_z(-aside),
        );
        let bend = |[forwards, right, left]: [f32; 3], share: f32| {
            turned(
                Mat3::from_rotation_x(share * forwards)
                    * Mat3::from_rotation_z(-share * right)
                    * Mat3::from_rotation_y(share * left),
            )
        };
        // Several joints share each bend, as vertebrae do.
        for joint in [3, 6, 9] {
            pose.joints[joint] = bend(self.spine, 1.0 / 3.0);
        }
        for joint in [12, 15] {
            pose.joints[joint] = bend(self.head, 0.5);
        }
        // Without a place first, which follows from where the joints come to lie.
        model.pose_joints(shaped, &pose, posed);
        let joint_m = |joint: usize| Vec3::from(posed.joints[joint].translation);
        let anchor_m = match self.anchor {
            Anchor::Feet => 0.5 * (joint_m(7) + joint_m(8)),
            Anchor::Pelvis => joint_m(0),
            Anchor::Foot(side) => joint_m(7 + side.min(1)),
        };
        pose.translation_m = Vec3::new(
            self.place_m.x - anchor_m.x,
            self.rise_m - lowest_sole_m(posed),
            self.place_m.y - anchor_m.z,
        );
        // The joints were posed before the displacement was known.
        for joint in &mut posed.joints {
            joint.translation += glam::Vec3A::from(pose.translation_m);
        }
        pose
    }

    /// The arm and the leg of one side.
    fn set_side(&self, pose: &mut BodyPose, side: usize) {
        // A mirror image turns the other way about y and z.
        let mirror = |v: Vec3| if side == 0 { v } else { Vec3::new(v.x, -v.y, -v.z) };
        let mut set = |joint: usize, rotation: Mat3| {
            pose.joints[joint + side] = mirror(axis_angle_from_matrix(rotation));
        };
        let Arm { flexion, abduction, twist, elbow, wrist } = self.arms[side];
        // A raised arm lifts its shoulder.
        let lift = flexion.abs().max(abduction);
        let collar = Mat3::from_rotation_z(COLLAR * (lift - 0.9));
        let upper = Mat3::from_rotation_x(-flexion)
            * Mat3::from_rotation_z(abduction - FRAC_PI_2)
            * Mat3::from_rotation_x(twist);
        set(13, collar);
        // The arm's angles are relative to the trunk, not to the collar.
        set(16, collar.transpose() * upper);
        set(18, Mat3::from_rotation_y(-elbow));
        set(20, Mat3::from_rotation_z(wrist));
        let Leg { flexion, abduction, turn, knee, ankle } = self.legs[side];
        let thigh = Mat3::from_rotation_x(-flexion)
            * Mat3::from_rotation_z(abduction)
            * Mat3::from_rotation_y(turn);
        set(1, thigh);
        set(4, Mat3::from_rotation_x(knee));
        set(7, Mat3::from_rotation_x(ankle));
    }
}

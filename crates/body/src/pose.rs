//! Poses of a body, and their construction from the published generator's 78 parameters.

use evpose_pose::HandParams;
use glam::Vec3;

use crate::fingers::HandRotations;
use crate::skeleton::{BODY_JOINTS, HAND_JOINTS, JOINTS};
use crate::{BodyModel, HandBasis};

/// Number of the generator's pose parameters: 22 axis-angles of the body, 6 articulation
/// coefficients of the left hand, 6 of the right.
pub const GENERATOR_PARAMETERS: usize = 78;

/// Articulation coefficients of one hand.
pub(crate) const ARTICULATION: usize = 6;

/// First of the generator's coefficients of the left hand.
const LEFT_COEFFICIENTS: usize = 3 * BODY_JOINTS;
/// First of the generator's coefficients of the right hand.
pub(crate) const RIGHT_COEFFICIENTS: usize = LEFT_COEFFICIENTS + ARTICULATION;

/// Constant part of the published distribution, with the elbow's twist on its positive side: the
/// body on which a predicted hand is displayed.
const PLAYBACK: [(usize, f32); 4] = [(44, 0.2), (53, 0.1), (57, 1.4), (59, 0.5)];

/// Rotations of all joints and a displacement of the whole.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyPose {
    /// Axis-angle of every joint relative to its parent, in radians.
    pub joints: Vec<Vec3>,
    /// Displacement in metres.
    pub translation_m: Vec3,
}

impl BodyPose {
    /// The rest pose of `model`, flat hands included.
    pub fn rest(model: &BodyModel) -> Self {
        Self { joints: vec![Vec3::ZERO; model.parents.len()], translation_m: Vec3::ZERO }
    }

    /// Builds the pose of the generator's 78 parameters. The hands' mean poses are added.
    ///
    /// # Panics
    /// If the model has no body with both hands.
    pub fn from_generator(
        model: &BodyModel,
        parameters: &[f32; GENERATOR_PARAMETERS],
        translation_m: Vec3,
    ) -> Self {
        assert_eq!(model.parents.len(), JOINTS, "the generator poses a body with both hands");
        let mut pose = Self::rest(model);
        for (joint, angles) in pose.joints.iter_mut().zip(parameters[..LEFT_COEFFICIENTS].chunks(3))
        {
            *joint = Vec3::from_slice(angles);
        }
        if let Some(left_hand) = &model.left_hand {
            pose.set_hand(left_hand, &parameters[LEFT_COEFFICIENTS..RIGHT_COEFFICIENTS]);
        }
        pose.set_hand(&model.right_hand, &parameters[RIGHT_COEFFICIENTS..]);
        pose.translation_m = translation_m;
        pose
    }

    /// Builds the pose in which a predicted hand is displayed, before its wrist is moved to the
    /// predicted position.
    pub fn for_playback(model: &BodyModel, hand: &HandParams) -> Self {
        if model.parents.len() < JOINTS {
            return Self::of_hand(model, &hand.articulation);
        }
        let mut parameters = [0.0; GENERATOR_PARAMETERS];
        for (entry, value) in PLAYBACK {
            parameters[entry] = value;
        }
        parameters[RIGHT_COEFFICIENTS..].copy_from_slice(&hand.articulation);
        Self::from_generator(model, &parameters, Vec3::ZERO)
    }

    /// The estimated hand articulated, everything else at rest.
    pub fn of_hand(model: &BodyModel, coefficients: &[f32]) -> Self {
        let mut pose = Self::rest(model);
        pose.set_hand(&model.right_hand, coefficients);
        pose
    }

    /// Articulates one hand.
    pub fn set_hand(&mut self, basis: &HandBasis, coefficients: &[f32]) {
        let hand = &mut self.joints[basis.first_joint..];
        for (k, joint) in hand.iter_mut().take(HAND_JOINTS).enumerate() {
            *joint = basis.rotation(k, coefficients);
        }
    }

    /// Sets the rotations of one hand's joints.
    pub fn set_hand_rotations(&mut self, basis: &HandBasis, rotations: &HandRotations) {
        self.joints[basis.first_joint..][..HAND_JOINTS].copy_from_slice(rotations);
    }
}

//! Axes of the joints of a hand model, from its skeleton at rest.
//!
//! # Model
//! The palm has three directions: distal (wrist to the middle knuckle), palmar (out of the palm) and
//! radial (towards the thumb's side), the latter two from the knuckles of index and pinky. A rotation from
//! direction u to direction v is about u × v. So a knuckle spreads about distal × radial and then
//! flexes about e × palmar, with e between the distal direction and that of its own metacarpal:
//! fingers that close converge. The other joints of a finger are hinges about (its bone) × palmar.
//! The thumb's metacarpal is brought to its direction the shortest way and twisted about itself
//! the more the farther it is from the hand at rest, as its saddle joint does (pronation); its
//! two hinges are about (their bone) × (direction of its pad).
//!
//! Angles are absolute, whereas models rest with fingers slightly spread and bent: what is
//! measured at rest is subtracted. So the same angles are the same hand on the procedural arm,
//! MakeHuman's body and MANO, and on either side. Only DIP and IP joints are taken as straight at
//! rest, since the vertices at tips lie on the skin and not on the bones' axes.
//!
//! The share of convergence, the direction of the pad and the gain of pronation are ours, by eye.

use evpose_pose::HandSide;
use glam::{Mat3, Quat, Vec3};

use super::HandAngles;
use super::angles::DIGITS;
use crate::skeleton::HAND_JOINTS;
use crate::{BodyModel, ShapedBody};

/// Axis-angles of the 15 joints of a hand relative to their parents, in radians, in the model's
/// order: index, middle, pinky, ring, thumb.
pub type HandRotations = [Vec3; HAND_JOINTS];

/// First joint of thumb, index, middle, ring and pinky in the model's order.
pub(crate) const FIRST_JOINTS: [usize; DIGITS] = [12, 0, 3, 9, 6];

/// How far the plane in which a finger flexes turns from the distal direction to its metacarpal.
const CONVERGENCE: f32 = 0.35;
/// Direction of the thumb's pad at rest: palmar and against radial.
const PAD: [f32; 2] = [0.66, 0.74];
/// Palmar abduction and CMC flexion from which on the thumb pronates, and its most, in radians.
const PRONATION_FROM_RAD: [f32; 2] = [0.26, -0.70];
const MAX_PRONATION_RAD: f32 = 1.4;

/// Directions of the palm at rest, of length one and perpendicular to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Palm {
    distal: Vec3,
    palmar: Vec3,
    radial: Vec3,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Finger {
    spread: Vec3,
    flexion: Vec3,
    hinge: Vec3,
    /// Spread, MCP, PIP and DIP angle at rest.
    rest: [f32; 4],
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Thumb {
    /// Direction of the metacarpal at rest.
    metacarpal: Vec3,
    hinge: Vec3,
    /// MCP angle at rest.
    rest: f32,
}

/// Axes of a hand model's joints, and its angles at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerAxes {
    palm: Palm,
    fingers: [Finger; 4],
    thumb: Thumb,
}

impl FingerAxes {
    /// The axes of the estimated hand of `model`, which is one of `side`, in the shape of `shaped`.
    pub fn new(model: &BodyModel, shaped: &ShapedBody, side: HandSide) -> Self {
        let joint = |k: usize| shaped.joints_m[model.right_hand.first_joint + k];
        let wrist = shaped.joints_m[model.wrist];
        let [_, index, middle, _, pinky] = FIRST_JOINTS.map(joint);
        let distal = (middle - wrist).normalize();
        let across = index - pinky;
        // In a mirror, a cross product points the other way.
        let hand = if side.is_right() { 1.0 } else { -1.0 };
        let palmar = hand * across.cross(distal).normalize();
        let palm = Palm { distal, palmar, radial: hand * distal.cross(palmar) };
        let bone = |from: usize| (joint(from + 1) - joint(from)).normalize();
        let [thumb, fingers @ ..] = FIRST_JOINTS;
        let fingers = fingers
            .map(|k| Finger::new(&palm, (joint(k) - wrist).normalize(), [bone(k), bone(k + 1)]));
        let thumb = Thumb::new(&palm, [bone(thumb), bone(thumb + 1)]);
        Self { palm, fingers, thumb }
    }

    /// Rotations of the joints for these angles.
    pub fn rotations(&self, angles: &HandAngles) -> HandRotations {
        let mut rotations = [Vec3::ZERO; HAND_JOINTS];
        for (digit, (angles, first)) in angles.digits.iter().zip(FIRST_JOINTS).enumerate() {
            rotations[first..first + 3].copy_from_slice(&self.of_digit(digit, angles));
        }
        rotations
    }

    /// Rotations of the three joints of a digit for its angles.
    pub fn of_digit(&self, digit: usize, angles: &[f32; 4]) -> [Vec3; 3] {
        match digit.checked_sub(1) {
            None => self.thumb.rotations(&self.palm, angles),
            Some(finger) => self.fingers[finger].rotations(angles),
        }
    }
}

impl Finger {
    /// The axes of a finger from its metacarpal and its first two bones.
    fn new(palm: &Palm, metacarpal: Vec3, [first, second]: [Vec3; 2]) -> Self {
        let flat = metacarpal - palm.palmar * metacarpal.dot(palm.palmar);
        let plane = palm.distal.lerp(flat.normalize(), CONVERGENCE);
        let hinge = first.cross(palm.palmar).normalize();
        let spread = first.dot(palm.radial).atan2(first.dot(palm.distal));
        let mcp = first.dot(palm.palmar).clamp(-1.0, 1.0).asin();
        Self {
            spread: palm.distal.cross(palm.radial),
            flexion: plane.cross(palm.palmar).normalize(),
            hinge,
            rest: [spread, mcp, angle_about(hinge, first, second), 0.0],
        }
    }

    fn rotations(&self, angles: &[f32; 4]) -> [Vec3; 3] {
        let [spread, mcp, pip, dip] = std::array::from_fn(|k| angles[k] - self.rest[k]);
        let knuckle =
            Quat::from_axis_angle(self.flexion, mcp) * Quat::from_axis_angle(self.spread, spread);
        [scaled_axis(knuckle), self.hinge * pip, self.hinge * dip]
    }
}

impl Thumb {
    /// The axes of the thumb from its first two bones.
    fn new(palm: &Palm, [metacarpal, second]: [Vec3; 2]) -> Self {
        let pad = palm.palmar * PAD[0] - palm.radial * PAD[1];
        let hinge = second.cross(pad).normalize();
        Self { metacarpal, hinge, rest: angle_about(hinge, metacarpal, second) }
    }

    fn rotations(&self, palm: &Palm, angles: &[f32; 4]) -> [Vec3; 3] {
        let [abduction, flexion, mcp, ip] = *angles;
        let in_palm = palm.distal * flexion.cos() - palm.radial * flexion.sin();
        let direction = in_palm * abduction.cos() + palm.palmar * abduction.sin();
        let [abducted, flexed] = PRONATION_FROM_RAD;
        let pronation = ((abduction - abducted) + (flexion - flexed)).clamp(0.0, MAX_PRONATION_RAD);
        // The pad turns from palmar to away from radial: about the thumb, in the sense of the hand.
        let sense = palm.distal.dot(palm.palmar.cross(-palm.radial)).signum();
        let twist = Quat::from_axis_angle(direction, sense * pronation);
        let saddle = twist * Quat::from_rotation_arc(self.metacarpal, direction);
        [scaled_axis(saddle), self.hinge * (mcp - self.rest), self.hinge * ip]
    }
}

/// The angle by which `from` turns to `to` about `axis`, in radians.
fn angle_about(axis: Vec3, from: Vec3, to: Vec3) -> f32 {
    from.cross(to).dot(axis).atan2(from.dot(to))
}

/// Axis times angle, with an angle of at most pi.
fn scaled_axis(rotation: Quat) -> Vec3 {
    evpose_pose::rotation::axis_angle_from_matrix(Mat3::from_quat(rotation))
}

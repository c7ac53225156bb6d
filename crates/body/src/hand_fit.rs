//! The hand whose joints are those that a network sees.
//!
//! # Model
//! Sought are the angles `a` of the digits, rotation `R` and position `t` of the wrist that minimise, with the points
//! `X = R p(a) + t` of the neutral hand,
//! `Σ |ray(X) - r|² / σ_ray² + |depth(X) - d|² / σ_depth² + (a - m)ᵀ P (a - m)`
//! and a weak prior of the distance, within the limits of the joints. What a joint counts follows from the width of its
//! heatmap.
//! Rays alone leave the distance open; the size of the neutral hand gives it, as lengths of its palm are the
//! unit of the depths. The start is the rigid palm with the mean fingers; a few steps of Gauss-Newton follow.
//!
//! # Source
//! Scale from one bone: Iqbal et al.: *Hand Pose Estimation via Latent 2.5D Heatmap Regression*, ECCV 2018.

use evpose_core::stats::linear::solve;
use evpose_pose::rotation::matrix_from_axis_angle;
use evpose_pose::{EVALUATION_JOINTS, HandSide};
use glam::{Affine3A, Mat3, Vec2, Vec3};

use crate::fingers::{FingerAxes, HandAngles, HandRotations};
use crate::skeleton::HAND_JOINTS;
use crate::{BodyModel, HandSkeleton, ShapedBody};
use equations::NormalEquations;
use palm::Palm;
use prior::AnglePrior;

mod equations;
mod palm;
mod prior;

/// Count of joints.
const JOINTS: usize = EVALUATION_JOINTS.len();
/// Angles of a hand: four of each digit.
const ANGLES: usize = 20;
/// Parameters of a step: angles, rotation, position.
const PARAMETERS: usize = ANGLES + 6;
/// Index of the first of the rotation, and of the position.
const ROTATION: usize = ANGLES;
const POSITION: usize = ROTATION + 3;
/// Distance of a hand that nothing is known of, in metres, and the standard deviation of its natural logarithm.
/// Joints that a network is not sure of lie near the middle of the image, as those of a hand far away would.
const DISTANCE_M: f32 = 0.5;
const SIGMA_LOG_DISTANCE: f32 = 0.7;
/// Largest distance, in metres: of a hand farther away no event camera shows the fingers.
const FAR_M: f32 = 2.0;
/// Largest coefficient of the articulation. Those of training are within 2.
const MAX_ARTICULATION: f32 = 2.5;
/// Largest change of an angle in a step: beyond, the step before says nothing.
const MAX_TURN_RAD: f32 = 0.7;
/// Depth before which nothing is projected, in metres.
const NEAR_M: f32 = 0.03;
/// By how much a hand is nearer than the one that is fitted, for each cell that the median heatmap is wider than that of a
/// joint that is seen. Measured, on recordings of the simulator: fitted hands were a sixth too far away, though as large
/// as they should be in the image. Why is not known; larger depths did not change it.
const NEARER_PER_CELL: f32 = 0.07;
/// Spread of the heatmap of a joint that is seen, in cells.
const SEEN_SPREAD_CELLS: f32 = 1.0;
/// Steps: from the start by the palm, more change nothing that is observed.
const STEPS: usize = 5;

/// The joints of one image, in the frame of its camera: x right, y up, looking along -z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointObservation {
    /// `(x, y) / -z` of each joint, in the order of [`EVALUATION_JOINTS`].
    pub rays: [Vec2; JOINTS],
    /// How far each joint lies behind the wrist, in lengths of the palm.
    pub depths: [f32; JOINTS],
    /// How far from each position its heatmap is, in cells, as a standard deviation of one axis.
    pub spread_cells: [f32; JOINTS],
    /// The likelihood of each joint near its position, 0 to 1.
    pub scores: [f32; JOINTS],
    /// The likelihood of a hand being in the image, 0 to 1.
    pub presence: f32,
}

impl JointObservation {
    /// The distance of a hand over that of the one that is fitted to these joints.
    fn nearer(&self) -> f32 {
        let mut spread_cells = self.spread_cells;
        // Of single joints that may be anywhere, the others say nothing.
        let (_, median, _) = spread_cells.select_nth_unstable_by(JOINTS / 2, f32::total_cmp);
        1.0 / (1.0 + NEARER_PER_CELL * (*median - SEEN_SPREAD_CELLS).max(0.0))
    }
}

/// A hand in the frame of the camera that saw it: x right, y up, looking along -z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedPose {
    /// The angles of its digits.
    pub angles: HandAngles,
    /// The rotations of its joints that are these angles.
    pub rotations: HandRotations,
    /// The coefficients of the articulation that come closest.
    pub articulation: [f32; 6],
    /// Rotation of the wrist.
    pub rotation: Mat3,
    /// Position of the wrist in metres.
    pub position_m: Vec3,
}

/// Fits the neutral hand of a model to joints.
#[derive(Debug, Clone)]
pub struct HandFit {
    skeleton: HandSkeleton,
    axes: FingerAxes,
    prior: AnglePrior,
    palm: Palm,
}

/// A hand between two steps of a fit.
#[derive(Debug, Clone, Copy)]
struct Guess {
    angles: [f32; ANGLES],
    rotation: Mat3,
    position_m: Vec3,
}

impl HandFit {
    /// A fit of the estimated hand of `model`, which is one of `side`, in a shape.
    pub fn new(model: &BodyModel, shaped: &ShapedBody, side: HandSide) -> Self {
        let skeleton = HandSkeleton::new(model, shaped);
        let palm = Palm::new(&skeleton.points(&[0.0; 6]));
        let axes = FingerAxes::new(model, shaped, side);
        Self { skeleton, axes, prior: AnglePrior::new(), palm }
    }

    /// Length of the palm, from the wrist to the knuckle of the middle finger, in metres.
    pub fn palm_m(&self) -> f32 {
        self.palm.length_m
    }

    /// The points of a fitted hand, in the frame of its camera, in metres.
    pub fn points_m(&self, pose: &FittedPose) -> [Vec3; JOINTS] {
        let from_wrist_m = self.skeleton.points_of(&pose.rotations);
        from_wrist_m.map(|point_m| pose.rotation * point_m + pose.position_m)
    }

    /// The hand of joints whose heatmaps have cells of `1 / focal_cells` of a ray.
    pub fn fit(&self, observed: &JointObservation, focal_cells: f32) -> FittedPose {
        let (rotation, position_m) = self.palm.place(observed);
        let mut guess = Guess { angles: self.prior.mean, rotation, position_m };
        for _ in 0..STEPS {
            let equations = NormalEquations::new(self, observed, focal_cells, &guess);
            // Without a solution the guess is the best there is.
            let Some(step) = solve(equations.matrix, equations.right) else { break };
            let v = |k: usize| step[k] as f32;
            for (k, angle) in guess.angles.iter_mut().enumerate() {
                let [low, high] = HandAngles::limits(k / 4, k % 4);
                *angle = (*angle + v(k).clamp(-MAX_TURN_RAD, MAX_TURN_RAD)).clamp(low, high);
            }
            let turn = Vec3::new(v(ROTATION), v(ROTATION + 1), v(ROTATION + 2));
            guess.rotation = matrix_from_axis_angle(turn.clamp_length_max(1.0)) * guess.rotation;
            guess.position_m += Vec3::new(v(POSITION), v(POSITION + 1), v(POSITION + 2))
                .clamp_length_max(-0.5 * guess.position_m.z);
            guess.position_m.z = guess.position_m.z.min(-NEAR_M);
            // Along its ray, so that it stays where it is seen.
            guess.position_m *= (FAR_M / -guess.position_m.z).min(1.0);
        }
        let Guess { angles, rotation, position_m } = guess;
        let position_m = observed.nearer() * position_m;
        let angles = HandAngles::from_fn(|digit, k| angles[4 * digit + k]);
        let rotations = self.axes.rotations(&angles);
        let articulation = self.skeleton.coefficients(&rotations);
        let articulation = articulation.map(|c| c.clamp(-MAX_ARTICULATION, MAX_ARTICULATION));
        FittedPose { angles, rotations, articulation, rotation, position_m }
    }

    /// The joints of angles in the frame of the wrist, and their points.
    fn placed(&self, angles: &[f32; ANGLES]) -> ([Affine3A; HAND_JOINTS], [Vec3; JOINTS]) {
        let mut joints = [Affine3A::IDENTITY; HAND_JOINTS];
        let angles = HandAngles::from_fn(|digit, k| angles[4 * digit + k]);
        self.skeleton.turn(0..HAND_JOINTS, &self.axes.rotations(&angles), &mut joints);
        let points_m = std::array::from_fn(|point| self.skeleton.point(point, &joints));
        (joints, points_m)
    }
}

#[cfg(test)]
mod tests;

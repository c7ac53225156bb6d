//! The twelve parameters of a hand from its joints as a network sees them.
//!
//! # Model
//! Sought are articulation `a`, rotation `R` and position `t` of the wrist that minimise, with the points
//! `X = R p(a) + t` of the neutral hand,
//! `Σ score² (|ray(X) - r|² / σ_ray² + |depth(X) - d|² / σ_depth²) + |a|² / σ_a²`,
//! and a weak prior of the distance.
//! Rays alone leave the distance open; the size of the neutral hand gives it, as lengths of its palm are the
//! unit of the depths. The start is the rigid palm; a few steps of Gauss-Newton follow, within limits of
//! the articulation.
//!
//! # Source
//! Scale from one bone: Iqbal et al.: *Hand Pose Estimation via Latent 2.5D Heatmap Regression*, ECCV 2018.

use evpose_core::stats::linear::solve;
use evpose_pose::EVALUATION_JOINTS;
use evpose_pose::rotation::matrix_from_axis_angle;
use glam::{Mat3, Vec2, Vec3};

use crate::HandSkeleton;
use palm::Palm;

mod palm;

/// Count of joints.
const JOINTS: usize = EVALUATION_JOINTS.len();
/// Parameters of a step: articulation, rotation, position.
const PARAMETERS: usize = 12;
/// Coefficients of the articulation.
const ARTICULATION: usize = 6;
/// Index of the first of the rotation, and of the position.
const ROTATION: usize = ARTICULATION;
const POSITION: usize = ROTATION + 3;
/// Increment of the articulation in numeric derivatives: points are of single precision.
const INCREMENT: f32 = 1e-2;
/// Standard deviation of positions, in cells: heatmaps are as exact as that or better.
const SIGMA_CELLS: f32 = 0.5;
/// Standard deviation of depths, in lengths of the palm.
const SIGMA_DEPTH: f32 = 0.2;
/// Standard deviation of coefficients: a hand that is not seen is the mean one.
const SIGMA_ARTICULATION: f32 = 1.5;
/// Distance of a hand that nothing is known of, in metres, and the standard deviation of its natural logarithm.
/// Joints that a network is not sure of lie near the middle of the image, as those of a hand far away would.
const DISTANCE_M: f32 = 0.5;
const SIGMA_LOG_DISTANCE: f32 = 0.7;
/// Largest distance, in metres: of a hand farther away no event camera shows the fingers.
const FAR_M: f32 = 2.0;
/// Largest coefficient. Those of training are within 2.
const MAX_ARTICULATION: f32 = 2.5;
/// Depth before which nothing is projected, in metres.
const NEAR_M: f32 = 0.03;
/// Steps: from the start by the palm, the fourth changes nothing any more that is observed.
const STEPS: usize = 5;
/// Damping relative to the diagonal: keeps what hardly counts from running away.
const DAMPING: f64 = 1e-3;

/// The joints of one image, in the frame of its camera: x right, y up, looking along -z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointObservation {
    /// `(x, y) / -z` of each joint, in the order of [`EVALUATION_JOINTS`].
    pub rays: [Vec2; JOINTS],
    /// How far each joint lies behind the wrist, in lengths of the palm.
    pub depths: [f32; JOINTS],
    /// The likelihood of each joint near its position, 0 to 1.
    pub scores: [f32; JOINTS],
    /// The likelihood of a hand being in the image, 0 to 1.
    pub presence: f32,
}

/// A hand in the frame of the camera that saw it: x right, y up, looking along -z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedPose {
    /// The coefficients of the articulation.
    pub articulation: [f32; ARTICULATION],
    /// Rotation of the wrist.
    pub rotation: Mat3,
    /// Position of the wrist in metres.
    pub position_m: Vec3,
}

/// Fits the neutral hand of a model to joints.
#[derive(Debug, Clone)]
pub struct HandFit {
    skeleton: HandSkeleton,
    palm: Palm,
}

impl HandFit {
    /// A fit of the hand of `skeleton`.
    pub fn new(skeleton: HandSkeleton) -> Self {
        let palm = Palm::new(&skeleton.points(&[0.0; ARTICULATION]));
        Self { skeleton, palm }
    }

    /// Length of the palm, from the wrist to the knuckle of the middle finger, in metres.
    pub fn palm_m(&self) -> f32 {
        self.palm.length_m
    }

    /// The hand of joints whose heatmaps have cells of `1 / focal_cells` of a ray.
    pub fn fit(&self, observed: &JointObservation, focal_cells: f32) -> FittedPose {
        let mut pose = self.palm.place(observed);
        for _ in 0..STEPS {
            let (matrix, gradient) = self.normal_equations(observed, focal_cells, &pose);
            // Without a solution the pose is the best there is.
            let Some(step) = solve(matrix, gradient) else { break };
            let v = |k: usize| step[k] as f32;
            for (k, coefficient) in pose.articulation.iter_mut().enumerate() {
                *coefficient = (*coefficient + v(k)).clamp(-MAX_ARTICULATION, MAX_ARTICULATION);
            }
            let turn = Vec3::new(v(ROTATION), v(ROTATION + 1), v(ROTATION + 2));
            pose.rotation = matrix_from_axis_angle(turn.clamp_length_max(1.0)) * pose.rotation;
            pose.position_m += Vec3::new(v(POSITION), v(POSITION + 1), v(POSITION + 2))
                .clamp_length_max(-0.5 * pose.position_m.z);
            pose.position_m.z = pose.position_m.z.min(-NEAR_M);
            // Along its ray, so that it stays where it is seen.
            pose.position_m *= (FAR_M / -pose.position_m.z).min(1.0);
        }
        pose
    }

    /// The normal equations of a step from `pose`, damped: matrix and negative gradient.
    fn normal_equations(
        &self,
        observed: &JointObservation,
        focal_cells: f32,
        pose: &FittedPose,
    ) -> (Vec<Vec<f64>>, Vec<f64>) {
        let points_m = self.skeleton.points(&pose.articulation);
        let by_coefficient: [[Vec3; JOINTS]; ARTICULATION] = std::array::from_fn(|k| {
            let mut shifted = pose.articulation;
            shifted[k] += INCREMENT;
            let shifted_m = self.skeleton.points(&shifted);
            std::array::from_fn(|joint| (shifted_m[joint] - points_m[joint]) / INCREMENT)
        });
        let mut matrix = vec![vec![0.0; PARAMETERS]; PARAMETERS];
        let mut gradient = vec![0.0; PARAMETERS];
        let mut add = |residual: f32, row: &[f32; PARAMETERS]| {
            for i in 0..PARAMETERS {
                gradient[i] -= f64::from(residual * row[i]);
                for j in 0..=i {
                    matrix[i][j] += f64::from(row[i] * row[j]);
                }
            }
        };
        for joint in 0..JOINTS {
            let from_wrist_m = pose.rotation * points_m[joint];
            let at_m = from_wrist_m + pose.position_m;
            let moved: [Vec3; PARAMETERS] = std::array::from_fn(|k| match k {
                0..ROTATION => pose.rotation * by_coefficient[k][joint],
                ROTATION..POSITION => Vec3::AXES[k - ROTATION].cross(from_wrist_m),
                _ => Vec3::AXES[k - POSITION],
            });
            let depth_m = (-at_m.z).max(NEAR_M);
            let ray = at_m.truncate() / depth_m;
            // In standard deviations, so that all residuals have one unit.
            let weight = observed.scores[joint] * focal_cells / SIGMA_CELLS;
            let off: Vec2 = weight * (ray - observed.rays[joint]);
            for axis in 0..2 {
                // d (x / -z) = (dx + x / -z dz) / -z.
                let by = |m: Vec3| weight * (m[axis] + ray[axis] * m.z) / depth_m;
                add(off[axis], &moved.map(by));
            }
            let weight = observed.scores[joint] / SIGMA_DEPTH;
            let behind = -from_wrist_m.z / self.palm.length_m;
            let mut row = moved.map(|m| -weight * m.z / self.palm.length_m);
            // Depths are relative to the wrist, wherever it is.
            row[POSITION..].fill(0.0);
            add(weight * (behind - observed.depths[joint]), &row);
        }
        let depth_m = -pose.position_m.z;
        let mut row = [0.0; PARAMETERS];
        row[POSITION + 2] = -1.0 / (depth_m * SIGMA_LOG_DISTANCE);
        add((depth_m / DISTANCE_M).ln() / SIGMA_LOG_DISTANCE, &row);
        for (k, coefficient) in pose.articulation.iter().enumerate() {
            let mut row = [0.0; PARAMETERS];
            row[k] = 1.0 / SIGMA_ARTICULATION;
            add(coefficient / SIGMA_ARTICULATION, &row);
        }
        for i in 0..PARAMETERS {
            // Only the lower half was summed up.
            let (above, below) = matrix.split_at_mut(i);
            above.iter_mut().zip(&below[0]).for_each(|(row, value)| row[i] = *value);
            below[0][i] *= 1.0 + DAMPING;
        }
        (matrix, gradient)
    }
}

#[cfg(test)]
mod tests;

//! The normal equations of one step of a fit.

use glam::Vec3;

use super::{
    ANGLES, DISTANCE_M, Guess, HandFit, JOINTS, JointObservation, NEAR_M, PARAMETERS, POSITION,
    ROTATION, SIGMA_LOG_DISTANCE,
};
use crate::fingers::axes::FIRST_JOINTS;

/// Increment of angles in numeric derivatives, in radians: points are of single precision.
const INCREMENT_RAD: f32 = 1e-2;
/// Standard deviation of a position that a heatmap has for certain, in cells.
const SIGMA_CELLS: f32 = 0.5;
/// Standard deviation of depths, in lengths of the palm, and how much it grows with that of the position.
const SIGMA_DEPTH: f32 = 0.2;
const SIGMA_DEPTH_PER_CELL: f32 = 0.05;
/// Weight of the prior. Heatmaps are wider than their peaks are wrong, and at 1 it bent fingers that were seen straight:
/// measured, on recordings of the simulator that nothing was trained on.
const PRIOR_WEIGHT: f64 = 0.3;
/// Damping relative to the diagonal: keeps what hardly counts from running away.
const DAMPING: f64 = 1e-3;
/// The wrist and the fingertips come before the joints of the digits.
const FIRST_OF_DIGITS: usize = 6;

/// `matrix · step = right`.
#[derive(Debug)]
pub(super) struct NormalEquations {
    pub(super) matrix: Vec<Vec<f64>>,
    pub(super) right: Vec<f64>,
}

impl NormalEquations {
    /// Those of a step from `guess`, damped.
    pub(super) fn new(
        fit: &HandFit,
        observed: &JointObservation,
        focal_cells: f32,
        guess: &Guess,
    ) -> Self {
        let mut equations =
            Self { matrix: vec![vec![0.0; PARAMETERS]; PARAMETERS], right: vec![0.0; PARAMETERS] };
        let (placed, points_m) = fit.placed(&guess.angles);
        equations.add_joint(
            fit,
            observed,
            focal_cells,
            guess,
            (0, 0),
            (points_m[0], [Vec3::ZERO; 4]),
        );
        for (digit, first) in FIRST_JOINTS.into_iter().enumerate() {
            let angles: [f32; 4] = std::array::from_fn(|k| guess.angles[4 * digit + k]);
            // A digit moves its own points alone.
            let points = [
                FIRST_OF_DIGITS + first,
                FIRST_OF_DIGITS + first + 1,
                FIRST_OF_DIGITS + first + 2,
                1 + digit,
            ];
            let mut by_angle = [[Vec3::ZERO; 4]; 4];
            for k in 0..4 {
                let mut shifted = angles;
                shifted[k] += INCREMENT_RAD;
                let mut joints = placed;
                fit.skeleton.turn(
                    first..first + 3,
                    &fit.axes.of_digit(digit, &shifted),
                    &mut joints,
                );
                for (by_angle, point) in by_angle.iter_mut().zip(points) {
                    by_angle[k] =
                        (fit.skeleton.point(point, &joints) - points_m[point]) / INCREMENT_RAD;
                }
            }
            for (point, by_angle) in points.into_iter().zip(by_angle) {
                equations.add_joint(
                    fit,
                    observed,
                    focal_cells,
                    guess,
                    (point, digit),
                    (points_m[point], by_angle),
                );
            }
        }
        equations.add_priors(fit, guess);
        for i in 0..PARAMETERS {
            // Only the lower half was summed up.
            let (above, below) = equations.matrix.split_at_mut(i);
            above.iter_mut().zip(&below[0]).for_each(|(row, value)| row[i] = *value);
            below[0][i] *= 1.0 + DAMPING;
        }
        equations
    }

    /// Adds the ray and the depth of joint `joint` of `digit`, which lies at `point_m` in the frame of the wrist.
    fn add_joint(
        &mut self,
        fit: &HandFit,
        observed: &JointObservation,
        focal_cells: f32,
        guess: &Guess,
        (joint, digit): (usize, usize),
        (point_m, by_angle): (Vec3, [Vec3; 4]),
    ) {
        let from_wrist_m = guess.rotation * point_m;
        let at_m = from_wrist_m + guess.position_m;
        // Parameter and what it moves: the angles of the digit, rotation, position.
        let moved: [(usize, Vec3); 10] = std::array::from_fn(|k| match k {
            0..4 => (4 * digit + k, guess.rotation * by_angle[k]),
            4..7 => (ROTATION + k - 4, Vec3::AXES[k - 4].cross(from_wrist_m)),
            _ => (POSITION + k - 7, Vec3::AXES[k - 7]),
        });
        let depth_m = (-at_m.z).max(NEAR_M);
        let ray = at_m.truncate() / depth_m;
        let spread = observed.spread_cells[joint];
        // In standard deviations, so that all residuals have one unit.
        let weight = focal_cells / SIGMA_CELLS.hypot(spread);
        let off = weight * (ray - observed.rays[joint]);
        for axis in 0..2 {
            // d (x / -z) = (dx + x / -z dz) / -z.
            let by = |m: Vec3| weight * (m[axis] + ray[axis] * m.z) / depth_m;
            self.add(off[axis], &moved.map(|(k, m)| (k, by(m))));
        }
        let weight = 1.0 / (SIGMA_DEPTH + SIGMA_DEPTH_PER_CELL * spread);
        let behind = -from_wrist_m.z / fit.palm_m();
        // Depths are relative to the wrist, wherever it is.
        let by = |(k, m): (usize, Vec3)| {
            (k, if k < POSITION { -weight * m.z / fit.palm_m() } else { 0.0 })
        };
        self.add(weight * (behind - observed.depths[joint]), &moved.map(by));
    }

    fn add_priors(&mut self, fit: &HandFit, guess: &Guess) {
        let depth_m = -guess.position_m.z;
        let by = -1.0 / (depth_m * SIGMA_LOG_DISTANCE);
        self.add((depth_m / DISTANCE_M).ln() / SIGMA_LOG_DISTANCE, &[(POSITION + 2, by)]);
        let off: [f64; ANGLES] =
            std::array::from_fn(|k| f64::from(guess.angles[k] - fit.prior.mean[k]));
        for (i, row) in fit.prior.precision.iter().enumerate() {
            let slope: f64 = row.iter().zip(off).map(|(p, off)| p * off).sum();
            self.right[i] -= PRIOR_WEIGHT * slope;
            let row = row.iter().map(|p| PRIOR_WEIGHT * p);
            self.matrix[i][..=i].iter_mut().zip(row).for_each(|(sum, p)| *sum += p);
        }
    }

    /// Adds a residual with its derivatives, by the index of their parameters in ascending order.
    fn add(&mut self, residual: f32, row: &[(usize, f32)]) {
        for (n, &(i, by_i)) in row.iter().enumerate() {
            self.right[i] -= f64::from(residual * by_i);
            for &(j, by_j) in &row[..=n] {
                self.matrix[i][j] += f64::from(by_i * by_j);
            }
        }
    }
}

const _: () = assert!(JOINTS == FIRST_OF_DIGITS + 15);

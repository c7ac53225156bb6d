//! Fit of parameters of a model to a summary.
//!
//! # Model
//! Gauss-Newton steps on the robust discrepancy `sum rho(z)`, by iteratively reweighted least
//! squares with the weights of `rho`. Derivatives are finite differences of simulations, smooth
//! because of common random numbers. A wide normal prior keeps parameters in place that a recording
//! does not constrain.

use evpose_core::stats::linear::solve;
use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use crate::compare::{Expectation, RHO_FREEDOM, discrepancy};
use crate::free_parameter::FreeParameter;
use crate::{GapError, Objective};

/// Fractions of a Gauss-Newton step that are tried in one line search.
const FRACTIONS: [f64; 3] = [1.0, 0.4, 0.12];
/// Largest change of a parameter in one round, steps.
const MAX_STEPS: f64 = 8.0;
/// Decrease of the discrepancy below which a fit has converged.
const MIN_GAIN: f64 = 0.3;
/// Reweighted least-squares solutions per step; the weights have converged after a few.
const REWEIGHTINGS: usize = 4;

/// A model fitted to a recording.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The model with its fitted parameters.
    pub model: SensorConfig,
    /// Its discrepancy statistic.
    pub discrepancy: f64,
}

/// Derivatives of the expected summary of a model with respect to free parameters.
#[derive(Debug, Clone)]
pub struct Slopes {
    /// One column per parameter: change per step, in the units of the summary.
    pub columns: Vec<Vec<f64>>,
}

impl Slopes {
    /// Finite differences of simulations around a model, each from `runs` runs.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn around(
        objective: &Objective<'_>,
        model: &SensorConfig,
        free_parameters: &[FreeParameter],
        runs: u64,
    ) -> Result<Self, GapError> {
        let centre = objective.expect(model, runs)?;
        let column = |free_parameter: &FreeParameter| -> Result<Vec<f64>, GapError> {
            // At the end of its range a step up would be none, and the slope zero.
            let step = if free_parameter.is_at_top(model) { -1.0 } else { 1.0 };
            let moved = objective.expect(&free_parameter.stepped(model, step), runs)?;
            let slope = |(a, b): (&f64, &f64)| {
                let slope = (b - a) / step;
                // A statistic that is undefined on one side says nothing about the parameter.
                if slope.is_finite() { slope } else { 0.0 }
            };
            Ok(centre.mean.iter().zip(&moved.mean).map(slope).collect())
        };
        let columns = free_parameters.par_iter().map(column).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { columns })
    }

    /// Minimises the discrepancy of a linearised model: the steps of all parameters, each limited
    /// to `max_steps`, and the discrepancy that is left of `deviations` there.
    pub fn best(
        &self,
        max_steps: f64,
        objective: &Objective<'_>,
        expected: &Expectation,
        deviations: &[f64],
        free_parameters: &[FreeParameter],
    ) -> (Vec<f64>, f64) {
        let n = free_parameters.len();
        let scales: Vec<f64> =
            (0..deviations.len()).map(|i| expected.scale(objective.layout, i)).collect();
        let mut steps = vec![0.0; n];
        let left = |steps: &[f64]| -> Vec<f64> {
            (0..deviations.len())
                .map(|i| {
                    let moved: f64 = self.columns.iter().zip(steps).map(|(c, s)| c[i] * s).sum();
                    deviations[i] - moved / scales[i]
                })
                .collect()
        };
        // Weights of rho at the present residuals make each solution a plain least-squares problem.
        for _ in 0..REWEIGHTINGS {
            let z = left(&steps);
            let mut matrix = vec![vec![0.0; n]; n];
            let mut right = vec![0.0; n];
            for i in 0..z.len() {
                let weight = 1.0 / (1.0 + z[i] * z[i] / RHO_FREEDOM);
                for a in 0..n {
                    let slope = weight * self.columns[a][i] / scales[i];
                    if slope == 0.0 {
                        continue;
                    }
                    right[a] += slope * z[i];
                    for (cell, column) in matrix[a].iter_mut().zip(&self.columns) {
                        *cell += slope * column[i] / scales[i];
                    }
                }
            }
            for a in 0..n {
                let prior = 1.0 / free_parameters[a].prior_steps().powi(2);
                // The small constant keeps the matrix regular for a parameter that changes nothing.
                matrix[a][a] += prior + 1e-9;
                right[a] -= prior * steps[a];
            }
            let Some(change) = solve(matrix, right) else { break };
            // Slopes hold near the model only.
            for (step, change) in steps.iter_mut().zip(change) {
                *step = (*step + change).clamp(-max_steps, max_steps);
            }
        }
        let rest = discrepancy(&left(&steps));
        (steps, rest)
    }
}

/// Descends from `start` in the parameters `free` until the discrepancy stops decreasing, for at
/// most `rounds` rounds. Parameters of `linear` follow by slopes that are given with them, without
/// simulations of their own.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn descend(
    objective: &Objective<'_>,
    start: &SensorConfig,
    free: &[FreeParameter],
    linear: Option<(&[FreeParameter], &Slopes)>,
    runs: u64,
    rounds: usize,
) -> Result<Fit, GapError> {
    let mut free_parameters = free.to_vec();
    free_parameters.extend(linear.iter().flat_map(|(parameters, _)| parameters.iter()));
    let mut model = start.clone();
    let mut best = objective.discrepancy(&model, runs)?;
    for _ in 0..rounds {
        let expected = objective.expect(&model, runs)?;
        let deviations = expected.deviations(objective.layout, &objective.measured);
        let mut slopes = Slopes::around(objective, &model, free, runs)?;
        slopes.columns.extend(linear.iter().flat_map(|(_, slopes)| slopes.columns.iter().cloned()));
        let (steps, _) =
            slopes.best(MAX_STEPS, objective, &expected, &deviations, &free_parameters);
        // All fractions at once on the threads, in the time of one; the full step often overshoots.
        let tried = FRACTIONS
            .par_iter()
            .map(|fraction| {
                let moved = free_parameters
                    .iter()
                    .zip(&steps)
                    .fold(model.clone(), |model, (free_parameter, step)| {
                        free_parameter.stepped(&model, fraction * step)
                    });
                Ok((objective.discrepancy(&moved, runs)?, moved))
            })
            .collect::<Result<Vec<_>, GapError>>()?;
        let best_of_line = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        match best_of_line {
            // A gain of less is within what a single run of the model varies by.
            Some((value, moved)) if value < best - MIN_GAIN => {
                best = value;
                model = moved;
            }
            _ => break,
        }
    }
    Ok(Fit { model, discrepancy: best })
}

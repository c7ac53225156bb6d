//! Numbers of a model fitted to a summary.
//!
//! # Model
//! Gauss-Newton steps on the robust misfit `sum rho(z)`: derivatives are differences of simulations
//! with the same draws, which makes them smooth; weights are those of the robust distance; a wide
//! prior keeps numbers that a recording says nothing about where they are.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use crate::compare::{Expectation, misfit};
use crate::knob::Knob;
use crate::linear::solve;
use crate::{GapError, Lab};

/// Fractions of a step that are tried.
const FRACTIONS: [f64; 3] = [1.0, 0.4, 0.12];
/// No number moves further in one round, steps.
const FURTHEST: f64 = 8.0;
/// A gain below this is none.
const LEAST_GAIN: f64 = 0.3;

/// A model fitted to a lab's recording.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The model with its numbers.
    pub model: SensorConfig,
    /// What is left of the misfit.
    pub misfit: f64,
}

/// How the expected summary of a model changes with its knobs.
#[derive(Debug, Clone)]
pub struct Slopes {
    /// One column a knob, per step, in the units of summaries.
    pub columns: Vec<Vec<f64>>,
}

impl Slopes {
    /// Differences of simulations around a model.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn around(
        lab: &Lab<'_>,
        model: &SensorConfig,
        knobs: &[Knob],
        runs: u64,
    ) -> Result<Self, GapError> {
        let centre = lab.expect(model, runs)?;
        let column = |knob: &Knob| -> Result<Vec<f64>, GapError> {
            let step = if knob.is_at_top(model) { -1.0 } else { 1.0 };
            let moved = lab.expect(&knob.turned(model, step), runs)?;
            let slope = |(a, b): (&f64, &f64)| {
                let slope = (b - a) / step;
                if slope.is_finite() { slope } else { 0.0 }
            };
            Ok(centre.mean.iter().zip(&moved.mean).map(slope).collect())
        };
        let columns = knobs.par_iter().map(column).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { columns })
    }

    /// The steps of all knobs that make the misfit of `deviations` least, and that misfit, if
    /// summaries were linear in the knobs.
    pub fn best(
        &self,
        furthest: f64,
        lab: &Lab<'_>,
        expected: &Expectation,
        deviations: &[f64],
        knobs: &[Knob],
    ) -> (Vec<f64>, f64) {
        let n = knobs.len();
        let scales: Vec<f64> =
            (0..deviations.len()).map(|i| expected.scale(lab.layout, i)).collect();
        let mut steps = vec![0.0; n];
        let left = |steps: &[f64]| -> Vec<f64> {
            (0..deviations.len())
                .map(|i| {
                    let moved: f64 = self.columns.iter().zip(steps).map(|(c, s)| c[i] * s).sum();
                    deviations[i] - moved / scales[i]
                })
                .collect()
        };
        for _ in 0..4 {
            let z = left(&steps);
            let mut matrix = vec![vec![0.0; n]; n];
            let mut right = vec![0.0; n];
            for i in 0..z.len() {
                let weight = 1.0 / (1.0 + z[i] * z[i] / 4.0);
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
                let prior = 1.0 / knobs[a].prior_steps().powi(2);
                matrix[a][a] += prior + 1e-9;
                right[a] -= prior * steps[a];
            }
            let Some(change) = solve(matrix, right) else { break };
            for (step, change) in steps.iter_mut().zip(change) {
                *step = (*step + change).clamp(-furthest, furthest);
            }
        }
        let rest = misfit(&left(&steps));
        (steps, rest)
    }
}

/// Turns knobs until the misfit gets no smaller. What is known to change in a line with further
/// knobs is given with their slopes.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn descend(
    lab: &Lab<'_>,
    start: &SensorConfig,
    own: &[Knob],
    beside: Option<(&[Knob], &Slopes)>,
    runs: u64,
    rounds: usize,
) -> Result<Fit, GapError> {
    let mut knobs = own.to_vec();
    knobs.extend(beside.iter().flat_map(|(knobs, _)| knobs.iter()));
    let mut model = start.clone();
    let mut best = misfit_of(lab, &model, runs)?;
    for _ in 0..rounds {
        let expected = lab.expect(&model, runs)?;
        let deviations = expected.deviations(lab.layout, &lab.measured);
        let mut slopes = Slopes::around(lab, &model, own, runs)?;
        slopes.columns.extend(beside.iter().flat_map(|(_, slopes)| slopes.columns.iter().cloned()));
        let (steps, _) = slopes.best(FURTHEST, lab, &expected, &deviations, &knobs);
        let tried = FRACTIONS
            .par_iter()
            .map(|fraction| {
                let moved = knobs.iter().zip(&steps).fold(model.clone(), |model, (knob, step)| {
                    knob.turned(&model, fraction * step)
                });
                Ok((misfit_of(lab, &moved, runs)?, moved))
            })
            .collect::<Result<Vec<_>, GapError>>()?;
        let found = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        match found {
            Some((value, moved)) if value < best - LEAST_GAIN => {
                best = value;
                model = moved;
            }
            _ => break,
        }
    }
    Ok(Fit { model, misfit: best })
}

/// The misfit of a model as it is.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn misfit_of(lab: &Lab<'_>, model: &SensorConfig, runs: u64) -> Result<f64, GapError> {
    let expected = lab.expect(model, runs)?;
    Ok(misfit(&expected.deviations(lab.layout, &lab.measured)))
}

//! Uncalibrated standard deviations of estimated parameters.
//!
//! # Method
//! Derivatives are finite differences with common random numbers, weights those of the robust loss.
//! The standard deviation of a parameter is the largest of three estimates:
//! * the inverse curvature of the discrepancy, scaled by the unexplained variance;
//! * the scatter of the pulls of blocks (a cluster-robust estimate): statistics of one block share
//!   their events, and two simulators of one camera differ in all of them at once;
//! * the scatter of fits to runs of the corrected model (a parametric bootstrap).

use evpose_core::stats::linear::solve;
use evpose_sensor::SensorConfig;
use serde::{Deserialize, Serialize};

use crate::compare::RHO_FREEDOM;
use crate::fit::Slopes;
use crate::free_parameter::FreeParameter;
use crate::{GapError, Objective, StatisticBlock};

const SLOPE_RUNS: u64 = 2;
/// Runs of the corrected model in the bootstrap.
const RUNS: u64 = 6;

/// Three estimates of the standard deviation of a parameter, in its steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RawError {
    /// From the curvature of the discrepancy, without scaling.
    pub curvature: f64,
    /// Unexplained variance over expected variance, at least one, which scales the curvature's.
    pub widened: f64,
    /// From the pulls of blocks of statistics.
    pub blocks: f64,
    /// From the scatter of runs of the corrected model.
    pub runs: f64,
}

impl RawError {
    /// The largest estimate, in steps.
    pub fn steps(&self) -> f64 {
        (self.curvature * self.widened.sqrt()).max(self.blocks).max(self.runs)
    }
}

/// Estimates the standard deviations of free parameters of a model, in their steps.
pub(super) fn errors(
    objective: &Objective<'_>,
    model: &SensorConfig,
    free_parameters: &[FreeParameter],
) -> Result<Vec<RawError>, GapError> {
    let slopes = Slopes::around(objective, model, free_parameters, SLOPE_RUNS)?;
    let expected = objective.expect(model, RUNS)?;
    let scales: Vec<f64> =
        (0..expected.mean.len()).map(|i| expected.scale(objective.layout, i)).collect();
    let z = expected.deviations(objective.layout, &objective.measured);
    let n = free_parameters.len();
    let weight = |i: usize| 1.0 / (1.0 + z[i] * z[i] / RHO_FREEDOM);
    let slope = |a: usize, i: usize| slopes.columns[a][i] / scales[i];
    let mut matrix = vec![vec![0.0; n]; n];
    for i in 0..z.len() {
        for (a, row) in matrix.iter_mut().enumerate() {
            for (b, cell) in row.iter_mut().enumerate() {
                *cell += weight(i) * slope(a, i) * slope(b, i);
            }
        }
    }
    // A parameter may change nothing: its prior then bounds its error.
    for (a, free_parameter) in free_parameters.iter().enumerate() {
        matrix[a][a] += 1.0 / free_parameter.prior_steps().powi(2) + 1e-9;
    }
    // Change of each parameter by the deviations of some of the statistics.
    let pulled = |z: &[f64], is_in: &dyn Fn(usize) -> bool| -> Vec<f64> {
        let pull = |a| {
            let chosen = (0..z.len()).filter(|i| is_in(*i));
            chosen.map(|i| weight(i) * slope(a, i) * z[i]).sum()
        };
        solve(matrix.clone(), (0..n).map(pull).collect()).unwrap_or_else(|| vec![0.0; n])
    };
    let mut blocks: Vec<StatisticBlock> =
        objective.layout.entries.iter().map(|entry| entry.block).collect();
    // Only neighbours become one: a block whose entries stand apart occurs several times.
    blocks.dedup();
    // Blocks can be wrong independently of each other.
    let by_blocks: Vec<Vec<f64>> = blocks
        .iter()
        .map(|block| pulled(&z, &|i| objective.layout.entries[i].block == *block))
        .collect();
    let by_runs = (0..RUNS)
        .map(|run| {
            let z = expected.deviations(objective.layout, &objective.run(model, run)?);
            Ok(pulled(&z, &|_| true))
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    let known = z.iter().filter(|z| **z != 0.0).count().max(1) as f64;
    // As a reduced chi-square above 1: what stays unexplained makes curvature too optimistic.
    let widened = (crate::discrepancy(&z) / known).max(1.0);
    let squares = |pulls: &[Vec<f64>], a: usize| {
        let sum: f64 = pulls.iter().map(|pull| pull[a] * pull[a]).sum();
        let n = pulls.len().max(2) as f64;
        (sum, n / (n - 1.0))
    };
    let error = |a: usize| {
        let unit = (0..n).map(|b| if a == b { 1.0 } else { 0.0 }).collect();
        let Some(column) = solve(matrix.clone(), unit) else {
            let none = free_parameters[a].prior_steps();
            return RawError { curvature: none, widened: 1.0, blocks: 0.0, runs: 0.0 };
        };
        let ((blocks, few), (runs, few_runs)) = (squares(&by_blocks, a), squares(&by_runs, a));
        RawError {
            curvature: column[a].max(0.0).sqrt(),
            widened,
            blocks: (few * blocks).sqrt(),
            // Runs are compared with their own mean, which takes a degree of freedom.
            runs: (runs / RUNS as f64 * few_runs).sqrt(),
        }
    };
    Ok((0..n).map(error).collect())
}

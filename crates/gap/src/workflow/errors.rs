//! Standard deviations of the numbers of an answer, before they are calibrated.
//!
//! # Method
//! Slopes of all numbers compared are differences of simulations with the same draws, weights those
//! of the robust distance. The standard deviation of a knob is the largest of three:
//! * from the curvature of the misfit, widened by what the model leaves unexplained;
//! * from what blocks of numbers pull, each in its direction: numbers of one block see the same
//!   events, and two simulators of one thing differ in all of them at once;
//! * from what fits to runs of the corrected model itself would scatter by.

use evpose_sensor::SensorConfig;
use serde::{Deserialize, Serialize};

use crate::fit::Slopes;
use crate::knob::Knob;
use crate::linear::solve;
use crate::{Block, GapError, Lab};

/// Runs of which slopes are taken.
const SLOPE_RUNS: u64 = 2;
/// Runs of the corrected model.
const RUNS: u64 = 6;

/// How uncertain a number is, in steps of its knob, from each of three sides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RawError {
    /// From the curvature of the misfit, without widening.
    pub curvature: f64,
    /// What the model leaves unexplained widens that by: a ratio of variances, at least one.
    pub widened: f64,
    /// From what blocks of numbers pull.
    pub blocks: f64,
    /// From what runs of the corrected model scatter by.
    pub runs: f64,
}

impl RawError {
    /// The largest, in steps.
    pub fn steps(&self) -> f64 {
        (self.curvature * self.widened.sqrt()).max(self.blocks).max(self.runs)
    }
}

/// Standard deviations of knobs around a model, in their steps.
pub(super) fn errors(
    lab: &Lab<'_>,
    model: &SensorConfig,
    knobs: &[Knob],
) -> Result<Vec<RawError>, GapError> {
    let slopes = Slopes::around(lab, model, knobs, SLOPE_RUNS)?;
    let expected = lab.expect(model, RUNS)?;
    let scales: Vec<f64> =
        (0..expected.mean.len()).map(|i| expected.scale(lab.layout, i)).collect();
    let z = expected.deviations(lab.layout, &lab.measured);
    let n = knobs.len();
    let weight = |i: usize| 1.0 / (1.0 + z[i] * z[i] / 4.0);
    let slope = |a: usize, i: usize| slopes.columns[a][i] / scales[i];
    let mut matrix = vec![vec![0.0; n]; n];
    for i in 0..z.len() {
        for (a, row) in matrix.iter_mut().enumerate() {
            for (b, cell) in row.iter_mut().enumerate() {
                *cell += weight(i) * slope(a, i) * slope(b, i);
            }
        }
    }
    for (a, knob) in knobs.iter().enumerate() {
        matrix[a][a] += 1.0 / knob.prior_steps().powi(2) + 1e-9;
    }
    // How far deviations of some of the numbers would pull each knob.
    let pulled = |z: &[f64], is_in: &dyn Fn(usize) -> bool| -> Vec<f64> {
        let pull = |a| {
            let numbers = (0..z.len()).filter(|i| is_in(*i));
            numbers.map(|i| weight(i) * slope(a, i) * z[i]).sum()
        };
        solve(matrix.clone(), (0..n).map(pull).collect()).unwrap_or_else(|| vec![0.0; n])
    };
    let mut blocks: Vec<Block> = lab.layout.entries.iter().map(|entry| entry.block).collect();
    blocks.dedup();
    let by_blocks: Vec<Vec<f64>> =
        blocks.iter().map(|block| pulled(&z, &|i| lab.layout.entries[i].block == *block)).collect();
    let by_runs = (0..RUNS)
        .map(|run| {
            let z = expected.deviations(lab.layout, &lab.run(model, run)?);
            Ok(pulled(&z, &|_| true))
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    let known = z.iter().filter(|z| **z != 0.0).count().max(1) as f64;
    let widened = (crate::misfit(&z) / known).max(1.0);
    let squares = |pulls: &[Vec<f64>], a: usize| {
        let sum: f64 = pulls.iter().map(|pull| pull[a] * pull[a]).sum();
        let n = pulls.len().max(2) as f64;
        (sum, n / (n - 1.0))
    };
    let error = |a: usize| {
        let unit = (0..n).map(|b| if a == b { 1.0 } else { 0.0 }).collect();
        let Some(column) = solve(matrix.clone(), unit) else {
            let none = knobs[a].prior_steps();
            return RawError { curvature: none, widened: 1.0, blocks: 0.0, runs: 0.0 };
        };
        let ((blocks, few), (runs, few_runs)) = (squares(&by_blocks, a), squares(&by_runs, a));
        RawError {
            curvature: column[a].max(0.0).sqrt(),
            widened,
            blocks: (few * blocks).sqrt(),
            // Runs are compared with their own mean; the recording is one run, fitted to the mean.
            runs: (runs / RUNS as f64 * few_runs).sqrt(),
        }
    };
    Ok((0..n).map(error).collect())
}

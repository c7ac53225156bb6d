//! What was named, with numbers and their intervals.
//!
//! # Method
//! Slopes of all numbers compared are differences of simulations with the same draws, weights those
//! of the robust distance. The variance of a parameter is the largest of three:
//! * from the curvature of the misfit, widened by what the model leaves unexplained;
//! * from what blocks of numbers pull, each in its direction: numbers of one block see the same
//!   events, and two simulators of one thing differ in all of them at once;
//! * from what fits to runs of the corrected model itself would scatter by.
//!
//! An interval of 90 % ends 1.645 standard deviations away, on the scale that each number is fitted
//! on.
//!
//! The probability of a name weighs all that was judged by the misfit on what was held out, at a
//! temper that allows for what the numbers share.

use std::collections::BTreeMap;

use evpose_sensor::{STAGES, SensorConfig};

use crate::fit::Slopes;
use crate::knob::Knob;
use crate::linear::solve;
use crate::naming::{Bench, Contender, Named, Step};
use crate::parameters::Parameter;
use crate::verdict::{Finding, FindingKind, Quantity};
use crate::{Block, GapError, Lab};

/// Standard deviations to either end of an interval of 90 %.
const SIDE: f64 = 1.645;
/// Runs of which slopes are taken.
const SLOPE_RUNS: u64 = 2;
/// Runs of the corrected model.
const RUNS: u64 = 6;
/// Numbers of a summary share what they see: this many misfits count as one.
const TEMPER: f64 = 10.0;

/// Effects and parameters of an answer, the effects first.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn findings(bench: &Bench<'_>, named: &Named) -> Result<Vec<Finding>, GapError> {
    let model = &named.after.model;
    let owned: Vec<Vec<Knob>> = named.steps.iter().map(|step| knobs(&step.contenders[0])).collect();
    let mut all: Vec<Knob> = owned.iter().flatten().copied().collect();
    all.extend(Parameter::ALL.map(Knob::Parameter));
    let errors = errors(&bench.train, model, &all)?;
    let quantity = |knob: Knob, error: f64| {
        let at = |sides: f64| knob.value(&knob.turned(model, sides * SIDE * error));
        let (value, a, b) = (knob.value(model), at(-1.0), at(1.0));
        let unit = match knob {
            Knob::Parameter(parameter) => parameter.unit(),
            Knob::Effect(_, param) => param.unit,
        };
        let (lo90, hi90) = (a.min(b).min(value), a.max(b).max(value));
        Quantity { value, lo90, hi90, unit: unit.into(), halves: None }
    };
    let mut found = Vec::new();
    let mut place = 0;
    for (step, knobs) in named.steps.iter().zip(&owned) {
        let mut parameters = BTreeMap::new();
        for knob in knobs {
            if let Knob::Effect(_, param) = knob {
                parameters.insert(param.name.to_owned(), quantity(*knob, errors[place]));
            }
            place += 1;
        }
        found.push(Finding {
            name: step.contenders[0].found.name.to_owned(),
            kind: FindingKind::Effect,
            parameters,
            probability: probability(step, bench.held.measured.len()),
            confusable_with: step.confusable.iter().map(|name| (*name).to_owned()).collect(),
        });
    }
    for parameter in &named.moved {
        let Some(i) = Parameter::ALL.iter().position(|other| other == parameter) else { continue };
        let error = errors[place + i];
        let from = parameter.value(&named.before.model);
        let z = parameter.steps(from, parameter.value(model)) / error.max(1e-9);
        let value = quantity(Knob::Parameter(*parameter), error);
        found.push(Finding {
            name: parameter.name().to_owned(),
            kind: FindingKind::Parameter,
            parameters: BTreeMap::from([(parameter.name().to_owned(), value)]),
            // That it differs at all.
            probability: 1.0 - (-0.5 * z * z).exp(),
            confusable_with: Vec::new(),
        });
    }
    Ok(found)
}

/// The knobs of an effect.
pub(super) fn knobs(contender: &Contender) -> Vec<Knob> {
    let name = STAGES.iter().find(|spec| spec.name == contender.found.name).map(|spec| spec.name);
    let knob = |name| contender.found.trial.params.iter().map(move |param| (name, *param));
    name.into_iter().flat_map(knob).map(|(name, param)| Knob::Effect(name, param)).collect()
}

/// How probable the best of a step is among all that were judged.
fn probability(step: &Step, numbers: usize) -> f64 {
    let best = &step.contenders[0].held;
    let temper = TEMPER * (best.misfit / numbers.max(1) as f64).max(1.0);
    let others = step.contenders.iter().skip(1);
    let weights = others.map(|other| (-(other.held.misfit - best.misfit) / (2.0 * temper)).exp());
    1.0 / (1.0 + weights.sum::<f64>())
}

/// Standard deviations of knobs around a model, in their steps.
fn errors(lab: &Lab<'_>, model: &SensorConfig, knobs: &[Knob]) -> Result<Vec<f64>, GapError> {
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
        let Some(column) = solve(matrix.clone(), unit) else { return knobs[a].prior_steps() };
        let ((blocks, few), (runs, few_runs)) = (squares(&by_blocks, a), squares(&by_runs, a));
        // Runs are compared with their own mean; the recording is one run, fitted to the mean.
        let runs = runs / RUNS as f64 * few_runs;
        (column[a].max(0.0) * widened).max(few * blocks).max(runs).sqrt()
    };
    Ok((0..n).map(error).collect())
}

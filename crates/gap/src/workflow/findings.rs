//! What was named, with numbers and their intervals.
//!
//! # Method
//! Covariance of the numbers of the corrected model from the curvature of the misfit: slopes are
//! differences of simulations with the same draws, weights those of the robust distance, and what
//! the model leaves unexplained widens it. An interval of 90 % ends 1.645 standard deviations away,
//! on the scale that each number is fitted on.
//!
//! The probability of a name weighs all that was judged by the misfit on what was held out, at a
//! temper that allows for what the numbers share.

use std::collections::BTreeMap;

use evpose_sensor::STAGES;

use crate::fit::Slopes;
use crate::knob::Knob;
use crate::linear::solve;
use crate::naming::{Bench, Contender, Named, Step};
use crate::parameters::Parameter;
use crate::search::parameter_knobs;
use crate::verdict::{Finding, FindingKind, Quantity};
use crate::{GapError, Lab};

/// Standard deviations to either end of an interval of 90 %.
const SIDE: f64 = 1.645;
/// Runs of which slopes are taken.
const RUNS: u64 = 2;
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
    all.extend(parameter_knobs());
    let errors = errors(&bench.train, model, &all)?;
    let quantity = |knob: Knob, error: f64| {
        let at = |sides: f64| knob.value(&knob.turned(model, sides * SIDE * error));
        let (value, a, b) = (knob.value(model), at(-1.0), at(1.0));
        let unit = match knob {
            Knob::Parameter(parameter) => parameter.unit(),
            Knob::Effect(_, param) => param.unit,
        };
        Quantity { value, lo90: a.min(b).min(value), hi90: a.max(b).max(value), unit: unit.into() }
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
fn errors(
    lab: &Lab<'_>,
    model: &evpose_sensor::SensorConfig,
    knobs: &[Knob],
) -> Result<Vec<f64>, GapError> {
    let slopes = Slopes::around(lab, model, knobs, RUNS)?;
    let expected = lab.expect(model, RUNS)?;
    let z = expected.deviations(lab.layout, &lab.measured);
    let n = knobs.len();
    let mut matrix = vec![vec![0.0; n]; n];
    for (i, z) in z.iter().enumerate() {
        let weight = 1.0 / (1.0 + z * z / 4.0) / expected.scale(lab.layout, i).powi(2);
        for a in 0..n {
            for b in 0..n {
                matrix[a][b] += weight * slopes.columns[a][i] * slopes.columns[b][i];
            }
        }
    }
    for (a, knob) in knobs.iter().enumerate() {
        matrix[a][a] += 1.0 / knob.prior_steps().powi(2) + 1e-9;
    }
    let known = z.iter().filter(|z| **z != 0.0).count().max(1) as f64;
    let widened = (crate::misfit(&z) / known).max(1.0);
    let error = |a: usize| {
        let unit = (0..n).map(|b| if a == b { 1.0 } else { 0.0 }).collect();
        let column = solve(matrix.clone(), unit);
        column.map_or(knobs[a].prior_steps(), |column| (column[a].max(0.0) * widened).sqrt())
    };
    Ok((0..n).map(error).collect())
}

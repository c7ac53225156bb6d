//! Every effect of the catalogue tried on a recording.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use crate::candidate::{Candidate, Trial};
use crate::compare::misfit;
use crate::fit::{Fit, Slopes, descend, misfit_of};
use crate::hint;
use crate::knob::Knob;
use crate::parameters::Parameter;
use crate::{GapError, Lab};

/// Candidates that are fitted with all their numbers.
const FINALISTS: usize = 8;
/// Rounds of the fit of all numbers.
const ROUNDS: usize = 4;

/// A candidate fitted to the recording.
#[derive(Debug, Clone)]
pub struct Found {
    /// The name in the catalogue.
    pub name: &'static str,
    /// The model with the effect.
    pub fit: Fit,
    /// The numbers of the effect that were fitted.
    pub trial: Trial,
}

/// The numbers that every fit may turn.
pub fn parameter_knobs() -> Vec<Knob> {
    Parameter::ALL.iter().map(|parameter| Knob::Parameter(*parameter)).collect()
}

/// Refits the numbers that a model has anyway.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn refit(lab: &Lab<'_>, model: &SensorConfig, runs: u64) -> Result<Fit, GapError> {
    descend(lab, model, &parameter_knobs(), runs, ROUNDS)
}

/// All candidates beside `model`, the best first; those that were not fitted in full come last.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn search(
    lab: &Lab<'_>,
    model: &SensorConfig,
    left_out: &[String],
) -> Result<Vec<Found>, GapError> {
    let knobs = parameter_knobs();
    let slopes = Slopes::around(lab, model, &knobs, 1)?;
    let trials: Vec<(Candidate, Trial)> = Candidate::beside(model, left_out)
        .into_iter()
        .flat_map(|candidate| candidate.trials().into_iter().map(move |trial| (candidate, trial)))
        .collect();
    let tries: Vec<(usize, Trial)> = trials
        .iter()
        .enumerate()
        .flat_map(|(i, (candidate, trial))| {
            let hinted = hint::of(lab, candidate.name(), trial);
            hinted.into_iter().flat_map(move |trial| {
                let strengths = trial.strengths();
                let head = trial.params[0];
                strengths.into_iter().map(move |value| (i, trial.with(head, value)))
            })
        })
        .collect();
    let scored = tries
        .par_iter()
        .map(|(i, trial)| {
            let with = trial.beside(model);
            let expected = lab.expect(&with, 1)?;
            let deviations = expected.deviations(lab.layout, &lab.measured);
            let (_, left) = slopes.best(lab, &expected, &deviations, &knobs);
            Ok((*i, trial, left))
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    // The best try of every candidate.
    let mut best: Vec<(&'static str, &Trial, f64)> = Vec::new();
    for (i, trial, left) in &scored {
        let name = trials[*i].0.name();
        match best.iter_mut().find(|(other, ..)| *other == name) {
            Some(known) if known.2 <= *left => {}
            Some(known) => *known = (name, *trial, *left),
            None => best.push((name, *trial, *left)),
        }
    }
    best.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut found = best
        .par_iter()
        .enumerate()
        .map(|(rank, (name, trial, left))| {
            let fit = if rank < FINALISTS {
                polish(lab, model, trial)?
            } else {
                Fit { model: trial.beside(model), misfit: *left }
            };
            Ok(Found { name, fit, trial: (*trial).clone() })
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    let rest = found.split_off(FINALISTS.min(found.len()));
    found.sort_by(|a, b| a.fit.misfit.total_cmp(&b.fit.misfit));
    found.extend(rest);
    Ok(found)
}

/// Fits all numbers of an effect and of the model.
fn polish(lab: &Lab<'_>, model: &SensorConfig, trial: &Trial) -> Result<Fit, GapError> {
    let name = trial.effect.name.as_str();
    let own = trial.params.iter().map(|param| {
        let spec = evpose_sensor::STAGES.iter().find(|spec| spec.name == name);
        Knob::Effect(spec.map_or("", |spec| spec.name), param)
    });
    let own: Vec<Knob> = own.collect();
    let mut start = trial.beside(model);
    // Along the strength first: half and quarter steps of the grid.
    let mut least = misfit_of(lab, &start, 1)?;
    for steps in [6.0, 3.0, 1.5] {
        let tried = [-1.0, 1.0]
            .par_iter()
            .map(|sign| {
                let turned = own[0].turned(&start, sign * steps);
                Ok((misfit_of(lab, &turned, 1)?, turned))
            })
            .collect::<Result<Vec<_>, GapError>>()?;
        for (value, turned) in tried {
            if value < least {
                least = value;
                start = turned;
            }
        }
    }
    let all: Vec<Knob> = own.into_iter().chain(parameter_knobs()).collect();
    descend(lab, &start, &all, 2, ROUNDS)
}

/// Sum of deviations of a model.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn judged(lab: &Lab<'_>, model: &SensorConfig, runs: u64) -> Result<(f64, f64), GapError> {
    let expected = lab.expect(model, runs)?;
    let deviations = expected.deviations(lab.layout, &lab.measured);
    Ok((misfit(&deviations), crate::gap(lab.layout, &deviations)))
}

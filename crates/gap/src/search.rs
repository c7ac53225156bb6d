//! Every effect of the catalogue tried on a recording.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use crate::candidate::{Candidate, Trial};
use crate::compare::misfit;
use crate::fit::{Fit, Slopes, descend};
use crate::hint;
use crate::knob::Knob;
use crate::parameters::Parameter;
use crate::{GapError, Lab};

/// Candidates whose strength is fitted.
const NEAR: usize = 8;
/// Candidates that are fitted with all their numbers.
const FINALISTS: usize = 3;
/// Steps that numbers of the model are believed to follow in a line.
const NEARBY: f64 = 2.0;
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
/// They are first tried on `screen`, a short part of the recording.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn search(
    screen: &Lab<'_>,
    lab: &Lab<'_>,
    model: &SensorConfig,
    left_out: &[String],
) -> Result<Vec<Found>, GapError> {
    let knobs = parameter_knobs();
    let slopes = Slopes::around(screen, model, &knobs, 1)?;
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
                let mut strengths = trial.strengths();
                strengths.extend(trial.value(trial.params[0]));
                let head = trial.params[0];
                strengths.into_iter().map(move |value| (i, trial.with(head, value)))
            })
        })
        .collect();
    let without = screen.run(model, 0)?;
    let scored = tries
        .par_iter()
        .map(|(i, trial)| {
            let with = trial.beside(model);
            let expected = screen.expect(&with, 1)?;
            let deviations = expected.deviations(screen.layout, &screen.measured);
            let (_, left) = slopes.best(NEARBY, screen, &expected, &deviations, &knobs);
            // What changes nothing is no explanation.
            let is_without = expected.mean.iter().zip(&*without).all(|(a, b)| a == b);
            Ok((*i, trial, if is_without { f64::INFINITY } else { left }))
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
    if std::env::var("DBG").is_ok() {
        for (n, t, q) in &best {
            eprintln!("  screen {n} {q:.0} {:?}", t.effect.params);
        }
    }
    let near = NEAR.min(best.len());
    let slopes = Slopes::around(lab, model, &knobs, 1)?;
    let mut lined = best[..near]
        .par_iter()
        .map(|(name, trial, left)| {
            let (model, left) = line(lab, model, trial, &slopes)?;
            Ok(Found { name, fit: Fit { model, misfit: left }, trial: (*trial).clone() })
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    lined.sort_by(|a, b| a.fit.misfit.total_cmp(&b.fit.misfit));
    let mut found = Vec::new();
    for (rank, mut one) in lined.into_iter().enumerate() {
        if rank < FINALISTS {
            let all: Vec<Knob> = own(&one.trial).into_iter().chain(parameter_knobs()).collect();
            one.fit = descend(lab, &one.fit.model, &all, 1, ROUNDS)?;
        }
        found.push(one);
    }
    let rest = best[near..].iter().map(|(name, trial, left)| Found {
        name,
        fit: Fit { model: trial.beside(model), misfit: *left },
        trial: (*trial).clone(),
    });
    found.sort_by(|a, b| a.fit.misfit.total_cmp(&b.fit.misfit));
    found.extend(rest);
    Ok(found)
}

/// The knobs of an effect.
fn own(trial: &Trial) -> Vec<Knob> {
    let spec = evpose_sensor::STAGES.iter().find(|spec| spec.name == trial.effect.name);
    let name = spec.map_or("", |spec| spec.name);
    trial.params.iter().map(|param| Knob::Effect(name, param)).collect()
}

/// Finds the strength of an effect between the values it was first tried at, the numbers of the
/// model following in a line.
fn line(
    lab: &Lab<'_>,
    model: &SensorConfig,
    trial: &Trial,
    slopes: &Slopes,
) -> Result<(SensorConfig, f64), GapError> {
    let head = own(trial)[0];
    let knobs = parameter_knobs();
    let profiled = |model: &SensorConfig| -> Result<f64, GapError> {
        let expected = lab.expect(model, 1)?;
        let deviations = expected.deviations(lab.layout, &lab.measured);
        Ok(slopes.best(NEARBY, lab, &expected, &deviations, &knobs).1)
    };
    let mut at = trial.beside(model);
    let mut least = profiled(&at)?;
    for steps in [5.0, 2.5, 1.2] {
        for sign in [-1.0, 1.0] {
            let turned = head.turned(&at, sign * steps);
            let left = profiled(&turned)?;
            if left < least {
                (at, least) = (turned, left);
                break;
            }
        }
    }
    Ok((at, least))
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

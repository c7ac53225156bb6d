//! Every effect of the catalogue tried on a recording.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use crate::candidate::{Candidate, Trial};
use crate::compare::misfit;
use crate::fit::{Fit, Slopes, descend, misfit_of};
use crate::guess;
use crate::hint;
use crate::knob::Knob;
use crate::parameters::Parameter;
use crate::{GapError, Lab};

/// Ways to look for candidates that are tried at more strengths.
const FINER: usize = 14;
/// Ways to look for one candidate that are followed: a short part of a recording does not tell
/// those apart that differ from pixel to pixel only.
const WAYS: usize = 3;
/// Ways whose strength is fitted.
const NEAR: usize = 10;
/// Candidates that are fitted with all their numbers.
const FINALISTS: usize = 4;
/// Steps that numbers of the model are believed to follow in a line.
const NEARBY: f64 = 2.0;
/// A lag longer than this is more likely the clock's than the pixels', microseconds.
const LONGEST_LATENCY_US: f64 = 900.0;
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

/// The numbers that every fit may turn. The offset of the clock is not among them: beside an
/// effect it would take the place of a latency.
pub fn parameter_knobs() -> Vec<Knob> {
    let is_free = |parameter: &&Parameter| **parameter != Parameter::ClockOffset;
    Parameter::ALL.iter().filter(is_free).map(|parameter| Knob::Parameter(*parameter)).collect()
}

/// Refits the numbers that a model has anyway.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn refit(lab: &Lab<'_>, model: &SensorConfig, runs: u64) -> Result<Fit, GapError> {
    let mut knobs = parameter_knobs();
    knobs.push(Knob::Parameter(Parameter::ClockOffset));
    let mut starts = guess::starts(lab, model)?;
    starts.push(model.clone());
    let fits = starts
        .par_iter()
        .map(|start| Ok(Fit { misfit: misfit_of(lab, start, runs)?, model: start.clone() }))
        .collect::<Result<Vec<_>, GapError>>()?;
    let best = fits.into_iter().min_by(|a, b| a.misfit.total_cmp(&b.misfit));
    let Some(mut best) = best else { return descend(lab, model, &knobs, None, runs, ROUNDS) };
    // One number after the other, then all together.
    for steps in [3.0, 1.0] {
        for knob in &knobs {
            for sign in [-1.0, 1.0] {
                let turned = knob.turned(&best.model, sign * steps);
                let misfit = misfit_of(lab, &turned, runs)?;
                if misfit < best.misfit {
                    best = Fit { model: turned, misfit };
                    break;
                }
            }
        }
    }
    let mut fit = descend(lab, &best.model, &knobs, None, runs, ROUNDS)?;
    // A short lag is what pixels have; a clock can be off by anything.
    let offset_us = Parameter::ClockOffset.value(&fit.model);
    let given_us = Parameter::ClockOffset.value(model);
    if offset_us > given_us && offset_us - given_us < LONGEST_LATENCY_US {
        Parameter::ClockOffset.set(&mut fit.model, given_us);
        fit.misfit = misfit_of(lab, &fit.model, runs)?;
    }
    Ok(fit)
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
    let best = screened(screen, lab, model, left_out, &slopes)?;
    let near = NEAR.min(best.len());
    let slopes = Slopes::around(lab, model, &knobs, 1)?;
    let mut lined = best[..near]
        .par_iter()
        .map(|(name, trial, _)| {
            let (model, left) = line(lab, model, trial, &slopes)?;
            Ok(Found { name, fit: Fit { model, misfit: left }, trial: trial.clone() })
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    lined.sort_by(|a, b| a.fit.misfit.total_cmp(&b.fit.misfit));
    let mut found = Vec::new();
    for (rank, mut one) in lined.into_iter().enumerate() {
        if rank < FINALISTS {
            let beside = Some((knobs.as_slice(), &slopes));
            one.fit = descend(lab, &one.fit.model, &own(&one.trial), beside, 1, ROUNDS)?;
        }
        found.push(one);
    }
    let rest = best[near..].iter().map(|(name, trial, left)| Found {
        name,
        fit: Fit { model: trial.beside(model), misfit: *left },
        trial: trial.clone(),
    });
    found.sort_by(|a, b| a.fit.misfit.total_cmp(&b.fit.misfit));
    found.extend(rest);
    Ok(found)
}

/// Every candidate at the best of a row of strengths, the best first.
fn screened(
    screen: &Lab<'_>,
    lab: &Lab<'_>,
    model: &SensorConfig,
    left_out: &[String],
    slopes: &Slopes,
) -> Result<Vec<(&'static str, Trial, f64)>, GapError> {
    let knobs = parameter_knobs();
    let without = screen.run(model, 0)?;
    let score = |trial: &Trial| -> Result<f64, GapError> {
        let expected = screen.expect(&trial.beside(model), 1)?;
        // What changes nothing is no explanation.
        if expected.mean.iter().zip(&*without).all(|(a, b)| a == b) {
            return Ok(f64::INFINITY);
        }
        let deviations = expected.deviations(screen.layout, &screen.measured);
        Ok(slopes.best(NEARBY, screen, &expected, &deviations, &knobs).1)
    };
    let ways: Vec<(&'static str, Trial)> = Candidate::beside(model, left_out)
        .into_iter()
        .flat_map(|candidate| {
            let trials = candidate.trials().into_iter();
            trials.flat_map(move |trial| {
                hint::of(lab, candidate.name(), &trial)
                    .into_iter()
                    .map(move |t| (candidate.name(), t))
            })
        })
        .collect();
    // Every other strength, then those between for what looks best.
    let mut best = ways
        .par_iter()
        .map(|(name, trial)| {
            let head = trial.params[0];
            let strengths = trial.strengths();
            let coarse = strengths.iter().copied().enumerate().step_by(2);
            let read = trial.value(head).into_iter().map(|value| (usize::MAX, value));
            let mut best = (0, trial.clone(), f64::INFINITY);
            for (i, value) in coarse.chain(read) {
                let tried = trial.with(head, value);
                let left = score(&tried)?;
                if left < best.2 {
                    best = (i, tried, left);
                }
            }
            Ok((*name, best))
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    best.sort_by(|a, b| a.1.2.total_cmp(&b.1.2));
    let finer = best.len().min(FINER);
    best[..finer].par_iter_mut().try_for_each(|(_, best)| {
        let strengths = best.1.strengths();
        let head = best.1.params[0];
        for i in [best.0.wrapping_sub(1), best.0.wrapping_add(1)] {
            if let Some(value) = strengths.get(i) {
                let tried = best.1.with(head, *value);
                let left = score(&tried)?;
                if left < best.2 {
                    *best = (i, tried, left);
                }
            }
        }
        Ok::<(), GapError>(())
    })?;
    best.sort_by(|a, b| a.1.2.total_cmp(&b.1.2));
    let mut names = Vec::new();
    best.retain(|(name, _)| {
        let ways = names.iter().filter(|other| *other == name).count();
        names.push(*name);
        ways < WAYS
    });
    Ok(best.into_iter().map(|(name, (_, trial, left))| (name, trial, left)).collect())
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

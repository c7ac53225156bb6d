//! Every effect of the catalogue tried on a recording.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use crate::candidate::Trial;
use crate::compare::misfit;
use crate::finish::kept;
use crate::fit::{Fit, Slopes, descend, misfit_of};
use crate::guess;
use crate::hint::Hints;
use crate::knob::Knob;
use crate::parameters::Parameter;
use crate::screen::{Screening, Way, screened};
use crate::{GapError, Lab};

/// What the best way has to gain on the screen for anything to be followed.
const PROMISE: f64 = 6.0;
/// Beside the numbers as given, it may leave so many times what the refitted ones leave.
const NEARLY: f64 = 1.5;
/// Ways whose strength is fitted.
const NEAR: usize = 8;
/// Candidates that are fitted with all their numbers.
const FINALISTS: usize = 4;
/// Candidates whose misfit is so many times that of the best are not fitted with all their numbers.
const BEHIND: f64 = 5.0;
/// Those of them whose fits are finished, and how much worse than the best they may be before.
const FINISHED: usize = 4;
const NOT_FAR: f64 = 2.5;
/// Steps that numbers of the model are believed to follow in a line.
pub(crate) const NEARBY: f64 = 2.0;
/// A lag longer than this is more likely the clock's than the pixels', microseconds: nothing in a
/// recording tells the two apart, and numbers of the model come before effects.
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
    // What does not help stays as it was given; what is left is fitted once more.
    let kept = kept(lab, model, &mut fit, &knobs)?;
    if !kept.is_empty() && kept.len() < knobs.len() {
        fit = descend(lab, &fit.model, &kept, None, runs, ROUNDS)?;
    }
    // A short lag is what pixels have; a clock can be off by anything.
    let offset_us = Parameter::ClockOffset.value(&fit.model);
    let given_us = Parameter::ClockOffset.value(model);
    if offset_us > given_us && offset_us - given_us < LONGEST_LATENCY_US {
        Parameter::ClockOffset.set(&mut fit.model, given_us);
        fit.misfit = misfit_of(lab, &fit.model, runs)?;
    }
    Ok(fit)
}

/// All candidates beside each of `starts`, which differ from the model as `given` by their numbers
/// and what was found before, the best first; those that were not fitted in full come
/// last. They are first tried on `screen`, a short part of the recording; nothing is followed if
/// nothing helps there.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn search(
    screen: &Lab<'_>,
    lab: &Lab<'_>,
    given: &SensorConfig,
    starts: &[SensorConfig],
    hints: &Hints,
    left_out: &[String],
) -> Result<Vec<Found>, GapError> {
    let knobs = parameter_knobs();
    let (mut screening, mut least) = (Vec::new(), f64::INFINITY);
    for model in starts {
        let on_screen = Screening::new(screen, hints, model)?;
        least = least.min(on_screen.least);
        screening.push(on_screen);
    }
    let best = screened(&screening, left_out)?;
    // A few strengths without a fit may not reach what refitted numbers have taken on themselves.
    let is_promising = |way: &Way| {
        way.left < least - PROMISE
            || (way.start > 0
                && way.left < NEARLY * least
                && way.left < screening[way.start].least - PROMISE)
    };
    if !best.iter().any(is_promising) {
        return Ok(Vec::new());
    }
    // The best beside each model: those beside a better one look better, whatever they are.
    let mut found: Vec<Found> = Vec::new();
    let mut rest = Vec::new();
    for (start, model) in starts.iter().enumerate() {
        if !best.iter().any(|way| way.start == start && is_promising(way)) {
            continue;
        }
        let mut ways = best.iter().filter(|way| way.start == start);
        let near: Vec<&Way> = ways.by_ref().take(NEAR).collect();
        rest.extend(ways);
        let slopes = Slopes::around(lab, model, &knobs, 1)?;
        let least = found.iter().map(|one| one.fit.misfit).fold(f64::INFINITY, f64::min);
        found.extend(fitted(lab, model, &near, &slopes, least)?);
    }
    let by_misfit = |a: &Found, b: &Found| a.fit.misfit.total_cmp(&b.fit.misfit);
    found.sort_by(by_misfit);
    let least = found.first().map_or(0.0, |one| one.fit.misfit);
    let near = found.iter().take(FINISHED).take_while(|one| one.fit.misfit < NOT_FAR * least);
    let near = near.count();
    found[..near].par_iter_mut().try_for_each(|one| {
        one.grow(lab, given)?;
        one.finish(lab, given)
    })?;
    found.sort_by(by_misfit);
    if let Some(best) = found.first_mut() {
        best.refine(lab)?;
    }
    rest.sort_by(|a, b| a.left.total_cmp(&b.left));
    found.extend(rest.into_iter().map(|way| Found {
        name: way.name,
        fit: Fit { model: way.trial.beside(&starts[way.start]), misfit: way.left },
        trial: way.trial.clone(),
    }));
    Ok(found)
}

/// Ways beside one model with their strengths fitted, the best also with all numbers; `least` is
/// the smallest misfit so far.
fn fitted(
    lab: &Lab<'_>,
    model: &SensorConfig,
    ways: &[&Way],
    slopes: &Slopes,
    mut least: f64,
) -> Result<Vec<Found>, GapError> {
    let knobs = parameter_knobs();
    let mut lined = ways
        .par_iter()
        .map(|way| {
            let (model, misfit) = line(lab, model, &way.trial, slopes)?;
            let fit = Fit { model, misfit };
            Ok(Found { name: way.name, fit, trial: way.trial.clone() })
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    lined.sort_by(|a, b| a.fit.misfit.total_cmp(&b.fit.misfit));
    let finalists = lined.len().min(FINALISTS);
    // Two at a time; the rest only where they are not far behind.
    for few in lined[..finalists].chunks_mut(2) {
        few.par_iter_mut().filter(|one| one.fit.misfit < BEHIND * least).try_for_each(|one| {
            let beside = Some((knobs.as_slice(), slopes));
            one.fit = descend(lab, &one.fit.model, &own(&one.trial), beside, 1, ROUNDS)?;
            Ok::<(), GapError>(())
        })?;
        least = few.iter().map(|one| one.fit.misfit).fold(least, f64::min);
    }
    Ok(lined)
}

/// The knobs of an effect.
pub(crate) fn own(trial: &Trial) -> Vec<Knob> {
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

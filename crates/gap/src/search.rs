//! Every effect of the catalogue tried on a recording.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use crate::candidate::{Candidate, Trial};
use crate::compare::{Expectation, misfit};
use crate::fit::{Fit, Slopes, descend, misfit_of};
use crate::guess;
use crate::hint::Hints;
use crate::knob::Knob;
use crate::parameters::Parameter;
use crate::{GapError, Lab};

/// Ways to look for candidates that are tried at more strengths.
const FINER: usize = 14;
/// Ways that are tried in their less plain forms too.
const RICHER: usize = 10;
/// What the best way has to gain on the screen for anything to be followed.
const PROMISE: f64 = 6.0;
/// Ways to look for one candidate beside one model that are followed: a short part of a recording does not tell
/// those apart that differ from pixel to pixel only.
const WAYS: usize = 3;
/// Ways whose strength is fitted.
const NEAR: usize = 8;
/// Candidates that are fitted with all their numbers.
const FINALISTS: usize = 4;
/// Candidates whose misfit is so many times that of the best are not fitted with all their numbers.
const BEHIND: f64 = 5.0;
/// Steps that numbers of the model are believed to follow in a line.
const NEARBY: f64 = 2.0;
/// A lag longer than this is more likely the clock's than the pixels', microseconds.
const LONGEST_LATENCY_US: f64 = 2_500.0;
/// A number without which the misfit is hardly larger was right before.
const LEAST_LOSS: f64 = 8.0;
/// A number that moves by less than this many steps does not matter.
const LEAST_STEPS: f64 = 0.6;
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
    let mut kept = Vec::new();
    for knob in &knobs {
        let Knob::Parameter(parameter) = knob else { continue };
        let mut without = fit.model.clone();
        parameter.set(&mut without, parameter.value(model));
        let misfit = misfit_of(lab, &without, runs)?;
        let steps = parameter.steps(parameter.value(model), parameter.value(&fit.model)).abs();
        if misfit < fit.misfit + LEAST_LOSS || steps < LEAST_STEPS {
            fit = Fit { model: without, misfit };
        } else {
            kept.push(*knob);
        }
    }
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

/// One way of looking for an effect beside one of the models to begin with.
#[derive(Debug, Clone)]
struct Way {
    name: &'static str,
    start: usize,
    trial: Trial,
    /// What the screen leaves of the misfit.
    left: f64,
}

/// All candidates beside each of `starts`, the best first; those that were not fitted in full come
/// last. They are first tried on `screen`, a short part of the recording; nothing is followed if
/// nothing helps there.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn search(
    screen: &Lab<'_>,
    lab: &Lab<'_>,
    starts: &[SensorConfig],
    hints: &Hints,
    left_out: &[String],
) -> Result<Vec<Found>, GapError> {
    let knobs = parameter_knobs();
    let mut screening = Vec::new();
    for model in starts {
        let slopes = Slopes::around(screen, model, &knobs, 1)?;
        screening.push(Screening { screen, hints, model, without: screen.run(model, 0)?, slopes });
    }
    let mut least = f64::INFINITY;
    for screening in &screening {
        least = least.min(screening.left(&screen.expect(screening.model, 1)?));
    }
    let best = screened(&screening, left_out)?;
    if best.first().is_none_or(|way| way.left > least - PROMISE) {
        return Ok(Vec::new());
    }
    // The best beside each model: those beside a better one look better, whatever they are.
    let mut found: Vec<Found> = Vec::new();
    let mut rest = Vec::new();
    for (start, model) in starts.iter().enumerate() {
        let mut ways = best.iter().filter(|way| way.start == start);
        let near: Vec<&Way> = ways.by_ref().take(NEAR).collect();
        rest.extend(ways);
        let slopes = Slopes::around(lab, model, &knobs, 1)?;
        let least = found.iter().map(|one| one.fit.misfit).fold(f64::INFINITY, f64::min);
        found.extend(fitted(lab, model, &near, &slopes, least)?);
    }
    found.sort_by(|a, b| a.fit.misfit.total_cmp(&b.fit.misfit));
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

/// A model on the screen, to which effects are added.
struct Screening<'a> {
    screen: &'a Lab<'a>,
    hints: &'a Hints,
    model: &'a SensorConfig,
    without: std::sync::Arc<Vec<f64>>,
    slopes: Slopes,
}

impl Screening<'_> {
    /// The misfit of an expectation, the numbers of the model following in a line.
    fn left(&self, expected: &Expectation) -> f64 {
        let deviations = expected.deviations(self.screen.layout, &self.screen.measured);
        self.slopes.best(NEARBY, self.screen, expected, &deviations, &parameter_knobs()).1
    }

    fn score(&self, trial: &Trial) -> Result<f64, GapError> {
        let expected = self.screen.expect(&trial.beside(self.model), 1)?;
        // What changes nothing is no explanation.
        let is_idle = expected.mean.iter().zip(&*self.without).all(|(a, b)| a == b);
        Ok(if is_idle { f64::INFINITY } else { self.left(&expected) })
    }

    /// The best of some strengths.
    fn best_of(&self, way: &Way, strengths: &[f64]) -> Result<Way, GapError> {
        let head = way.trial.params[0];
        let mut best = way.clone();
        for value in strengths {
            let trial = way.trial.with(head, *value);
            let left = self.score(&trial)?;
            if left < best.left {
                best = Way { trial, left, ..best };
            }
        }
        Ok(best)
    }

    /// The plainest way of each form of each candidate.
    fn ways(&self, start: usize, left_out: &[String]) -> Vec<Way> {
        let hinted = |candidate: Candidate| {
            let trials = candidate.trials().into_iter().flat_map(|form| form.into_iter().take(1));
            trials
                .map(|trial| self.hints.applied(candidate.name(), &trial))
                .map(move |trial| Way { name: candidate.name(), start, trial, left: f64::INFINITY })
                .collect::<Vec<_>>()
        };
        Candidate::beside(self.model, left_out).into_iter().flat_map(hinted).collect()
    }

    /// The ways of a candidate that are less plain than `way`, at its strength.
    fn richer(&self, way: &Way, left_out: &[String]) -> Vec<Way> {
        let head = way.trial.params[0];
        let value = way.trial.value(head);
        let candidate =
            Candidate::beside(self.model, left_out).into_iter().find(|c| c.name() == way.name);
        let forms = candidate.into_iter().flat_map(Candidate::trials);
        forms
            .filter(|form| form[0].params[0].name == head.name && form[0].is_form_of(&way.trial))
            .flat_map(|form| form.into_iter().skip(1))
            .map(|trial| self.hints.applied(way.name, &trial))
            .map(|trial| Way {
                trial: value.map_or(trial.clone(), |value| trial.with(head, value)),
                left: f64::INFINITY,
                ..way.clone()
            })
            .collect()
    }
}

/// Every candidate at the best of a row of strengths, the best first.
fn screened(screening: &[Screening<'_>], left_out: &[String]) -> Result<Vec<Way>, GapError> {
    let ways: Vec<Way> = screening
        .iter()
        .enumerate()
        .flat_map(|(start, screening)| screening.ways(start, left_out))
        .collect();
    // Every other strength, then those between for what looks best.
    let mut best = ways
        .par_iter()
        .map(|way| {
            let read = way.trial.value(way.trial.params[0]);
            let coarse = way.trial.strengths().into_iter().step_by(2);
            screening[way.start].best_of(way, &coarse.chain(read).collect::<Vec<_>>())
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    best.sort_by(|a, b| a.left.total_cmp(&b.left));
    let finer = best.len().min(FINER);
    best[..finer].par_iter_mut().try_for_each(|way| {
        let value = way.trial.value(way.trial.params[0]);
        let strengths = way.trial.strengths();
        let at = strengths.iter().position(|strength| Some(*strength) == value);
        let beside = at.into_iter().flat_map(|i| [i.checked_sub(1), Some(i + 1)]);
        let beside = beside.flatten().filter_map(|i| strengths.get(i).copied());
        *way = screening[way.start].best_of(way, &beside.collect::<Vec<_>>())?;
        Ok::<(), GapError>(())
    })?;
    let richer: Vec<Way> = best[..best.len().min(RICHER)]
        .iter()
        .flat_map(|way| screening[way.start].richer(way, left_out))
        .collect();
    let richer = richer
        .par_iter()
        .map(|way| {
            let head = way.trial.params[0];
            let value = way.trial.value(head).unwrap_or(0.0);
            let strengths = way.trial.strengths();
            let near = |factor: f64| {
                let wanted = value * factor;
                let distance = |s: &&f64| (*s / wanted).ln().abs();
                strengths.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).copied()
            };
            let tried: Vec<f64> =
                [Some(value), near(0.6), near(1.7)].into_iter().flatten().collect();
            screening[way.start].best_of(way, &tried)
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    best.extend(richer);
    best.sort_by(|a, b| a.left.total_cmp(&b.left));
    let mut names = Vec::new();
    best.retain(|way| {
        let way_of = (way.name, way.start);
        let ways = names.iter().filter(|other| **other == way_of).count();
        names.push(way_of);
        ways < WAYS && way.left.is_finite()
    });
    Ok(best)
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

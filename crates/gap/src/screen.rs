//! First tries: every effect in its plainest form at a row of strengths, on a short part of a
//! recording.

use evpose_sensor::{Domain, SensorConfig};
use rayon::prelude::*;

use crate::candidate::{Candidate, Trial};
use crate::compare::Expectation;
use crate::fit::Slopes;
use crate::hint::Hints;
use crate::search::{NEARBY, parameter_knobs};
use crate::{GapError, Lab};

/// Ways to look for candidates that are tried at more strengths, beside each model.
const FINER: usize = 10;
/// Ways that are tried in their less plain forms too, beside each model.
const RICHER: usize = 8;
/// Stronger than what makes the misfit so many times as large is not tried.
const TOO_STRONG: f64 = 4.0;
/// Ways to look for one candidate beside one model that are followed: a short part of a recording
/// does not tell those apart that differ from pixel to pixel only.
const WAYS: usize = 3;

/// Effects that do nothing until they are strong enough, and then much: what is best on a short part
/// need not lead to the best fit.
const SUDDEN: &[&str] = &["lamp_flicker"];

/// One way of looking for an effect beside one of the models to begin with.
#[derive(Debug, Clone)]
pub(crate) struct Way {
    /// The name in the catalogue.
    pub(crate) name: &'static str,
    /// What it is done to.
    domain: Domain,
    /// Which of the models.
    pub(crate) start: usize,
    /// With its strength.
    pub(crate) trial: Trial,
    /// What the screen leaves of the misfit.
    pub(crate) left: f64,
}

/// A model on the screen, to which effects are added.
pub(crate) struct Screening<'a> {
    screen: &'a Lab<'a>,
    hints: &'a Hints,
    model: &'a SensorConfig,
    without: std::sync::Arc<Vec<f64>>,
    slopes: Slopes,
    /// What is left without any effect.
    pub(crate) least: f64,
}

impl<'a> Screening<'a> {
    /// Looks at a model on the screen.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(crate) fn new(
        screen: &'a Lab<'a>,
        hints: &'a Hints,
        model: &'a SensorConfig,
    ) -> Result<Self, GapError> {
        let slopes = Slopes::around(screen, model, &parameter_knobs(), 1)?;
        let without = screen.run(model, 0)?;
        let mut new = Self { screen, hints, model, without, slopes, least: f64::INFINITY };
        new.least = new.left(&screen.expect(model, 1)?);
        Ok(new)
    }

    /// The misfit of an expectation, the numbers of the model following in a line.
    pub(crate) fn left(&self, expected: &Expectation) -> f64 {
        let deviations = expected.deviations(self.screen.layout, &self.screen.measured);
        self.slopes.best(NEARBY, self.screen, expected, &deviations, &parameter_knobs()).1
    }

    /// What is left beside a trial; none if it changes nothing, which is no explanation.
    fn score(&self, trial: &Trial) -> Result<Option<f64>, GapError> {
        let expected = self.screen.expect(&trial.beside(self.model), 1)?;
        let is_idle = expected.mean.iter().zip(&*self.without).all(|(a, b)| a == b);
        Ok((!is_idle).then(|| self.left(&expected)))
    }

    /// The best of some strengths; where `is_rising`, not of those beyond one that is far too strong.
    fn best_of(&self, way: &Way, strengths: &[f64], is_rising: bool) -> Result<Way, GapError> {
        let head = way.trial.params[0];
        let mut best = way.clone();
        for value in strengths {
            let trial = way.trial.with(head, *value);
            let Some(left) = self.score(&trial)? else { continue };
            if left < best.left {
                best = Way { trial, left, ..best };
            }
            let bearable = TOO_STRONG * self.least.min(best.left);
            if is_rising && (left.is_nan() || left >= bearable) {
                break;
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
                .map(move |trial| Way {
                    name: candidate.name(),
                    domain: candidate.spec.domain,
                    start,
                    trial,
                    left: f64::INFINITY,
                })
                .collect::<Vec<_>>()
        };
        Candidate::beside(self.model, left_out).into_iter().flat_map(hinted).collect()
    }

    /// What else the recording may mean by which `way` is the best.
    fn readings(&self, way: &Way) -> Result<Vec<Way>, GapError> {
        let trials = self.hints.readings(way.name, &way.trial, self.model);
        let scored = trials.into_par_iter().map(|trial| {
            let left = self.score(&trial)?.unwrap_or(f64::INFINITY);
            Ok(Way { trial, left, ..way.clone() })
        });
        scored.collect()
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
pub(crate) fn screened(
    screening: &[Screening<'_>],
    left_out: &[String],
) -> Result<Vec<Way>, GapError> {
    let ways: Vec<Way> = screening
        .iter()
        .enumerate()
        .flat_map(|(start, screening)| screening.ways(start, left_out))
        .collect();
    // Every other strength, then those between for what looks best. Readouts, delays and
    // scatter of stamps show only where they are nearly right.
    let mut best = ways
        .par_iter()
        .map(|way| {
            let read = way.trial.value(way.trial.params[0]);
            let is_sharp = matches!(way.domain, Domain::Clock | Domain::Readout);
            // The queue of a bus grows evenly with what it takes for an event.
            let step = if is_sharp && way.name != "arbiter" { 1 } else { 2 };
            let (mut coarse, is_rising) = way.trial.rising();
            coarse = coarse.into_iter().step_by(step).collect();
            let screening = &screening[way.start];
            let way = screening.best_of(way, read.as_slice(), false)?;
            screening.best_of(&way, &coarse, is_rising)
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    best.sort_by(|a, b| a.left.total_cmp(&b.left));
    // What is beside a model that explains less looks worse, whatever it is.
    let mut before = vec![0; screening.len()];
    let ranks: Vec<usize> = best
        .iter()
        .map(|way| {
            before[way.start] += 1;
            before[way.start] - 1
        })
        .collect();
    let finer = best.par_iter_mut().zip(&ranks).filter(|(_, rank)| **rank < FINER);
    finer.map(|(way, _)| way).try_for_each(|way| {
        let value = way.trial.value(way.trial.params[0]);
        let strengths = way.trial.strengths();
        let at = strengths.iter().position(|strength| Some(*strength) == value);
        let beside = at.into_iter().flat_map(|i| [i.checked_sub(1), Some(i + 1)]);
        let beside = beside.flatten().filter_map(|i| strengths.get(i).copied());
        *way = screening[way.start].best_of(way, &beside.collect::<Vec<_>>(), false)?;
        Ok::<(), GapError>(())
    })?;
    let plain = best.iter().zip(&ranks).filter(|(_, rank)| **rank < RICHER);
    let richer: Vec<Way> =
        plain.flat_map(|(way, _)| screening[way.start].richer(way, left_out)).collect();
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
            screening[way.start].best_of(way, &tried, false)
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    best.extend(richer);
    best.sort_by(|a, b| a.left.total_cmp(&b.left));
    for (start, screening) in screening.iter().enumerate() {
        // A wave that is slightly off looks worse than noise.
        let mut first = best.iter().filter(|way| way.start == start).take(RICHER);
        if let Some(way) = first.find(|way| SUDDEN.contains(&way.name)).cloned() {
            best.extend(screening.readings(&way)?);
        }
    }
    best.sort_by(|a, b| a.left.total_cmp(&b.left));
    let mut names = Vec::new();
    best.retain(|way| {
        let way_of = (way.name, way.start);
        let ways = names.iter().filter(|other| **other == way_of).count();
        names.push(way_of);
        let most = if SUDDEN.contains(&way.name) { 2 * WAYS } else { WAYS };
        ways < most && way.left.is_finite()
    });
    Ok(best)
}

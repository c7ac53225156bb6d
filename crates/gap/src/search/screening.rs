//! Screening: every candidate at a grid of strengths, on a short part of a recording.
//!
//! # Method
//! Each trial is one simulation; the parameters that the base model has already follow linearly, by
//! the slopes around it. What every strength changed in the summary is kept, for the proposals
//! beside other models. Passes: a coarse grid of strengths, the neighbours of the best strengths,
//! variants with more parameters, and other interpretations of parameters that were estimated
//! directly.

use std::sync::Arc;

use evpose_sensor::{Domain, SensorConfig};
use rayon::prelude::*;

use super::direct_estimates::DirectEstimates;
use crate::candidate::{Candidate, Trial};
use crate::compare::Expectation;
use crate::fit::Slopes;
use crate::free_parameter::FreeParameter;
use crate::search_spec::Onset;
use crate::search_spec::Searched;
use crate::{GapError, Objective};

/// Trials that are tried at the neighbours of their strength.
const FINER: usize = 10;
/// Trials that are tried with more parameters.
const RICHER: usize = 8;
/// Factors on the strength at which variants with more parameters are tried.
const RICHER_FACTORS: [f64; 2] = [0.6, 1.7];
/// Strengths beyond one that multiplies the discrepancy by this are not tried.
const TOO_STRONG: f64 = 4.0;
/// Trials of one candidate that are followed: a short part of a recording does not
/// distinguish variants that differ from pixel to pixel only.
const VARIANTS: usize = 3;
/// Multiples of a simulated change that are taken for those of other strengths.
const MULTIPLES: [f64; 6] = [0.05, 0.15, 0.4, 1.0, 2.0, 4.0];
/// Steps up to which the effect of the model's parameters is taken to be linear.
pub(super) const MAX_LINEAR_STEPS: f64 = 2.0;

#[derive(Debug, Clone)]
pub(super) struct TriedStrength {
    pub(super) trial: Trial,
    /// Change of the summary of the base model.
    pub(super) change: Arc<Vec<f64>>,
}

/// A variant of a candidate added to a base model, with its discrepancy.
#[derive(Debug, Clone)]
pub(super) struct ScreenedTrial {
    pub(super) name: &'static str,
    pub(super) trial: Trial,
    pub(super) discrepancy: f64,
    /// All strengths that were simulated.
    pub(super) tried: Vec<TriedStrength>,
}

impl ScreenedTrial {
    /// Strength of the effect; none if the trial leaves it at the default.
    fn strength(&self) -> Option<f64> {
        self.trial.value(self.trial.params[0])
    }

    /// Whether it is one of the effects that one of `others` is easily taken for.
    pub(super) fn resembles_one_of(&self, others: &[Self]) -> bool {
        others.iter().any(|other| other.trial.spec.search().resembles.contains(&self.name))
    }

    /// Whether a short part of a recording does not show it.
    pub(super) fn is_slow(&self) -> bool {
        self.trial.spec.search().is_slow
    }

    /// Whether the best trial on a short part need not lead to the best fit.
    fn is_sudden(&self) -> bool {
        self.trial.spec.search().onset == Onset::Sudden
    }
}

/// A model that effects are added to on the screen.
pub(super) struct ScreeningBase<'a> {
    objective: &'a Objective<'a>,
    estimates: &'a DirectEstimates,
    model: &'a SensorConfig,
    pub(super) summary: Arc<Vec<f64>>,
    /// Parameters that follow linearly, and their slopes.
    nuisance: Vec<FreeParameter>,
    slopes: Slopes,
    pub(super) discrepancy_without: f64,
}

impl<'a> ScreeningBase<'a> {
    /// Simulates a base model and the slopes of its parameters `nuisance`.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn new(
        objective: &'a Objective<'a>,
        estimates: &'a DirectEstimates,
        model: &'a SensorConfig,
        nuisance: Vec<FreeParameter>,
    ) -> Result<Self, GapError> {
        let slopes = Slopes::around(objective, model, &nuisance, 1)?;
        let summary = objective.run(model, 0)?;
        // Set below: profiling needs the rest of the base.
        let discrepancy_without = f64::INFINITY;
        let mut base =
            Self { objective, estimates, model, summary, nuisance, slopes, discrepancy_without };
        base.discrepancy_without = base.profiled(&objective.expect(model, 1)?);
        Ok(base)
    }

    /// Discrepancy of an expectation, minimised over the parameters that follow linearly.
    pub(super) fn profiled(&self, expected: &Expectation) -> f64 {
        let deviations = expected.deviations(self.objective.layout, &self.objective.measured);
        self.slopes.best(MAX_LINEAR_STEPS, self.objective, expected, &deviations, &self.nuisance).1
    }

    /// Expectation of the model without any added effect.
    ///
    /// # Errors
    /// A model that cannot be shown the scene.
    pub(super) fn expected(&self) -> Result<Expectation, GapError> {
        self.objective.expect(self.model, 1)
    }

    /// Discrepancy with a trial; none if the trial changes nothing, which explains nothing.
    fn score(&self, trial: &Trial) -> Result<Option<(f64, TriedStrength)>, GapError> {
        let expected = self.objective.expect(&trial.added_to(self.model), 1)?;
        let change = expected.mean.iter().zip(&*self.summary).map(|(a, b)| a - b);
        let change = Arc::new(change.collect::<Vec<f64>>());
        let is_idle = expected.mean.iter().zip(&*self.summary).all(|(a, b)| a == b);
        let tried = TriedStrength { trial: trial.clone(), change };
        Ok((!is_idle).then(|| (self.profiled(&expected), tried)))
    }

    /// The least discrepancy with a trial of any strength, by one simulation whose change is taken to be in
    /// proportion to the strength.
    pub(super) fn predicted(&self, trial: &Trial) -> Result<f64, GapError> {
        let strength = trial.params[0];
        let strengths = trial.strengths();
        let is_signed = strengths[0] < 0.0;
        // Strong enough to be seen beside what jumps from run to run.
        let visible = strengths[2 * strengths.len() / 3];
        let mut expected =
            self.objective.expect(&trial.with(strength, visible).added_to(self.model), 1)?;
        let change: Vec<f64> =
            expected.mean.iter().zip(&*self.summary).map(|(a, b)| a - b).collect();
        let multiples =
            MULTIPLES.into_iter().flat_map(|k| if is_signed { vec![k, -k] } else { vec![k] });
        let discrepancies = multiples.map(|multiple| {
            let moved = self.summary.iter().zip(&change).map(|(a, b)| a + multiple * b);
            expected.mean = moved.collect();
            self.profiled(&expected)
        });
        // One that is no number is none.
        Ok(discrepancies.fold(f64::INFINITY, f64::min))
    }

    /// The best of some strengths. With `is_rising`, strengths beyond a far too strong one are
    /// skipped.
    pub(super) fn best_of(
        &self,
        screened: &ScreenedTrial,
        strengths: &[f64],
        is_rising: bool,
    ) -> Result<ScreenedTrial, GapError> {
        let strength = screened.trial.params[0];
        let mut best = screened.clone();
        for value in strengths {
            let trial = screened.trial.with(strength, *value);
            let Some((discrepancy, tried)) = self.score(&trial)? else { continue };
            best.tried.push(tried);
            if discrepancy < best.discrepancy {
                best = ScreenedTrial { trial, discrepancy, ..best };
            }
            // Discrepancy grows with strength from there on, and strong effects take longest to
            // simulate.
            let bearable = TOO_STRONG * self.discrepancy_without.min(best.discrepancy);
            if is_rising && (discrepancy.is_nan() || discrepancy >= bearable) {
                break;
            }
        }
        Ok(best)
    }

    /// The variant with the fewest parameters of each form of each candidate, not screened yet.
    fn trials(&self, left_out: &[String]) -> Vec<ScreenedTrial> {
        let of_candidate = |candidate: Candidate| {
            // More parameters only improve a form that helps at all: they are tried for the best
            // later.
            let forms = candidate.trials().into_iter().flat_map(|form| form.into_iter().take(1));
            forms
                .map(|trial| self.estimates.applied(candidate.name(), &trial))
                .map(move |trial| ScreenedTrial {
                    name: candidate.name(),
                    trial,
                    discrepancy: f64::INFINITY,
                    tried: Vec::new(),
                })
                .collect::<Vec<_>>()
        };
        // Also those that the model has, at another strength.
        Candidate::all(left_out).into_iter().flat_map(of_candidate).collect()
    }

    /// Screens a trial at the coarse grid of strengths, and at its direct estimate if there is one.
    fn coarse(&self, screened: &ScreenedTrial) -> Result<ScreenedTrial, GapError> {
        // Readouts, delays and jitter of time stamps show only where they are nearly right: they
        // need the whole grid, unless they are known to set in evenly.
        let spec = screened.trial.spec;
        let is_sharp = matches!(spec.domain, Domain::Clock | Domain::Readout);
        let stride = if is_sharp && spec.search().onset != Onset::Even { 1 } else { 2 };
        let (strengths, is_rising) = screened.trial.rising();
        let strengths: Vec<f64> = strengths.into_iter().step_by(stride).collect();
        let at_estimate = self.best_of(screened, screened.strength().as_slice(), false)?;
        self.best_of(&at_estimate, &strengths, is_rising)
    }

    /// Screens the neighbours of a trial's strength on the grid.
    fn finer(&self, screened: &ScreenedTrial) -> Result<ScreenedTrial, GapError> {
        let value = screened.strength();
        let strengths = screened.trial.strengths();
        let at = strengths.iter().position(|strength| Some(*strength) == value);
        let neighbours = at.into_iter().flat_map(|i| [i.checked_sub(1), Some(i + 1)]);
        let neighbours = neighbours.flatten().filter_map(|i| strengths.get(i).copied());
        self.best_of(screened, &neighbours.collect::<Vec<_>>(), false)
    }

    /// Variants of a candidate with more parameters than `screened`, at its strength.
    fn with_more_parameters(
        &self,
        screened: &ScreenedTrial,
        left_out: &[String],
    ) -> Vec<ScreenedTrial> {
        let strength = screened.trial.params[0];
        let value = screened.strength();
        // `skip(1)`: the first trial of a form is the one with fewest parameters, screened already.
        let candidate =
            Candidate::all(left_out).into_iter().find(|other| other.name() == screened.name);
        let forms = candidate.into_iter().flat_map(Candidate::trials);
        forms
            .filter(|form| {
                form[0].params[0].name == strength.name && form[0].is_form_of(&screened.trial)
            })
            .flat_map(|form| form.into_iter().skip(1))
            .map(|trial| self.estimates.applied(screened.name, &trial))
            .map(|trial| ScreenedTrial {
                trial: value.map_or(trial.clone(), |value| trial.with(strength, value)),
                discrepancy: f64::INFINITY,
                tried: Vec::new(),
                ..screened.clone()
            })
            .collect()
    }

    /// Screens a trial at its strength and at two strengths around it.
    pub(super) fn around(&self, screened: &ScreenedTrial) -> Result<ScreenedTrial, GapError> {
        let value = screened.strength().unwrap_or(0.0);
        let strengths = screened.trial.strengths();
        let nearest = |factor: f64| {
            let wanted = value * factor;
            // On the grid, so that screened strengths are simulated once and found in the cache.
            let distance = |s: &&f64| (*s / wanted).ln().abs();
            strengths.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).copied()
        };
        let others = RICHER_FACTORS.iter().filter_map(|factor| nearest(*factor));
        let tried: Vec<f64> = std::iter::once(value).chain(others).collect();
        self.best_of(screened, &tried, false)
    }

    /// Screens other interpretations of the directly estimated parameters of a trial.
    fn interpretations(&self, screened: &ScreenedTrial) -> Result<Vec<ScreenedTrial>, GapError> {
        let trials = self.estimates.interpretations(screened.name, &screened.trial, self.model);
        let scored = trials.into_par_iter().map(|trial| {
            let (discrepancy, tried) =
                self.score(&trial)?.map_or((f64::INFINITY, Vec::new()), |(d, one)| (d, vec![one]));
            Ok(ScreenedTrial { trial, discrepancy, tried, ..screened.clone() })
        });
        scored.collect()
    }
}

/// Screens every candidate added to a base model; the best trials first.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn screen(
    base: &ScreeningBase<'_>,
    left_out: &[String],
) -> Result<Vec<ScreenedTrial>, GapError> {
    let mut screened = base
        .trials(left_out)
        .par_iter()
        .map(|trial| base.coarse(trial))
        .collect::<Result<Vec<_>, GapError>>()?;
    sort(&mut screened);
    let finer = screened.len().min(FINER);
    screened[..finer].par_iter_mut().try_for_each(|trial| {
        *trial = base.finer(trial)?;
        Ok::<(), GapError>(())
    })?;
    // In the order of the coarse grid: the finer strengths are not sorted in yet.
    let best = &screened[..screened.len().min(RICHER)];
    let richer: Vec<ScreenedTrial> =
        best.iter().flat_map(|trial| base.with_more_parameters(trial, left_out)).collect();
    let richer =
        richer.par_iter().map(|trial| base.around(trial)).collect::<Result<Vec<_>, GapError>>()?;
    screened.extend(richer);
    sort(&mut screened);
    // A periodic signal with a slightly wrong phase looks worse than noise.
    let mut best = screened.iter().take(RICHER);
    if let Some(trial) = best.find(|trial| trial.is_sudden()).cloned() {
        screened.extend(base.interpretations(&trial)?);
    }
    sort(&mut screened);
    keep_best_variants(&mut screened);
    Ok(screened)
}

/// Sorts trials by their discrepancy, the smallest first.
pub(super) fn sort(screened: &mut [ScreenedTrial]) {
    screened.sort_by(|a, b| a.discrepancy.total_cmp(&b.discrepancy));
}

fn keep_best_variants(screened: &mut Vec<ScreenedTrial>) {
    let mut seen = Vec::new();
    screened.retain(|trial| {
        let before = seen.iter().filter(|name| **name == trial.name).count();
        seen.push(trial.name);
        let max = if trial.is_sudden() { 2 * VARIANTS } else { VARIANTS };
        before < max && !trial.tried.is_empty()
    });
}

//! Fit of every effect of the catalogue to a recording.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use super::direct_estimates::DirectEstimates;
use super::identification::FittedCandidate;
use super::screening::{MAX_LINEAR_STEPS, ScreenedTrial, ScreeningBase, screen};
use crate::candidate::Trial;
use crate::fit::{Fit, Slopes, descend};
use crate::free_parameter::FreeParameter;
use crate::{GapError, Objective};

/// Decrease of the discrepancy on the screen that makes a trial promising.
const PROMISING_GAIN: f64 = 6.0;
/// A trial added to the model as given may leave up to this multiple of what the refitted model
/// does.
const NEARLY: f64 = 1.5;
/// Trials of which the strength is fitted, for each base model.
const LINE_SEARCHED: usize = 8;
/// Trials of which all parameters are fitted.
const FINALISTS: usize = 4;
/// Trials with more than this multiple of the least discrepancy are not fitted in full.
const FAR_BEHIND: f64 = 5.0;
/// Fitted trials that are refined, and the multiple of the least discrepancy that they may have.
const REFINED: usize = 4;
const NOT_FAR: f64 = 2.5;
/// Gauss-Newton rounds of a fit.
const ROUNDS: usize = 4;
/// Steps of the line search over the strength.
const LINE_STEPS: [f64; 3] = [5.0, 2.5, 1.2];

/// Fits all candidates added to each of `bases`, the best first; those that were only screened come
/// last. The bases differ from the model as `given` by their parameters and by effects added
/// before. The result is empty if no trial is promising on `screen_objective`, a short part of the
/// recording.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn fit_catalogue(
    screen_objective: &Objective<'_>,
    objective: &Objective<'_>,
    given: &SensorConfig,
    bases: &[SensorConfig],
    estimates: &DirectEstimates,
    left_out: &[String],
) -> Result<Vec<FittedCandidate>, GapError> {
    let (mut screening, mut least) = (Vec::new(), f64::INFINITY);
    for model in bases {
        let base = ScreeningBase::new(screen_objective, estimates, model)?;
        least = least.min(base.discrepancy_without);
        screening.push(base);
    }
    let screened = screen(&screening, left_out)?;
    // A few strengths without a fit may not reach what the refitted parameters have absorbed.
    let is_promising = |trial: &ScreenedTrial| {
        trial.discrepancy < least - PROMISING_GAIN
            || (trial.base > 0
                && trial.discrepancy < NEARLY * least
                && trial.discrepancy < screening[trial.base].discrepancy_without - PROMISING_GAIN)
    };
    if !screened.iter().any(is_promising) {
        return Ok(Vec::new());
    }
    // The best of each base: all trials added to a better base look better.
    let mut fitted: Vec<FittedCandidate> = Vec::new();
    let mut rest = Vec::new();
    for (base, model) in bases.iter().enumerate() {
        if !screened.iter().any(|trial| trial.base == base && is_promising(trial)) {
            continue;
        }
        let mut trials = screened.iter().filter(|trial| trial.base == base);
        let best: Vec<&ScreenedTrial> = trials.by_ref().take(LINE_SEARCHED).collect();
        rest.extend(trials);
        let slopes = Slopes::around(objective, model, &FreeParameter::of_model(), 1)?;
        let least = fitted.iter().map(|one| one.fit.discrepancy).fold(f64::INFINITY, f64::min);
        fitted.extend(fit_trials(objective, model, &best, &slopes, least)?);
    }
    refine_best(objective, given, &mut fitted)?;
    rest.sort_by(|a, b| a.discrepancy.total_cmp(&b.discrepancy));
    fitted.extend(rest.into_iter().map(|screened| FittedCandidate {
        name: screened.name,
        fit: Fit {
            model: screened.trial.added_to(&bases[screened.base]),
            discrepancy: screened.discrepancy,
        },
        trial: screened.trial.clone(),
    }));
    Ok(fitted)
}

/// Refines those fits that are not far behind the best, and sorts all of them, the best first.
fn refine_best(
    objective: &Objective<'_>,
    given: &SensorConfig,
    fitted: &mut [FittedCandidate],
) -> Result<(), GapError> {
    let by_discrepancy =
        |a: &FittedCandidate, b: &FittedCandidate| a.fit.discrepancy.total_cmp(&b.fit.discrepancy);
    fitted.sort_by(by_discrepancy);
    let least = fitted.first().map_or(0.0, |one| one.fit.discrepancy);
    let is_near = |one: &&FittedCandidate| one.fit.discrepancy < NOT_FAR * least;
    let near = fitted.iter().take(REFINED).take_while(is_near).count();
    fitted[..near].par_iter_mut().try_for_each(|one| {
        one.add_parameters(objective, given)?;
        one.drop_parameters(objective, given)
    })?;
    fitted.sort_by(by_discrepancy);
    if let Some(best) = fitted.first_mut() {
        best.refine_time_steps(objective)?;
    }
    Ok(())
}

/// Fits the strengths of trials added to one model, and all parameters of the best; `least` is the
/// smallest discrepancy so far.
fn fit_trials(
    objective: &Objective<'_>,
    model: &SensorConfig,
    trials: &[&ScreenedTrial],
    slopes: &Slopes,
    mut least: f64,
) -> Result<Vec<FittedCandidate>, GapError> {
    let of_model = FreeParameter::of_model();
    let mut fitted = trials
        .par_iter()
        .map(|screened| {
            let fit = search_strength(objective, model, &screened.trial, slopes)?;
            Ok(FittedCandidate { name: screened.name, fit, trial: screened.trial.clone() })
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    fitted.sort_by(|a, b| a.fit.discrepancy.total_cmp(&b.fit.discrepancy));
    let finalists = fitted.len().min(FINALISTS);
    // Two at a time: the first ones may set a discrepancy that the others are far behind.
    for two in fitted[..finalists].chunks_mut(2) {
        let is_near = |one: &&mut FittedCandidate| one.fit.discrepancy < FAR_BEHIND * least;
        two.par_iter_mut().filter(is_near).try_for_each(|one| {
            let linear = Some((of_model.as_slice(), slopes));
            let free = FreeParameter::of_effect(&one.trial);
            one.fit = descend(objective, &one.fit.model, &free, linear, 1, ROUNDS)?;
            Ok::<(), GapError>(())
        })?;
        least = two.iter().map(|one| one.fit.discrepancy).fold(least, f64::min);
    }
    Ok(fitted)
}

/// Line search over the strength of an effect, around the best of the screened strengths. The
/// model's own parameters follow linearly.
fn search_strength(
    objective: &Objective<'_>,
    model: &SensorConfig,
    trial: &Trial,
    slopes: &Slopes,
) -> Result<Fit, GapError> {
    let strength = FreeParameter::of_effect(trial)[0];
    let of_model = FreeParameter::of_model();
    let profiled = |model: &SensorConfig| -> Result<f64, GapError> {
        let expected = objective.expect(model, 1)?;
        let deviations = expected.deviations(objective.layout, &objective.measured);
        Ok(slopes.best(MAX_LINEAR_STEPS, objective, &expected, &deviations, &of_model).1)
    };
    let mut model = trial.added_to(model);
    let mut discrepancy = profiled(&model)?;
    for steps in LINE_STEPS {
        for sign in [-1.0, 1.0] {
            let stepped = strength.stepped(&model, sign * steps);
            let other = profiled(&stepped)?;
            if other < discrepancy {
                (model, discrepancy) = (stepped, other);
                break;
            }
        }
    }
    Ok(Fit { model, discrepancy })
}

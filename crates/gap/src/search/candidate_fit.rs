//! Fit of proposed effects, added to a model one at a time.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use super::identification::FittedCandidate;
use super::screening::{MAX_LINEAR_STEPS, ScreenedTrial};
use crate::candidate::Trial;
use crate::fit::{Fit, Slopes, descend};
use crate::free_parameter::FreeParameter;
use crate::search_spec::Searched;
use crate::{GapError, Objective};

/// Proposals whose strength is fitted.
const LINE_SEARCHED: usize = 6;
/// Further proposals whose strength is fitted because they resemble one of these.
const RESEMBLING: usize = 3;
/// Proposals that are fitted in all their parameters.
const FINALISTS: usize = 3;
/// Proposals with more than this multiple of the least discrepancy are not fitted in full.
const FAR_BEHIND: f64 = 2.0;
/// Gauss-Newton rounds of a fit.
const ROUNDS: usize = 3;
/// Steps of the line search over the strength.
const LINE_STEPS: [f64; 3] = [5.0, 2.5, 1.2];
/// Stride in the grid of strengths at which a slow effect is tried.
const SLOW_STRIDE: usize = 2;
/// Values across the range of a parameter whose estimate is rough, a phase, that are tried.
const ROUGH_VALUES: usize = 8;

/// Fits the best of some proposals, each added to `model`, the best first. Parameters that the
/// model has already, `nuisance`, follow linearly.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn fit_candidates(
    objective: &Objective<'_>,
    model: &SensorConfig,
    proposals: &[ScreenedTrial],
    nuisance: &[FreeParameter],
) -> Result<Vec<FittedCandidate>, GapError> {
    // Slopes of the model alone serve every candidate: refitting its parameters beside each would
    // cost a descent per trial of the line search.
    let slopes = Slopes::around(objective, model, nuisance, 1)?;
    let best = &proposals[..proposals.len().min(LINE_SEARCHED)];
    // A short part of a recording does not distinguish an effect from those that resemble it.
    let others = proposals.iter().skip(LINE_SEARCHED).filter(|one| one.resembles_one_of(best));
    let others = others.take(RESEMBLING);
    let slow = proposals.iter().skip(LINE_SEARCHED).filter(|one| one.is_slow());
    let mut fitted = best
        .iter()
        .chain(others)
        .chain(slow.filter(|one| !one.resembles_one_of(best)))
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|proposal| {
            let fit = search_strength(objective, model, &proposal.trial, &slopes, nuisance)?;
            Ok(FittedCandidate { name: proposal.name, fit, trial: proposal.trial.clone() })
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    // A descent takes a simulation for each parameter and round: only those near the best get one.
    sort(&mut fitted);
    let least = fitted.first().map_or(f64::INFINITY, |one| one.fit.discrepancy);
    let is_near = |one: &&mut FittedCandidate| one.fit.discrepancy < FAR_BEHIND * least;
    let finalists = fitted.len().min(FINALISTS);
    fitted[..finalists].par_iter_mut().filter(is_near).try_for_each(|one| {
        let free = FreeParameter::of_effect(&one.trial);
        let linear = Some((nuisance, &slopes));
        one.fit = descend(objective, &one.fit.model, &free, linear, 1, ROUNDS)?;
        Ok::<(), GapError>(())
    })?;
    sort(&mut fitted);
    Ok(fitted)
}

fn sort(fitted: &mut [FittedCandidate]) {
    fitted.sort_by(|a, b| a.fit.discrepancy.total_cmp(&b.fit.discrepancy));
}

/// Line search over the strength of an effect, around the screened strength.
fn search_strength(
    objective: &Objective<'_>,
    base: &SensorConfig,
    trial: &Trial,
    slopes: &Slopes,
    nuisance: &[FreeParameter],
) -> Result<Fit, GapError> {
    let strength = FreeParameter::of_effect(trial)[0];
    let profiled = |model: &SensorConfig| -> Result<f64, GapError> {
        let expected = objective.expect(model, 1)?;
        let deviations = expected.deviations(objective.layout, &objective.measured);
        Ok(slopes.best(MAX_LINEAR_STEPS, objective, &expected, &deviations, nuisance).1)
    };
    let mut model = trial.added_to(base);
    let mut discrepancy = profiled(&model)?;
    // The discrepancy over a phase has many minima; a descent ends in the one it starts in.
    for free in FreeParameter::of_effect(trial) {
        for value in free.rough_values(ROUGH_VALUES) {
            let moved = free.with_value(&model, value);
            let other = profiled(&moved)?;
            if other < discrepancy {
                (model, discrepancy) = (moved, other);
            }
        }
    }
    if trial.spec.search().is_slow {
        // What was screened says nothing about its strength.
        for value in trial.strengths().into_iter().step_by(SLOW_STRIDE) {
            let other_model = trial.with(trial.params[0], value).added_to(base);
            let other = profiled(&other_model)?;
            if other < discrepancy {
                (model, discrepancy) = (other_model, other);
            }
        }
    }
    // Large steps first: a screened strength is off by the stride of the grid.
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

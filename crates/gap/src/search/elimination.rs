//! Backward elimination: effects and parameters that are not worth their names beside the others
//! are dropped.

use super::decision::{MAX_EVERYDAY, Worth, is_reportable, is_significant};
use super::identification::DataSplits;
use super::selection::Selection;
use super::significance::difference_with_losses;
use super::stepwise::Forward;
use crate::GapError;
use crate::candidate::Trial;
use crate::fit::descend;
use crate::parameters::ModelParameter;
use crate::search_spec::Searched;
use evpose_sensor::SensorConfig;

/// Rounds of the fit of the rest after an effect was dropped.
const ROUNDS: usize = 2;
/// Steps below which a parameter of the model has not changed.
const MIN_STEPS: f64 = 0.3;

/// A selection without one of its parts, scored on held-out data.
#[derive(Debug, Clone)]
pub(super) struct Dropped {
    pub(super) rest: Selection,
    /// Evidence for the part beside the others.
    pub(super) worth: Worth,
}

/// Drops effects until each of the rest is worth its name. Returns what each of the rest explains.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn eliminate(
    splits: &DataSplits<'_>,
    forward: &Forward<'_>,
    selection: &mut Selection,
) -> Result<Vec<Dropped>, GapError> {
    let Forward { estimates, excess, .. } = *forward;
    let candidates = forward.proposals.len();
    loop {
        let mut dropped = Vec::new();
        for i in 0..selection.effects.len() {
            // The rest is fitted again, so that what others can take over does not count as
            // evidence.
            let rest = selection.without(splits, i, ROUNDS)?;
            let worth = worth(splits, &rest.model, &selection.model, excess, candidates)?;
            dropped.push(Dropped { rest, worth });
        }
        let has_readout = selection.effects.iter().any(|effect| effect.candidate.is_readout());
        // A clock that the time stamps prove may be the lines of a readout that was found later.
        let weakest = dropped.iter().enumerate().filter(|(i, one)| {
            let trial = &selection.effects[*i].candidate.trial;
            let effect = selection.model.effect(trial.spec.name);
            let is_counted = effect.is_none_or(|effect| estimates.allows(effect));
            let strength = effect.and_then(|effect| effect.number(trial.params[0].name));
            let is_too_weak = strength.is_some_and(|value| trial.is_weaker_than_in_cameras(value));
            let is_proven = selection.effects[*i].is_proven && !has_readout;
            let is_worth_it =
                if is_proven { is_significant(&one.worth) } else { is_reportable(&one.worth) };
            !is_counted || is_too_weak || is_ordinary_noise(selection, trial) || !is_worth_it
        });
        let weakest = weakest.min_by(|a, b| a.1.worth.fraction().total_cmp(&b.1.worth.fraction()));
        // One at a time: what an effect explains grows when one that shares its evidence is
        // dropped.
        match weakest {
            Some((i, _)) => *selection = dropped.swap_remove(i).rest,
            None => return Ok(dropped),
        }
    }
}

/// Fits all parameters of the model, and resets those whose change is not significant to their given
/// values. Returns the others, with what each explains.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn changed_parameters(
    splits: &DataSplits<'_>,
    selection: &mut Selection,
    excess: f64,
) -> Result<Vec<(ModelParameter, Worth)>, GapError> {
    // All are free at first: a parameter that is dropped early could not share what others explain.
    selection.fitted = ModelParameter::ALL.to_vec();
    selection.fit_together(splits, ROUNDS)?;
    let given = selection.given.clone();
    let mut kept = Vec::new();
    for parameter in ModelParameter::ALL {
        let (before, now) = (parameter.value(&given), parameter.value(&selection.model));
        if before == now {
            continue;
        }
        let mut rest = selection.clone();
        parameter.set(&mut rest.model, before);
        rest.fitted.retain(|other| *other != parameter);
        let fit = descend(&splits.train, &rest.model, &rest.free_parameters(), None, 1, 1)?;
        rest.model = fit.model;
        rest.train_discrepancy = fit.discrepancy;
        rest.held_out = splits.score(&rest.model)?;
        // Each parameter is one of all that were tried, which the level of significance accounts
        // for.
        let tried = ModelParameter::ALL.len();
        let worth = worth(splits, &rest.model, &selection.model, excess, tried)?;
        if parameter.steps(before, now).abs() < MIN_STEPS || !is_reportable(&worth) {
            *selection = rest;
        } else {
            kept.push((parameter, worth));
        }
    }
    selection.fitted = kept.iter().map(|(parameter, _)| *parameter).collect();
    Ok(kept)
}

/// Whether an effect is no more than the little noise that every camera has and the given model
/// lacks. Pixels that are exactly alike answer at exactly the same time: the least noise
/// separates them, and a simulator that has none is not distinguished from one that has.
fn is_ordinary_noise(selection: &Selection, trial: &Trial) -> bool {
    trial.spec.search().dither.iter().any(|(key, ordinary)| {
        let value = |model: &SensorConfig| {
            model.effect(trial.spec.name).and_then(|effect| effect.number(key)).unwrap_or(0.0)
        };
        value(&selection.given) <= 0.0 && value(&selection.model) < MAX_EVERYDAY * ordinary
    })
}

fn worth(
    splits: &DataSplits<'_>,
    without: &SensorConfig,
    with: &SensorConfig,
    excess: f64,
    candidates: usize,
) -> Result<Worth, GapError> {
    let difference = difference_with_losses(&splits.held_out, without, with)?;
    let without = splits.score(without)?.discrepancy;
    Ok(Worth { difference, without, excess, candidates })
}

//! Swap move: each selected effect is tested against its rivals beside the others.

use super::identification::{Contender, DataSplits, FittedCandidate};
use super::relatives::are_relatives;
use super::selection::{SelectedEffect, Selection};
use super::significance::{difference, is_distinguished};
use crate::GapError;
use crate::candidate::{Trial, without_effect};
use crate::fit::descend;
use crate::free_parameter::FreeParameter;

/// Rivals that are tried in the place of an effect, beside its relatives.
const RIVALS: usize = 2;
/// Gauss-Newton rounds of each fit.
const ROUNDS: usize = 3;
/// Level at which the recording distinguishes an effect from a rival.
const LEVEL: f64 = 0.05;

#[derive(Debug, Clone)]
pub(super) struct Compared {
    /// The rivals with their scores, the best first.
    pub(super) rivals: Vec<Contender>,
    /// Names of the rivals that the recording does not distinguish from the effect.
    pub(super) confusable: Vec<&'static str>,
}

/// Replaces effects by rivals that do better in their place. Returns whether one was replaced, and
/// each effect's comparison.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn swap(
    splits: &DataSplits<'_>,
    selection: &mut Selection,
) -> Result<(bool, Vec<Compared>), GapError> {
    let mut is_swapped = false;
    let mut compared = Vec::new();
    for i in 0..selection.effects.len() {
        let effect = selection.effects[i].clone();
        let (relatives, others): (Vec<_>, Vec<_>) = effect
            .rivals
            .iter()
            .filter(|rival| !selection.has(rival.name))
            .partition(|rival| are_relatives(rival.name, effect.candidate.name));
        let mut fitted = Vec::new();
        for rival in relatives.into_iter().chain(others.into_iter().take(RIVALS)) {
            fitted.extend(in_place(splits, selection, i, rival)?);
        }
        fitted.retain(|rival| splits.resolves(rival));
        fitted.sort_by(|a, b| a.discrepancy().total_cmp(&b.discrepancy()));
        // An effect below the resolution of the comparison cannot stay, even where it fits best.
        let is_resolved = splits.resolves(selection);
        if let Some(best) = fitted.first().cloned()
            && (!is_resolved
                || best.discrepancy() < selection.discrepancy()
                    // Of relatives none has a better claim to the place than the one that fits best.
                    && (are_relatives(best.effects[i].candidate.name, effect.candidate.name)
                        || difference(&splits.held_out, &selection.model, &best.model)?
                            .is_significant(LEVEL, RIVALS)))
        {
            let own = selection.clone();
            selection.model = best.held_out.model.clone();
            selection.held_out = best.held_out.clone();
            let candidate = best
                .effects
                .get(i)
                .map_or_else(|| effect.candidate.clone(), |new| new.candidate.clone());
            // The replaced effect becomes a rival, so that the next comparison can bring it back.
            let mut rivals = vec![effect.candidate.clone()];
            rivals
                .extend(effect.rivals.iter().filter(|other| other.name != candidate.name).cloned());
            selection.effects[i] = SelectedEffect { candidate, rivals, is_proven: false };
            selection.train_discrepancy = best.train_discrepancy;
            // What was replaced stays as a rival, unless it could not be resolved at all.
            if is_resolved {
                fitted[0] = own;
            } else {
                fitted.remove(0);
            }
            is_swapped = true;
        }
        let mut confusable = Vec::new();
        for rival in &fitted {
            // By one test per rival at a mild level: a false "distinguished" names a wrong effect.
            if !is_distinguished(&splits.held_out, &rival.model, &selection.model, LEVEL)? {
                confusable.push(rival.effects[i].candidate.name);
            }
        }
        let rivals = fitted.into_iter().map(|rival| Contender {
            candidate: rival.effects[i].candidate.clone(),
            held_out: rival.held_out,
        });
        compared.push(Compared { rivals: rivals.collect(), confusable });
    }
    Ok((is_swapped, compared))
}

/// The selection with a rival in the place of effect number `i`; none if it does not fit beside the
/// others.
fn in_place(
    splits: &DataSplits<'_>,
    selection: &Selection,
    i: usize,
    rival: &FittedCandidate,
) -> Result<Option<Selection>, GapError> {
    let base =
        without_effect(&selection.model, &selection.given, selection.effects[i].candidate.name);
    let effect = rival.fit.model.effect(rival.name).unwrap_or(&rival.trial.effect).clone();
    let trial = Trial { effect, ..rival.trial.clone() };
    let added = trial.added_to(&base);
    // Effects that take the same place in the camera, two readouts for instance, exclude each
    // other.
    let others = selection.effects.iter().enumerate().filter(|(k, _)| *k != i);
    if others.into_iter().any(|(_, other)| added.effect(other.candidate.name).is_none()) {
        return Ok(None);
    }
    let mut swapped = selection.clone();
    swapped.effects[i].candidate = rival.clone();
    let mut free = FreeParameter::of_effect(&trial);
    free.extend(selection.free_parameters_of_model());
    let fit = descend(&splits.train, &added, &free, None, 1, ROUNDS)?;
    swapped.model = fit.model;
    swapped.train_discrepancy = fit.discrepancy;
    swapped.held_out = splits.score(&swapped.model)?;
    Ok(Some(swapped))
}

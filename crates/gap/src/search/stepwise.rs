//! Forward selection: one more effect, if held-out data says that it is worth its name.

use evpose_sensor::SensorConfig;

use super::candidate_fit::fit_candidates;
use super::decision::{Worth, is_worth_a_name};
use super::direct_estimates::DirectEstimates;
use super::identification::{DataSplits, FittedCandidate, ModelScore};
use super::proposals::Proposals;
use super::screening::{ScreenedTrial, ScreeningBase};
use super::selection::{SelectedEffect, Selection};
use super::significance::difference;
use crate::GapError;
use crate::free_parameter::FreeParameter;
use crate::parameters::with_given_parameters;

/// Candidates that are scored on held-out data.
const SCORED: usize = 4;
/// Rounds of the joint fit after an effect was added.
const ROUNDS: usize = 2;

/// What a forward step works with.
pub(super) struct Forward<'a> {
    pub(super) splits: &'a DataSplits<'a>,
    pub(super) proposals: &'a Proposals,
    pub(super) estimates: &'a DirectEstimates,
    /// The model as given.
    pub(super) given: &'a SensorConfig,
    /// Discrepancy of the model as given, beyond that of its own runs.
    pub(super) excess: f64,
}

impl Forward<'_> {
    /// Adds the best candidate to a selection. Returns false if none is worth its name.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn step(&self, selection: &mut Selection) -> Result<bool, GapError> {
        let mut candidates = self.candidates(selection, &selection.model)?;
        if selection.effects.is_empty() {
            // The refit may have absorbed what an effect does: start from the given values too.
            let given = with_given_parameters(&selection.model, self.given);
            if given != selection.model {
                candidates.extend(self.candidates(selection, &given)?);
            }
        }
        let mut scored = self.scored(candidates)?;
        if scored.is_empty() {
            return Ok(false);
        }
        let (best, held_out) = scored.remove(0);
        let found = difference(&self.splits.held_out, &selection.model, &held_out.model)?;
        let worth = Worth {
            difference: found,
            without: selection.held_out.discrepancy,
            excess: self.excess,
            candidates: self.proposals.len(),
        };
        if !is_worth_a_name(&worth) {
            return Ok(false);
        }
        selection.model = best.fit.model.clone();
        selection.held_out = held_out;
        let rivals = scored.into_iter().map(|(rival, _)| rival).collect();
        selection.effects.push(SelectedEffect { candidate: best, rivals, is_proven: false });
        selection.fit_together(self.splits, ROUNDS)?;
        Ok(true)
    }

    /// Candidates fitted beside a model with the effects of a selection.
    fn candidates(
        &self,
        selection: &Selection,
        model: &SensorConfig,
    ) -> Result<Vec<FittedCandidate>, GapError> {
        let nuisance: Vec<FreeParameter> = selection.free_parameters();
        let screen = &self.splits.screen;
        let base = ScreeningBase::new(screen, self.estimates, model, nuisance.clone())?;
        let is_free = |one: &ScreenedTrial| {
            let added = one.trial.added_to(model);
            // A readout would replace another one that was selected.
            let keeps_others = selection
                .effects
                .iter()
                .all(|effect| added.effect(effect.candidate.name).is_some());
            !selection.has(one.name) && keeps_others
        };
        let proposed = self.proposals.beside(&base, is_free)?;
        let promising: Vec<ScreenedTrial> =
            proposed.into_iter().filter(|one| one.discrepancy < base.discrepancy_without).collect();
        if promising.is_empty() {
            return Ok(Vec::new());
        }
        fit_candidates(&self.splits.train, model, &promising, &nuisance)
    }

    /// The best fit of each of the best candidates with its score on held-out data, the best first.
    fn scored(
        &self,
        mut candidates: Vec<FittedCandidate>,
    ) -> Result<Vec<(FittedCandidate, ModelScore)>, GapError> {
        candidates.sort_by(|a, b| a.fit.discrepancy.total_cmp(&b.fit.discrepancy));
        let mut scored: Vec<(FittedCandidate, ModelScore)> = Vec::new();
        for candidate in candidates {
            // Forms that differ little on training data may differ much on other data.
            let is_known = |(other, _): &(FittedCandidate, ModelScore)| {
                other.name == candidate.name && other.trial.is_form_of(&candidate.trial)
            };
            if scored.len() < SCORED && !scored.iter().any(is_known) {
                let held_out = self.splits.score(&candidate.fit.model)?;
                scored.push((candidate, held_out));
            }
        }
        // All have the same chance to fit the training data: both parts together decide.
        let both = |(candidate, held_out): &(FittedCandidate, ModelScore)| {
            candidate.fit.discrepancy + held_out.discrepancy
        };
        scored.sort_by(|a, b| both(a).total_cmp(&both(b)));
        let mut names = Vec::new();
        scored.retain(|(candidate, _)| {
            let is_new = !names.contains(&candidate.name);
            names.push(candidate.name);
            is_new
        });
        Ok(scored)
    }
}

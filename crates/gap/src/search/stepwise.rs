//! Forward selection: one more effect, if held-out data says that it is worth its name.

use evpose_sensor::SensorConfig;

use super::candidate_fit::fit_candidates;
use super::decision::{Worth, is_large_enough_to_try, is_worth_trying};
use super::direct_estimates::DirectEstimates;
use super::identification::{DataSplits, FittedCandidate, ModelScore};
use super::proposals::Proposals;
use super::screening::{ScreenedTrial, ScreeningBase};
use super::selection::{SelectedEffect, Selection};
use super::significance::difference;
use crate::GapError;
use crate::free_parameter::FreeParameter;

/// Candidates that are scored on held-out data.
const SCORED: usize = 4;
/// Candidates of each base that are fitted together with everything else.
const FITTED_TOGETHER: usize = 2;
/// Rounds of that fit.
const ROUNDS: usize = 2;
/// Models that candidates are fitted beside.
const BASES: usize = 2;

pub(super) struct Forward<'a> {
    pub(super) splits: &'a DataSplits<'a>,
    pub(super) proposals: &'a Proposals,
    pub(super) estimates: &'a DirectEstimates,
    /// Discrepancy of the model as given, beyond that of its own runs.
    pub(super) excess: f64,
    /// Discrepancy of its own runs.
    pub(super) chance: f64,
}

impl Forward<'_> {
    /// Adds the best candidate to a selection that is worth trying. Returns false if none is.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn step(
        &self,
        selection: &mut Selection,
        starts: &[SensorConfig],
    ) -> Result<bool, GapError> {
        for extended in self.extended(selection, starts)? {
            // The best by its discrepancy may fail the test on held-out data, and the next one pass
            // it.
            if self.is_worth_trying(selection, &extended)? {
                *selection = extended;
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether a second selection explains so much more on held-out data that it is worth trying.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn is_worth_trying(
        &self,
        selection: &Selection,
        extended: &Selection,
    ) -> Result<bool, GapError> {
        let without = selection.held_out.discrepancy;
        let gain = without - extended.held_out.discrepancy;
        // Replicates cost dozens of simulations; most candidates fail by size alone.
        if !is_large_enough_to_try(gain, without, self.excess) {
            return Ok(false);
        }
        let worth = Worth {
            difference: difference(&self.splits.held_out, &selection.model, &extended.model)?,
            without,
            excess: self.excess,
            candidates: self.proposals.len(),
        };
        Ok(is_worth_trying(&worth))
    }

    /// A selection with each of the best candidates added to it, the best first.
    ///
    /// The first candidates are fitted beside each of `starts` as well: a refit of the model's
    /// parameters may have absorbed what an effect does.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn extended(
        &self,
        selection: &Selection,
        starts: &[SensorConfig],
    ) -> Result<Vec<Selection>, GapError> {
        let mut bases = vec![selection.model.clone()];
        for start in starts {
            if !bases.contains(start) {
                bases.push(start.clone());
            }
        }
        // Where no candidate does well on the screen, none will beside this base.
        let mut screened = Vec::new();
        for base in bases {
            screened.push((self.promising(selection, &base, &|_| true)?, base));
        }
        let least = |proposed: &[ScreenedTrial]| {
            proposed.iter().map(|one| one.discrepancy).fold(f64::INFINITY, f64::min)
        };
        screened.sort_by(|a, b| least(&a.0).total_cmp(&least(&b.0)));
        screened.truncate(BASES);
        let mut extended = Vec::new();
        for (promising, base) in &screened {
            // A joint fit is the most expensive step: only the first by single fits get one.
            let scored = self.scored(self.fitted(selection, base, promising)?)?;
            for k in 0..scored.len().min(FITTED_TOGETHER) {
                let mut others: Vec<FittedCandidate> =
                    scored.iter().map(|(candidate, _)| candidate.clone()).collect();
                let candidate = others.remove(k);
                let mut with = selection.clone();
                with.model.clone_from(&candidate.fit.model);
                with.effects.push(SelectedEffect { candidate, rivals: others, is_proven: false });
                with.fit_together(self.splits, ROUNDS)?;
                if self.splits.resolves(&with) && self.allows(&with) {
                    extended.push(with);
                }
            }
        }
        extended.sort_by(|a, b| a.discrepancy().total_cmp(&b.discrepancy()));
        Ok(extended)
    }

    /// Whether all effects agree with what can be counted in the recording.
    fn allows(&self, selection: &Selection) -> bool {
        let effect = |one: &SelectedEffect| selection.model.effect(one.candidate.name);
        selection.effects.iter().filter_map(effect).all(|effect| self.estimates.allows(effect))
    }

    /// Candidates of some names that are better on the screen than a model with the effects of a selection.
    pub(super) fn promising(
        &self,
        selection: &Selection,
        model: &SensorConfig,
        is_of: &dyn Fn(&str) -> bool,
    ) -> Result<Vec<ScreenedTrial>, GapError> {
        let nuisance: Vec<FreeParameter> = selection.free_parameters();
        let screen = &self.splits.screen;
        let base = ScreeningBase::new(screen, self.estimates, model, nuisance)?;
        let is_free = |one: &ScreenedTrial| {
            if !is_of(one.name) {
                return false;
            }
            let added = one.trial.added_to(model);
            // A readout would replace another one that was selected.
            let keeps_others = selection
                .effects
                .iter()
                .all(|effect| added.effect(effect.candidate.name).is_some());
            !selection.has(one.name) && keeps_others && self.estimates.allows(&one.trial.effect)
        };
        let mut proposed = self.proposals.beside(&base, is_free)?;
        proposed.retain(|one| one.is_slow() || one.discrepancy < base.discrepancy_without);
        Ok(proposed)
    }

    /// Promising candidates fitted beside a model with the effects of a selection.
    pub(super) fn fitted(
        &self,
        selection: &Selection,
        model: &SensorConfig,
        promising: &[ScreenedTrial],
    ) -> Result<Vec<FittedCandidate>, GapError> {
        if promising.is_empty() {
            return Ok(Vec::new());
        }
        fit_candidates(&self.splits.train, model, promising, &selection.free_parameters())
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

//! Discovery: a formula for what no effect of the catalogue explains.
//!
//! # Method
//! Every term of a small grammar is screened beside the model so far, beside what of it holds, and beside
//! the model as given: refitted parameters and effects may have absorbed what the formula is for (behind a
//! threshold that drifts, two wrong names left a third of the gap, and no formula lowered it). One simulation
//! each, whose change is taken to be in proportion to the strength, says which terms are simulated at a grid of
//! strengths. The best are fitted to training data and scored on held-out data; the best of all is added if it
//! is worth a name by the test that effects have to pass, with the terms among the candidates that it was
//! chosen from.
//!
//! # Source
//! Sparse discrepancy models: Kaheman et al., *Learning Discrepancy Models from Experimental Data*,
//! arXiv 1909.08574, 2019.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use super::candidate_fit::fit_candidates;
use super::decision::{Worth, is_large_enough_to_try, is_worth_trying};
use super::formula_terms::{FORMULA, TERMS, Term};
use super::identification::FittedCandidate;
use super::places::{of_places, unlikeness};
use super::screening::{ScreenedTrial, ScreeningBase, sort};
use super::selection::{SelectedEffect, Selection};
use super::significance::difference;
use super::stepwise::Forward;
use crate::GapError;
use crate::candidate::{Trial, without_effect};

/// Terms that are simulated at more than one strength, and of these the ones that are fitted.
const SIMULATED: usize = 8;
const FITTED: usize = 4;
/// Fitted terms that are scored on held-out data, and of these the ones that are fitted together with
/// everything else.
const SCORED: usize = 3;
const FITTED_TOGETHER: usize = 2;
/// Rounds of that fit.
const ROUNDS: usize = 2;
/// Square of standard errors beyond which a formula is of other places, and the multiple of its discrepancy that one
/// of these may have: random values of a model lie in other places than the camera's.
const MIN_SQUARE: f64 = 9.0;
const MAX_WORSE: f64 = 2.0;
/// Stride in the grid of strengths.
const STRIDE: usize = 2;

/// A formula that is fitted beside a selection.
struct ScoredFormula {
    /// The sum of training and held-out data.
    discrepancy: f64,
    candidate: FittedCandidate,
}

impl Forward<'_> {
    /// The best formula beside a selection, beside what of it did not fail its tests (`failed`, indices of
    /// its effects), or in the place of all that was selected or refitted, beside `unfitted`; none if none is
    /// worth trying.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn formula(
        &self,
        selection: &Selection,
        failed: &[usize],
        unfitted: &Selection,
    ) -> Result<Option<Selection>, GapError> {
        let mut stands = selection.clone();
        for i in failed.iter().rev() {
            stands = stands.without(self.splits, *i, ROUNDS)?;
        }
        let mut bases = vec![selection];
        for other in [&stands, unfitted] {
            if bases.iter().all(|base| base.model != other.model) {
                bases.push(other);
            }
        }
        // Only the best beside any of them are fitted together with the rest, which takes longest.
        let mut scored = Vec::new();
        for base in bases {
            scored.extend(self.formulas_beside(base)?.into_iter().map(|one| (base, one)));
        }
        scored.sort_by(|(_, a), (_, b)| a.discrepancy.total_cmp(&b.discrepancy));
        scored.truncate(FITTED_TOGETHER);
        let mut found = Vec::new();
        for (base, ScoredFormula { candidate, .. }) in scored {
            let mut with = base.clone();
            with.model.clone_from(&candidate.fit.model);
            with.effects.push(SelectedEffect { candidate, rivals: Vec::new(), is_proven: false });
            with.fit_together(self.splits, ROUNDS)?;
            if self.splits.resolves(&with) {
                found.push(with);
            }
        }
        found.sort_by(|a, b| a.discrepancy().total_cmp(&b.discrepancy()));
        let failed: Vec<&str> =
            failed.iter().map(|i| selection.effects[*i].candidate.name).collect();
        for with in found {
            // A name that is not it explains nothing that a formula could not explain in its place.
            let is_in_place = !failed.is_empty()
                && !failed.iter().any(|name| with.has(name))
                && with.discrepancy() <= selection.discrepancy();
            let without = if is_in_place { &stands } else { selection };
            if self.is_worth_a_formula(without, &with)? {
                let moved = self.in_its_place(&with)?;
                let is_kept =
                    moved.model == with.model || !self.is_worth_a_formula(without, &moved)?;
                return Ok(Some(if is_kept { with } else { moved }));
            }
        }
        Ok(None)
    }

    /// The selection with the formula of those places that are alike in the recording.
    fn in_its_place(&self, with: &Selection) -> Result<Selection, GapError> {
        let Some(own) = with.model.effect(FORMULA).and_then(Term::of) else {
            return Ok(with.clone());
        };
        let terms = of_places(own);
        if terms.is_empty() {
            return Ok(with.clone());
        }
        let without = without_effect(&with.model, &with.given, FORMULA);
        let free = with.free_parameters_of_model();
        let base = ScreeningBase::new(&self.splits.screen, self.estimates, &without, free)?;
        let mut trials = Vec::new();
        for term in terms {
            let of_term = term.trials().into_par_iter().map(|trial| at_all_strengths(&base, trial));
            let mut of_term = of_term.collect::<Result<Vec<_>, GapError>>()?;
            // One that changes nothing at any strength has none.
            of_term.retain(|one| one.discrepancy.is_finite());
            sort(&mut of_term);
            trials.extend(of_term.into_iter().next().map(|best| (term, best.trial)));
        }
        let models: Vec<_> = trials.iter().map(|(_, trial)| trial.added_to(&without)).collect();
        let squares = unlikeness(&self.splits.train, &models, &without)?;
        let is_own = |i: &usize| std::ptr::eq(own, trials[*i].0);
        let own_square = (0..trials.len()).find(is_own).map_or(f64::INFINITY, |i| squares[i]);
        if own_square < MIN_SQUARE {
            return Ok(with.clone());
        }
        let mut best = (MAX_WORSE * with.discrepancy(), with.clone());
        for i in (0..trials.len()).filter(|i| squares[*i] < 0.5 * own_square) {
            let mut moved = with.clone();
            for effect in moved.effects.iter_mut().filter(|one| one.candidate.name == FORMULA) {
                effect.candidate.trial = trials[i].1.clone();
            }
            moved.model.clone_from(&models[i]);
            moved.fit_together(self.splits, ROUNDS)?;
            if moved.discrepancy() < best.0 {
                best = (moved.discrepancy(), moved);
            }
        }
        Ok(best.1)
    }

    fn is_worth_a_formula(&self, without: &Selection, with: &Selection) -> Result<bool, GapError> {
        let discrepancy = without.held_out.discrepancy;
        let gain = discrepancy - with.held_out.discrepancy;
        if !is_large_enough_to_try(gain, discrepancy, self.excess) {
            return Ok(false);
        }
        Ok(is_worth_trying(&Worth {
            difference: difference(&self.splits.held_out, &without.model, &with.model)?,
            without: discrepancy,
            excess: self.excess,
            candidates: self.proposals.len() + TERMS.len(),
        }))
    }

    /// The best formulas beside a selection, fitted to training data and scored.
    fn formulas_beside(&self, selection: &Selection) -> Result<Vec<ScoredFormula>, GapError> {
        if selection.has(FORMULA) {
            return Ok(Vec::new());
        }
        let proposals = self.screened_terms(&selection.model, selection)?;
        if proposals.is_empty() {
            return Ok(Vec::new());
        }
        let free = selection.free_parameters();
        let mut fitted = fit_candidates(&self.splits.train, &selection.model, &proposals, &free)?;
        fitted.truncate(SCORED);
        let scored = fitted.into_iter().map(|candidate| {
            let held_out = self.splits.score(&candidate.fit.model)?.discrepancy;
            Ok(ScoredFormula { discrepancy: held_out + candidate.fit.discrepancy, candidate })
        });
        scored.collect()
    }

    /// The best trial of each of the best terms, the best first.
    fn screened_terms(
        &self,
        model: &SensorConfig,
        selection: &Selection,
    ) -> Result<Vec<ScreenedTrial>, GapError> {
        let screen = &self.splits.screen;
        let base = ScreeningBase::new(screen, self.estimates, model, selection.free_parameters())?;
        let predicted = |trial: Trial| Ok((base.predicted(&trial)?, trial));
        let of_terms = TERMS.par_iter().map(|term| {
            let trials = term.trials().into_iter().map(predicted);
            let trials = trials.collect::<Result<Vec<_>, GapError>>()?.into_iter();
            Ok(trials.min_by(|a, b| a.0.total_cmp(&b.0)))
        });
        let of_terms = of_terms.collect::<Result<Vec<_>, GapError>>()?;
        let mut promising: Vec<(f64, Trial)> = of_terms.into_iter().flatten().collect();
        promising.sort_by(|a, b| a.0.total_cmp(&b.0));
        promising.truncate(SIMULATED);
        let simulated = promising.into_par_iter().map(|(_, trial)| at_all_strengths(&base, trial));
        let mut best = simulated.collect::<Result<Vec<_>, GapError>>()?;
        best.retain(|one| one.discrepancy < base.discrepancy_without);
        sort(&mut best);
        best.truncate(FITTED);
        Ok(best)
    }
}

/// The best of a grid of strengths of a term.
fn at_all_strengths(base: &ScreeningBase<'_>, trial: Trial) -> Result<ScreenedTrial, GapError> {
    let (strengths, is_rising) = trial.rising();
    let strengths: Vec<f64> = strengths.into_iter().step_by(STRIDE).collect();
    let (discrepancy, tried) = (f64::INFINITY, Vec::new());
    let fresh = ScreenedTrial { name: FORMULA, trial, discrepancy, tried };
    base.best_of(&fresh, &strengths, is_rising)
}

//! Discovery: a formula for what no effect of the catalogue explains.
//!
//! # Method
//! Every term of a small grammar is screened at a grid of its constants beside the model so far, beside
//! what of it holds, and beside the model as given: refitted parameters and effects may have absorbed what
//! the formula is for (behind a threshold that drifts, two wrong names left a third of the gap, and no
//! formula lowered it). The best terms are fitted to training data and scored on held-out data; the best is
//! added if it is worth a name by the test that effects have to pass, with the terms among the candidates
//! that it was chosen from.
//!
//! # Source
//! Sparse discrepancy models: Kaheman et al., *Learning Discrepancy Models from Experimental Data*,
//! arXiv 1909.08574, 2019.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use super::candidate_fit::fit_candidates;
use super::decision::{Worth, is_large_enough_to_try, is_worth_trying};
use super::formula_terms::{FORMULA, TERMS};
use super::screening::{ScreenedTrial, ScreeningBase, sort};
use super::selection::{SelectedEffect, Selection};
use super::significance::difference;
use super::stepwise::Forward;
use crate::GapError;
use crate::candidate::Trial;

/// Terms that are fitted.
const FITTED: usize = 6;
/// Fitted terms that are scored on held-out data, and of these the ones that are fitted together with
/// everything else.
const SCORED: usize = 3;
const FITTED_TOGETHER: usize = 2;
/// Rounds of that fit.
const ROUNDS: usize = 2;
/// Stride in the grid of strengths.
const STRIDE: usize = 2;

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
        let found = bases.into_iter().map(|base| self.formulas_beside(base));
        let mut found = found.collect::<Result<Vec<_>, GapError>>()?.concat();
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
                return Ok(Some(with));
            }
        }
        Ok(None)
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

    /// Selections with the best formulas added, fitted together with everything else.
    fn formulas_beside(&self, selection: &Selection) -> Result<Vec<Selection>, GapError> {
        if selection.has(FORMULA) {
            return Ok(Vec::new());
        }
        let proposals = self.screened_terms(&selection.model, selection)?;
        if proposals.is_empty() {
            return Ok(Vec::new());
        }
        let splits = self.splits;
        let free = selection.free_parameters();
        let mut fitted = fit_candidates(&splits.train, &selection.model, &proposals, &free)?;
        fitted.truncate(SCORED);
        let mut scored = fitted
            .into_iter()
            .map(|one| Ok((splits.score(&one.fit.model)?.discrepancy + one.fit.discrepancy, one)))
            .collect::<Result<Vec<_>, GapError>>()?;
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut found = Vec::new();
        for (_, candidate) in scored.into_iter().take(FITTED_TOGETHER) {
            let mut with = selection.clone();
            with.model.clone_from(&candidate.fit.model);
            with.effects.push(SelectedEffect { candidate, rivals: Vec::new(), is_proven: false });
            with.fit_together(splits, ROUNDS)?;
            if splits.resolves(&with) {
                found.push(with);
            }
        }
        Ok(found)
    }

    /// The best trial of each of the best terms, the best first.
    fn screened_terms(
        &self,
        model: &SensorConfig,
        selection: &Selection,
    ) -> Result<Vec<ScreenedTrial>, GapError> {
        let screen = &self.splits.screen;
        let base = ScreeningBase::new(screen, self.estimates, model, selection.free_parameters())?;
        let screened = |trial: Trial| {
            let (strengths, is_rising) = trial.rising();
            let strengths: Vec<f64> = strengths.into_iter().step_by(STRIDE).collect();
            let (discrepancy, tried) = (f64::INFINITY, Vec::new());
            let fresh = ScreenedTrial { name: FORMULA, trial, discrepancy, tried };
            base.best_of(&fresh, &strengths, is_rising)
        };
        let of_terms = TERMS.par_iter().map(|term| {
            let mut trials =
                term.trials().into_iter().map(screened).collect::<Result<Vec<_>, GapError>>()?;
            sort(&mut trials);
            Ok(trials.into_iter().next())
        });
        let of_terms = of_terms.collect::<Result<Vec<_>, GapError>>()?;
        let mut best: Vec<ScreenedTrial> = of_terms.into_iter().flatten().collect();
        best.retain(|one| one.discrepancy < base.discrepancy_without);
        sort(&mut best);
        best.truncate(FITTED);
        Ok(best)
    }
}

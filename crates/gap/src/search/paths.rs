//! Paths of forward selection: from a model to where no effect is worth trying.
//!
//! # Method
//! Steps are greedy. Where they lead to a part of an explanation only, the recording is explained
//! once more without changes of the model's thresholds and clock, and from other first effects.

use evpose_sensor::SensorConfig;

use super::StageCallback;
use super::decision::{is_partial, is_within_tolerance};
use super::selection::Selection;
use super::stepwise::Forward;
use crate::GapError;
use crate::candidate::without_effect;
use crate::parameters::{ModelParameter, with_given_parameters};

/// Effects that another path may add before it is given up, and the multiple of the discrepancy that
/// is to be beaten above which it is.
const STEPS_BEFORE_GIVING_UP: usize = 2;
const FAR_ABOVE: f64 = 1.5;
const MAX_EFFECTS: usize = 10;
/// Rounds of the fit of effects beside the parameters as given.
const ROUNDS: usize = 2;

impl Forward<'_> {
    /// Adds effects until none is worth trying, the best first; the first one beside each of `starts`
    /// as well. Returns whether the search ended because its time was over.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn run(
        &self,
        selection: &mut Selection,
        starts: &[SensorConfig],
        progress: StageCallback<'_>,
    ) -> Result<bool, GapError> {
        self.run_towards(selection, starts, f64::INFINITY, progress)
    }

    /// As [`Self::run`]; given up where the discrepancy stays far above `goal`, which is known from
    /// elsewhere.
    fn run_towards(
        &self,
        selection: &mut Selection,
        starts: &[SensorConfig],
        goal: f64,
        progress: StageCallback<'_>,
    ) -> Result<bool, GapError> {
        let mut starts = starts;
        let count = selection.effects.len();
        while selection.effects.len() < MAX_EFFECTS && !is_within_tolerance(&selection.held_out) {
            // Two effects may help only together; after two, a path far from the goal does not
            // catch up.
            let is_begun = selection.effects.len() >= count + STEPS_BEFORE_GIVING_UP;
            if is_begun && selection.discrepancy() > FAR_ABOVE * goal {
                break;
            }
            if self.splits.budget.is_some_and(|budget| !budget.allows_finding()) {
                return Ok(true);
            }
            progress(&format!("adding an effect to: {}", selection.names()));
            if !self.step(selection, starts)? {
                break;
            }
            // Later effects are fitted beside a model with effects, in which no parameter has
            // absorbed them.
            starts = &[];
        }
        Ok(false)
    }

    /// As [`Self::run`], where the candidates that came next at the beginning are followed as well
    /// if the best one leads to a part of an explanation only: alone it may stand for two others.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    fn run_all_paths(
        &self,
        selection: &mut Selection,
        goal: f64,
        progress: StageCallback<'_>,
    ) -> Result<(), GapError> {
        if is_within_tolerance(&selection.held_out) {
            return Ok(());
        }
        progress(&format!("adding an effect to: {}", selection.names()));
        let mut paths = Vec::new();
        for extended in self.extended(selection, &[])? {
            if self.is_worth_trying(selection, &extended)? {
                paths.push(extended);
            }
        }
        // The first complete explanation ends it: paths are in order of their first step.
        for mut path in paths {
            let is_cut = self.run_towards(&mut path, &[], goal, progress)?;
            if path.discrepancy() < selection.discrepancy() {
                *selection = path;
            }
            if is_cut || !self.is_partial(selection) {
                break;
            }
        }
        Ok(())
    }

    pub(super) fn is_partial(&self, selection: &Selection) -> bool {
        let left = (selection.held_out.discrepancy - self.chance) / self.excess.max(1e-9);
        is_partial(&selection.held_out, left)
    }

    /// Explains a recording without changes of the model's thresholds and clock, which may have
    /// absorbed what effects do: beside the effects of a selection, or, where that explains a part only,
    /// from the start.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn with_parameters_as_given(
        &self,
        selection: &Selection,
        progress: StageCallback<'_>,
    ) -> Result<Selection, GapError> {
        let goal = selection.discrepancy();
        let mut beside = self.reset(selection)?;
        self.run_towards(&mut beside, &[], goal, progress)?;
        if self.is_partial(&beside) {
            // Effects that stamps prove hold whatever the parameters are; all others are sought
            // again.
            let mut proven = selection.clone();
            for effect in selection.effects.iter().filter(|effect| !effect.is_proven) {
                let name = effect.candidate.name;
                proven.model = without_effect(&proven.model, &selection.given, name);
            }
            proven.effects.retain(|effect| effect.is_proven);
            let mut from_start = self.reset(&proven)?;
            self.run_all_paths(&mut from_start, goal.min(beside.discrepancy()), progress)?;
            if from_start.discrepancy() < beside.discrepancy() {
                beside = from_start;
            }
        }
        Ok(beside)
    }

    /// A selection with its effects and the parameters of the model as given; only the background
    /// rates are fitted: noise of the light would stand for both rates otherwise.
    fn reset(&self, selection: &Selection) -> Result<Selection, GapError> {
        let mut other = selection.clone();
        other.model = with_given_parameters(&selection.model, &selection.given);
        other.fitted = vec![ModelParameter::NoiseOn, ModelParameter::NoiseOff];
        other.fit_together(self.splits, ROUNDS)?;
        Ok(other)
    }
}

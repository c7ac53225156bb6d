//! The search as a whole: refit, forward selection, pairs, swap.
//!
//! The model's own parameters come first: a gap that refitting them closes is a wrong parameter.
//! Effects are then added one after the other, fitted on training data and scored on held-out data,
//! as long as each clearly improves the score. An effect is identified only where it explains most
//! of the gap and no other does so as well.

use evpose_sensor::SensorConfig;

use super::StageCallback;
use super::decision::{
    CLOSED, LIKE_CHANCE, changed_parameters, decide, drop_partial_effects, is_partial,
};
use super::direct_estimates::DirectEstimates;
use super::forward_step::{MIN_GAIN, accepted};
use super::identification::{DataSplits, Identification, SCORE_RUNS};
use super::refit::refit;
use crate::GapError;
use crate::parameters::ModelParameter;
use crate::verdict::Answer;

/// Effects that are added at most. Recordings hardly ever constrain three effects at once.
const MAX_EFFECTS: usize = 2;

impl DataSplits<'_> {
    /// Identifies the effects that `model` lacks; those of `left_out` are excluded from the search.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn identify(
        &self,
        model: &SensorConfig,
        left_out: &[String],
        progress: StageCallback<'_>,
    ) -> Result<Identification, GapError> {
        let before = self.score(model)?;
        let (_, gap_of_train) = self.train.score(model, SCORE_RUNS)?;
        if before.gap.max(gap_of_train) <= CLOSED {
            return Ok(Identification {
                answer: Answer::NoGap,
                refitted: before.clone(),
                after: before.clone(),
                added_effects: Vec::new(),
                changed_parameters: Vec::new(),
                before,
            });
        }
        progress("refitting the parameters of the model");
        let fit = refit(&self.train, model, 1)?;
        let mut refitted = self.score(&fit.model)?;
        if refitted.discrepancy > before.discrepancy - MIN_GAIN {
            refitted = before.clone();
        }
        let mut result = Identification {
            answer: Answer::NoGap,
            changed_parameters: Vec::new(),
            after: refitted.clone(),
            added_effects: Vec::new(),
            before,
            refitted,
        };
        let estimates = DirectEstimates::from_events(&self.train.events);
        let mut alone = Vec::new();
        while result.added_effects.len() < MAX_EFFECTS && needs_effect(&result, model) {
            progress("trying every effect of the catalogue");
            let contenders = self.contenders(&result, model, &estimates, left_out)?;
            if result.added_effects.is_empty() {
                alone.clone_from(&contenders);
            }
            let Some(added) = accepted(&result, contenders) else { break };
            result.after = added.contenders[0].held_out.clone();
            result.added_effects.push(added);
        }
        if result.added_effects.len() == MAX_EFFECTS && is_partial(&result) {
            self.refine_together(&mut result)?;
        }
        if is_partial(&result) {
            progress("trying pairs of effects");
            if let Some(pair) = self.pair(&result, &alone, model, &estimates, left_out)? {
                result = pair;
            }
        }
        if !is_partial(&result) {
            self.swap_first(&mut result)?;
        }
        drop_partial_effects(&mut result, model);
        let is_refit = result.added_effects.is_empty();
        result.changed_parameters = changed_parameters(model, &result.after.model, is_refit);
        result.answer = decide(&result);
        Ok(result)
    }
}

/// Whether the gap that is left calls for another effect.
fn needs_effect(result: &Identification, model: &SensorConfig) -> bool {
    if !result.added_effects.is_empty() {
        return result.after.gap > LIKE_CHANCE;
    }
    // Where rates are free, a refit absorbs effects with noise of their own into the background.
    let is_rate =
        |p: &ModelParameter| matches!(p, ModelParameter::NoiseOn | ModelParameter::NoiseOff);
    result.after.gap > CLOSED
        || changed_parameters(model, &result.after.model, true).iter().any(is_rate)
}

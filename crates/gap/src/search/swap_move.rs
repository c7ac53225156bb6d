//! Swap move: the first of two effects is tested again beside the second. It is dropped if the
//! second explains the recording alone, and swapped for a rival that does better beside the second.

use evpose_sensor::SensorConfig;

use super::decision::is_partial;
use super::forward_step::{MIN_FRACTION_OF_LITTLE, MIN_GAIN, confusable};
use super::identification::{AddedEffect, Contender, DataSplits, Identification, ModelScore};
use crate::GapError;
use crate::candidate::{Trial, without_effect};
use crate::fit::descend;
use crate::free_parameter::FreeParameter;

/// Rivals that are tried in the place of an effect.
const RIVALS: usize = 2;
/// Decrease of the discrepancy by which a rival is clearly better; equivalent candidates differ by
/// less.
const CLEARLY_BETTER: f64 = MIN_GAIN / 2.0;
/// Gauss-Newton rounds of each fit.
const ROUNDS: usize = 3;

impl DataSplits<'_> {
    /// Tries to drop the first of two effects, then to swap it for each of its rivals. A rival that
    /// is clearly better replaces it; the others become the contenders that it is compared with.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn swap_first(&self, result: &mut Identification) -> Result<(), GapError> {
        let [first, second] = result.added_effects.as_slice() else { return Ok(()) };
        let candidate = first.contenders[0].candidate.clone();
        let names = [second.name(), candidate.name];
        let base = without_effect(&result.after.model, candidate.name);
        let without = self.score(&base)?.discrepancy;
        let gain = without - result.after.discrepancy;
        if gain < MIN_GAIN.max(MIN_FRACTION_OF_LITTLE * without) {
            // The second explains what the first was added for, unless it leaves too much alone.
            let alone = self.second_alone(result, &base)?;
            if !is_partial(&alone) {
                *result = alone;
                return Ok(());
            }
        }
        let is_other = |rival: &&Contender| !names.contains(&rival.candidate.name);
        let rivals: Vec<_> =
            first.contenders.iter().skip(1).filter(is_other).take(RIVALS).collect();
        let mut contenders = vec![Contender { candidate, held_out: result.after.clone() }];
        contenders.extend(self.refit_rivals(&rivals, &base)?);
        let is_better =
            |one: &Contender| one.held_out.discrepancy + CLEARLY_BETTER < result.after.discrepancy;
        let is_swapped = contenders.get(1).is_some_and(is_better);
        if is_swapped {
            contenders.swap(0, 1);
            result.after = contenders[0].held_out.clone();
        }
        let gain = without - result.after.discrepancy;
        let confusable = confusable(&contenders, gain);
        result.added_effects[0] =
            AddedEffect { contenders, confusable, discrepancy_without: without };
        if is_swapped && let Some(second) = result.added_effects.pop() {
            result.added_effects.push(self.rescore(&second, &result.after)?);
        }
        Ok(())
    }

    /// Fits the second of two effects alone, added to the model without the first.
    fn second_alone(
        &self,
        result: &Identification,
        without_first: &SensorConfig,
    ) -> Result<Identification, GapError> {
        let mut alone = result.clone();
        let second = alone.added_effects.remove(1);
        let free = FreeParameter::of_effect(&second.contenders[0].candidate.trial);
        let fit = descend(&self.train, without_first, &free, None, 1, ROUNDS)?;
        alone.after = self.score(&fit.model)?;
        alone.added_effects = vec![self.rescore(&second, &alone.after)?];
        Ok(alone)
    }

    /// Scores an added effect and its rivals again after the other effects of the model have
    /// changed.
    fn rescore(&self, added: &AddedEffect, after: &ModelScore) -> Result<AddedEffect, GapError> {
        let base = without_effect(&after.model, added.name());
        let without = self.score(&base)?.discrepancy;
        let rivals: Vec<_> = added.contenders.iter().skip(1).take(RIVALS).collect();
        let rivals = self.refit_rivals(&rivals, &base)?;
        let candidate = added.contenders[0].candidate.clone();
        let mut contenders = vec![Contender { candidate, held_out: after.clone() }];
        contenders.extend(rivals);
        let confusable = confusable(&contenders, without - after.discrepancy);
        Ok(AddedEffect { contenders, confusable, discrepancy_without: without })
    }

    /// Fits and scores candidates added to `base`, the best first. The fits start from the
    /// parameters that the candidates were fitted with before.
    fn refit_rivals(
        &self,
        rivals: &[&Contender],
        base: &SensorConfig,
    ) -> Result<Vec<Contender>, GapError> {
        let refit = |rival: &&Contender| {
            let candidate = rival.candidate.clone();
            let known = rival.held_out.model.effect(candidate.name);
            let effect = known.unwrap_or(&candidate.trial.effect).clone();
            let trial = Trial { effect, params: candidate.trial.params.clone() };
            let free = FreeParameter::of_effect(&trial);
            let fit = descend(&self.train, &trial.added_to(base), &free, None, 1, ROUNDS)?;
            Ok(Contender { candidate, held_out: self.score(&fit.model)? })
        };
        let mut contenders = rivals.iter().map(refit).collect::<Result<Vec<_>, GapError>>()?;
        contenders.sort_by(|a, b| a.held_out.discrepancy.total_cmp(&b.held_out.discrepancy));
        Ok(contenders)
    }
}

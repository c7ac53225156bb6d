//! The first of two effects once the second is known: what came close to it alone may do as well
//! beside the other, or better.

use evpose_sensor::SensorConfig;

use crate::GapError;
use crate::answer::is_partial;
use crate::candidate::Trial;
use crate::fit::descend;
use crate::naming::{Bench, Contender, Judged, Named, Step};
use crate::search::own;
use crate::step::{LEAST_GAIN, LEAST_SHARE_OF_LITTLE, is_as_good};

/// Rivals that are put in its place.
const RIVALS: usize = 2;
/// A rival is clearly better by so much of the misfit: what two candidates that are alike differ by.
const CLEARLY: f64 = LEAST_GAIN / 2.0;
/// Rounds of their fits.
const ROUNDS: usize = 3;

impl Bench<'_> {
    /// Puts rivals of the first of two effects in its place. One that does clearly better stays
    /// there; the others become what the first is compared with.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(crate) fn exchange(&self, named: &mut Named) -> Result<(), GapError> {
        let [first, second] = named.steps.as_slice() else { return Ok(()) };
        let found = first.contenders[0].found.clone();
        let kept = second.contenders[0].found.name;
        let without = without(&named.after.model, found.name);
        let left = self.judge(&without)?.misfit;
        if left - named.after.misfit < LEAST_GAIN.max(LEAST_SHARE_OF_LITTLE * left) {
            // The second does what the first was taken for, unless too much is left then.
            let alone = self.second_alone(named, &without)?;
            if !is_partial(&alone) {
                *named = alone;
                return Ok(());
            }
        }
        let is_other = |rival: &&Contender| ![kept, found.name].contains(&rival.found.name);
        let rivals: Vec<_> =
            first.contenders.iter().skip(1).filter(is_other).take(RIVALS).collect();
        let mut contenders = vec![Contender { found, held: named.after.clone() }];
        for rival in rivals {
            let held = self.fitted_beside(rival, &without)?;
            contenders.push(Contender { found: rival.found.clone(), held });
        }
        contenders[1..].sort_by(|a, b| a.held.misfit.total_cmp(&b.held.misfit));
        let is_better = |one: &Contender| one.held.misfit + CLEARLY < named.after.misfit;
        let is_swapped = contenders.get(1).is_some_and(is_better);
        if is_swapped {
            contenders.swap(0, 1);
            named.after = contenders[0].held.clone();
        }
        let gain = left - named.after.misfit;
        let is_as_good = |other: &&Contender| is_as_good(other, &contenders[0], gain);
        let confusable = contenders.iter().skip(1).filter(is_as_good).map(|one| one.found.name);
        named.steps[0].confusable = confusable.collect();
        named.steps[0].without = left;
        named.steps[0].contenders = contenders;
        if is_swapped && let Some(second) = named.steps.pop() {
            named.steps.push(self.judged_anew(second, &named.after)?);
        }
        Ok(())
    }

    /// The second of two effects alone, fitted again.
    fn second_alone(&self, named: &Named, without: &SensorConfig) -> Result<Named, GapError> {
        let mut alone = named.clone();
        let second = alone.steps.remove(1);
        let trial = &second.contenders[0].found.trial;
        let fit = descend(&self.train, without, &own(trial), None, 1, ROUNDS)?;
        alone.after = self.judge(&fit.model)?;
        alone.steps = vec![self.judged_anew(second, &alone.after)?];
        Ok(alone)
    }

    /// A step of which what is beside it has changed: what it is compared with is fitted again there.
    fn judged_anew(&self, mut step: Step, after: &Judged) -> Result<Step, GapError> {
        let bare = without(&after.model, step.contenders[0].found.name);
        step.without = self.judge(&bare)?.misfit;
        let rivals = step.contenders.split_off(1);
        step.contenders[0].held = after.clone();
        for rival in rivals.into_iter().take(RIVALS) {
            let held = self.fitted_beside(&rival, &bare)?;
            step.contenders.push(Contender { found: rival.found, held });
        }
        step.contenders[1..].sort_by(|a, b| a.held.misfit.total_cmp(&b.held.misfit));
        let (best, gain) = (&step.contenders[0], step.without - after.misfit);
        let as_good = step.contenders.iter().skip(1).filter(|one| is_as_good(one, best, gain));
        step.confusable = as_good.map(|one| one.found.name).collect();
        Ok(step)
    }

    /// A candidate, with the numbers that it was fitted with alone, fitted again beside `model`.
    fn fitted_beside(&self, one: &Contender, model: &SensorConfig) -> Result<Judged, GapError> {
        let known = one.held.model.effect(one.found.name);
        let effect = known.unwrap_or(&one.found.trial.effect).clone();
        let trial = Trial { effect, params: one.found.trial.params.clone() };
        let fit = descend(&self.train, &trial.beside(model), &own(&trial), None, 1, ROUNDS)?;
        self.judge(&fit.model)
    }
}

/// A model without an effect.
pub(crate) fn without(model: &SensorConfig, name: &str) -> SensorConfig {
    let mut model = model.clone();
    model.effects.retain(|effect| effect.name != name);
    model
}

//! Two effects of which neither explains enough alone, or which hide each other: those that came
//! close are looked at with another beside them.

use evpose_sensor::SensorConfig;

use crate::answer::is_partial;
use crate::fit::Fit;
use crate::hint::Hints;
use crate::naming::{Bench, Contender, Named, Step};
use crate::screen::{Screening, screened};
use crate::search::{Found, judged};
use crate::{GapError, Lab};

/// Candidates that are looked at with another beside them, on the screen.
const FIRST: usize = 5;
/// Those of them that are followed.
const FOLLOWED: usize = 2;

impl Bench<'_> {
    /// A pair that explains most of what `named` leaves: one of `others`, which were tried alone, or
    /// a readout that stamps leave no doubt about, with another effect beside it.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(crate) fn pair(
        &self,
        named: &Named,
        others: Vec<Contender>,
        model: &SensorConfig,
        hints: &Hints,
        left_out: &[String],
    ) -> Result<Option<Named>, GapError> {
        let mut firsts: Vec<Contender> =
            self.sure_readout(named, hints, left_out)?.into_iter().collect();
        for other in others {
            let is_tried =
                named.steps.first().is_some_and(|s| s.contenders[0].name() == other.name());
            if !is_tried && firsts.iter().all(|first| first.name() != other.name()) {
                firsts.push(other);
            }
        }
        firsts.truncate(FIRST);
        let mut firsts = firsts
            .into_iter()
            .map(|first| Ok((self.promise(&first, hints, left_out)?, first)))
            .collect::<Result<Vec<_>, GapError>>()?;
        firsts.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, first) in firsts.into_iter().take(FOLLOWED) {
            let mut pair = named.clone();
            pair.after = first.held.clone();
            pair.steps = vec![Step { contenders: vec![first], confusable: Vec::new() }];
            let Some(step) = self.step(&pair, model, hints, left_out)? else { continue };
            pair.after = step.contenders[0].held.clone();
            pair.steps.push(step);
            if !is_partial(&pair) && pair.after.misfit < named.after.misfit {
                return Ok(Some(pair));
            }
        }
        Ok(None)
    }

    /// The readout that stamps leave no doubt about: pixels that have more events than the camera's
    /// keep its bus busier, so that it may not help alone.
    fn sure_readout(
        &self,
        named: &Named,
        hints: &Hints,
        left_out: &[String],
    ) -> Result<Option<Contender>, GapError> {
        let Some((name, trial)) = hints.sure(&named.before.model, left_out) else {
            return Ok(None);
        };
        let with = trial.beside(&named.before.model);
        let fit = Fit { misfit: judged(&self.train, &with, 1)?.0, model: with.clone() };
        Ok(Some(Contender { found: Found { name, fit, trial }, held: self.judge(&with)? }))
    }

    /// What the screen leaves of the misfit with the best that is beside a candidate.
    fn promise(
        &self,
        first: &Contender,
        hints: &Hints,
        left_out: &[String],
    ) -> Result<f64, GapError> {
        let screen: &Lab<'_> = &self.screen;
        let beside = Screening::new(screen, hints, &first.held.model)?;
        let best = screened(&[beside], left_out)?;
        Ok(best.first().map_or(f64::INFINITY, |way| way.left))
    }
}

impl Contender {
    fn name(&self) -> &'static str {
        self.found.name
    }
}

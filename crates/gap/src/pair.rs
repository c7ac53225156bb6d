//! Two effects of which neither explains enough alone, or which hide each other: those that came
//! close are looked at with another beside them.

use evpose_sensor::SensorConfig;

use crate::answer::{is_partial, moved};
use crate::fit::Fit;
use crate::hint::Hints;
use crate::naming::{Bench, Contender, Named, Step};
use crate::screen::{Screening, screened};
use crate::search::{Found, judged};
use crate::{GapError, Lab};

/// A candidate explains this share of the misfit alone, if not more.
const LEAST_SHARE: f64 = 0.03;
/// Candidates that are followed, of those that were looked at on the screen.
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
        others: &[Contender],
        model: &SensorConfig,
        hints: &Hints,
        left_out: &[String],
    ) -> Result<Option<Named>, GapError> {
        if let Some(readout) = self.sure_readout(named, hints, left_out)? {
            let firsts = [vec![readout], others.to_vec()].concat();
            if let Some(pair) = self.beside(firsts, named, model, hints, left_out)? {
                return Ok(Some(pair));
            }
        }
        let tried = named.steps.first().map(|step| step.contenders[0].found.name);
        let is_new = |other: &&Contender| Some(other.found.name) != tried && does(other, named);
        let firsts = others.iter().filter(is_new);
        let mut firsts = firsts
            .map(|first| Ok((self.promise(first, hints, left_out)?, first)))
            .collect::<Result<Vec<_>, GapError>>()?;
        firsts.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, first) in firsts.into_iter().take(FOLLOWED) {
            let rivals = others.iter().filter(|other| other.found.name != first.found.name);
            let firsts = std::iter::once(first).chain(rivals).cloned().collect();
            if let Some(pair) = self.beside(firsts, named, model, hints, left_out)? {
                return Ok(Some(pair));
            }
        }
        Ok(None)
    }

    /// The best effect beside the first of some contenders, if both explain most of what `named` leaves.
    fn beside(
        &self,
        firsts: Vec<Contender>,
        named: &Named,
        model: &SensorConfig,
        hints: &Hints,
        left_out: &[String],
    ) -> Result<Option<Named>, GapError> {
        let mut pair = named.clone();
        pair.after = firsts[0].held.clone();
        let without = named.before.misfit;
        pair.steps = vec![Step { contenders: firsts, confusable: Vec::new(), without }];
        let Some(step) = self.step(&pair, model, hints, left_out)? else { return Ok(None) };
        pair.after = step.contenders[0].held.clone();
        pair.steps.push(step);
        Ok((!is_partial(&pair) && pair.after.misfit < named.after.misfit).then_some(pair))
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

/// Whether a candidate does something beside the numbers that it was fitted with.
fn does(other: &Contender, named: &Named) -> bool {
    let is_beside_refit = moved(&named.refitted.model, &other.held.model, true).is_empty();
    let without = if is_beside_refit { &named.refitted } else { &named.before };
    other.held.misfit < (1.0 - LEAST_SHARE) * without.misfit
}

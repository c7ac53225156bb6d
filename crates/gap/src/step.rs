//! One effect more: every candidate beside what was found so far, judged on what was held out.

use evpose_sensor::SensorConfig;

use crate::GapError;
use crate::answer::{WIDE, is_instead, numbers_explain};
use crate::closeness::distance;
use crate::hint::Hints;
use crate::naming::{AS_CHANCE, Bench, Contender, Named, OPEN, Step};
use crate::parameters::with_given_numbers;
use crate::search::search;

/// A gain of the held-out misfit below this is none, whatever the share.
pub(crate) const LEAST_GAIN: f64 = 35.0;
/// An effect explains at least this share of the misfit that was left.
const LEAST_SHARE: f64 = 0.18;
/// The same where there is hardly a gap.
pub(crate) const LEAST_SHARE_OF_LITTLE: f64 = 0.4;
/// The same where numbers of the model or a first effect explain most: a true effect explains most
/// of the rest, a false one what these were simulated too roughly for.
const LEAST_SHARE_OF_REST: f64 = 0.55;
/// The same for a second effect where the first leaves a wide gap.
const LEAST_SHARE_OF_MUCH: f64 = 0.3;
/// Two candidates whose gains differ by less than this share cannot be told apart.
const AS_GOOD: f64 = 0.12;
/// Of these, one whose events are so much closer to the measured ones is the one.
const CLOSER: f64 = 0.92;
/// Beyond the best and one rival, candidates with a misfit so many times that of the best are not.
const FAR_BEHIND: f64 = 5.0;
/// Another form of a candidate is judged too if its misfit is at most so many times that of the best.
const FORMS: f64 = 1.5;
/// Candidates that are judged on what was held out.
const JUDGED: usize = 6;

impl Bench<'_> {
    /// The next effect, if one makes things clearly better.
    pub(crate) fn step(
        &self,
        named: &Named,
        model: &SensorConfig,
        hints: &Hints,
        left_out: &[String],
    ) -> Result<Option<Step>, GapError> {
        Ok(accepted(named, self.contenders(named, model, hints, left_out)?))
    }

    /// Candidates for the next effect, the best on what was held out first.
    pub(crate) fn contenders(
        &self,
        named: &Named,
        model: &SensorConfig,
        hints: &Hints,
        left_out: &[String],
    ) -> Result<Vec<Contender>, GapError> {
        let mut starts = vec![named.after.model.clone()];
        // An effect may do what a refit of the numbers has taken on itself.
        let given = with_given_numbers(&named.after.model, model);
        if given != named.after.model {
            starts.push(given);
        }
        let found = search(&self.screen, &self.train, model, &starts, hints, left_out)?;
        let mut contenders: Vec<Contender> = Vec::new();
        for found in found {
            // Forms of one effect that differ by little here may differ by much in another scene.
            let is_known = |other: &Contender| {
                other.found.name == found.name
                    && (other.found.trial.is_form_of(&found.trial)
                        || found.fit.misfit > FORMS * other.found.fit.misfit + LEAST_GAIN)
            };
            if contenders.iter().any(is_known) {
                continue;
            }
            let least = contenders.iter().map(|c| c.found.fit.misfit).fold(f64::INFINITY, f64::min);
            if contenders.len() > 1 && found.fit.misfit > FAR_BEHIND * least {
                break;
            }
            let held = self.judge(&found.fit.model)?;
            contenders.push(Contender { found, held });
            if contenders.len() == JUDGED {
                break;
            }
        }
        contenders.sort_by(|a, b| a.held.misfit.total_cmp(&b.held.misfit));
        let mut names = Vec::new();
        contenders.retain(|one| {
            let is_new = !names.contains(&one.found.name);
            names.push(one.found.name);
            is_new
        });
        if named.steps.is_empty() {
            self.closest_first(&mut contenders, named.after.misfit)?;
        }
        Ok(contenders)
    }

    /// Puts the candidate first whose events are closest to the measured ones, of those that are as
    /// good as the first.
    fn closest_first(&self, contenders: &mut [Contender], misfit: f64) -> Result<(), GapError> {
        let Some(best) = contenders.first() else { return Ok(()) };
        let gain = misfit - best.held.misfit;
        if gain < LEAST_GAIN {
            return Ok(());
        }
        let rivals = contenders.iter().skip(1).take_while(|other| is_as_good(other, best, gain));
        let (mut first, mut least) = (0, None);
        for i in 1..=rivals.count() {
            let of_first = match least {
                Some(known) => known,
                None => distance(&self.held, &contenders[0].held.model)?,
            };
            let other = distance(&self.held, &contenders[i].held.model)?;
            let is_closer = other < CLOSER * of_first;
            (first, least) = if is_closer { (i, Some(other)) } else { (first, Some(of_first)) };
        }
        contenders[..=first].rotate_right(1);
        Ok(())
    }
}

/// The first of some candidates, if it makes things clearly better.
pub(crate) fn accepted(named: &Named, contenders: Vec<Contender>) -> Option<Step> {
    let best = contenders.first()?;
    let gain = named.after.misfit - best.held.misfit;
    // What numbers of the model close already has to be much better another way.
    let is_first = named.steps.is_empty();
    let least_share = match () {
        () if is_first && is_instead(named, &best.held) => LEAST_SHARE,
        () if !is_first && named.after.gap > WIDE => LEAST_SHARE_OF_MUCH,
        () if !is_first || numbers_explain(named) => LEAST_SHARE_OF_REST,
        () if named.after.gap > OPEN => LEAST_SHARE,
        () => LEAST_SHARE_OF_LITTLE,
    };
    // What is nearly closed has to be closed altogether.
    let is_enough = is_first || !named.is_nearly_closed() || best.held.gap < AS_CHANCE;
    if gain < LEAST_GAIN.max(least_share * named.after.misfit) || !is_enough {
        return None;
    }
    let is_as_good = |other: &&Contender| is_as_good(other, best, gain);
    let confusable = contenders.iter().skip(1).filter(is_as_good).map(|c| c.found.name).collect();
    Some(Step { contenders, confusable, without: named.after.misfit })
}

/// Whether two candidates cannot be told apart by what was held out, of which the better gains so
/// much.
pub(crate) fn is_as_good(other: &Contender, best: &Contender, gain: f64) -> bool {
    other.held.misfit - best.held.misfit < (AS_GOOD * gain).max(LEAST_GAIN / 2.0)
}

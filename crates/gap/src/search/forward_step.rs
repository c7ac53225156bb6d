//! Forward selection: every candidate is added to the model, scored on held-out data, and the best
//! is accepted if it explains enough.

use evpose_sensor::SensorConfig;

use super::catalogue::fit_catalogue;
use super::decision::{
    LIKE_CHANCE, OPEN, WIDE, is_nearly_closed, parameters_explain, replaces_refit,
};
use super::direct_estimates::DirectEstimates;
use super::event_distance::event_distance;
use super::identification::{AddedEffect, Contender, DataSplits, Identification};
use crate::GapError;
use crate::parameters::with_given_parameters;

/// Minimum decrease of the held-out discrepancy, whatever its fraction: about what two equivalent
/// models differ by on development plans of the benchmark.
pub(super) const MIN_GAIN: f64 = 35.0;
/// Minimum fraction of the remaining discrepancy that an effect explains.
const MIN_FRACTION: f64 = 0.18;
/// The same where there is hardly a gap.
pub(super) const MIN_FRACTION_OF_LITTLE: f64 = 0.4;
/// The same where the model's parameters or a first effect explain most: a true effect explains
/// most of the rest, a false one only errors of the simulation.
const MIN_FRACTION_OF_REST: f64 = 0.55;
/// The same for a second effect where the first leaves a wide gap.
const MIN_FRACTION_OF_MUCH: f64 = 0.3;
/// Two candidates whose gains differ by less than this fraction are indistinguishable.
const AS_GOOD: f64 = 0.12;
/// Among these, a candidate whose events are at less than this multiple of the best one's distance
/// from the measured events is preferred.
const CLOSER: f64 = 0.92;
/// Beyond the best and one rival, candidates above this multiple of the least discrepancy are not
/// scored.
const FAR_BEHIND: f64 = 5.0;
/// Another variant of a candidate is scored too, up to this multiple of the best one's discrepancy.
const VARIANTS: f64 = 1.5;
/// Candidates that are scored on held-out data.
const SCORED: usize = 6;

impl DataSplits<'_> {
    /// Selects the next effect; none if no candidate explains enough.
    pub(super) fn forward_step(
        &self,
        result: &Identification,
        model: &SensorConfig,
        estimates: &DirectEstimates,
        left_out: &[String],
    ) -> Result<Option<AddedEffect>, GapError> {
        Ok(accepted(result, self.contenders(result, model, estimates, left_out)?))
    }

    /// Fits and scores the candidates for the next effect, the best on held-out data first.
    pub(super) fn contenders(
        &self,
        result: &Identification,
        model: &SensorConfig,
        estimates: &DirectEstimates,
        left_out: &[String],
    ) -> Result<Vec<Contender>, GapError> {
        let mut bases = vec![result.after.model.clone()];
        // The refit may have absorbed what an effect does: also start from the parameters as given.
        let given = with_given_parameters(&result.after.model, model);
        if given != result.after.model {
            bases.push(given);
        }
        let candidates =
            fit_catalogue(&self.screen, &self.train, model, &bases, estimates, left_out)?;
        let mut contenders: Vec<Contender> = Vec::new();
        for candidate in candidates {
            // Variants that differ little on training data may differ much on another scene.
            let is_known = |other: &Contender| {
                let other = &other.candidate;
                other.name == candidate.name
                    && (other.trial.is_form_of(&candidate.trial)
                        || candidate.fit.discrepancy > VARIANTS * other.fit.discrepancy + MIN_GAIN)
            };
            if contenders.iter().any(is_known) {
                continue;
            }
            let discrepancies = contenders.iter().map(|one| one.candidate.fit.discrepancy);
            let least = discrepancies.fold(f64::INFINITY, f64::min);
            if contenders.len() > 1 && candidate.fit.discrepancy > FAR_BEHIND * least {
                break;
            }
            let held_out = self.score(&candidate.fit.model)?;
            contenders.push(Contender { candidate, held_out });
            if contenders.len() == SCORED {
                break;
            }
        }
        contenders.sort_by(|a, b| a.held_out.discrepancy.total_cmp(&b.held_out.discrepancy));
        let mut names = Vec::new();
        contenders.retain(|one| {
            let is_new = !names.contains(&one.candidate.name);
            names.push(one.candidate.name);
            is_new
        });
        if result.added_effects.is_empty() {
            self.closest_first(&mut contenders, result.after.discrepancy)?;
        }
        Ok(contenders)
    }

    /// Moves to the front, among the contenders that are as good as the first, the one whose events
    /// are closest to the measured ones.
    fn closest_first(
        &self,
        contenders: &mut [Contender],
        discrepancy: f64,
    ) -> Result<(), GapError> {
        let Some(best) = contenders.first() else { return Ok(()) };
        let gain = discrepancy - best.held_out.discrepancy;
        if gain < MIN_GAIN {
            return Ok(());
        }
        let rivals = contenders.iter().skip(1).take_while(|other| is_as_good(other, best, gain));
        let (mut first, mut least) = (0, None);
        for i in 1..=rivals.count() {
            // Simulations take time: the first distance is computed only if there is a rival.
            let of_first = match least {
                Some(known) => known,
                None => event_distance(&self.held_out, &contenders[0].held_out.model)?,
            };
            let other = event_distance(&self.held_out, &contenders[i].held_out.model)?;
            let is_closer = other < CLOSER * of_first;
            (first, least) = if is_closer { (i, Some(other)) } else { (first, Some(of_first)) };
        }
        contenders[..=first].rotate_right(1);
        Ok(())
    }
}

/// Accepts the first of some contenders if it explains enough.
pub(super) fn accepted(result: &Identification, contenders: Vec<Contender>) -> Option<AddedEffect> {
    let best = contenders.first()?;
    let before = result.after.discrepancy;
    let gain = before - best.held_out.discrepancy;
    // A gap that the model's parameters already close needs a much better explanation to replace
    // them.
    let is_first = result.added_effects.is_empty();
    let min_fraction = match () {
        () if is_first && replaces_refit(result, &best.held_out) => MIN_FRACTION,
        () if !is_first && result.after.gap > WIDE => MIN_FRACTION_OF_MUCH,
        () if !is_first || parameters_explain(result) => MIN_FRACTION_OF_REST,
        () if result.after.gap > OPEN => MIN_FRACTION,
        () => MIN_FRACTION_OF_LITTLE,
    };
    // What is nearly closed has to be closed altogether.
    let is_enough = is_first || !is_nearly_closed(result) || best.held_out.gap < LIKE_CHANCE;
    if gain < MIN_GAIN.max(min_fraction * before) || !is_enough {
        return None;
    }
    let confusable = confusable(&contenders, gain);
    Some(AddedEffect { contenders, confusable, discrepancy_without: before })
}

/// Names of the contenders behind the first that are as good as the first, which gains `gain`.
pub(super) fn confusable(contenders: &[Contender], gain: f64) -> Vec<&'static str> {
    let rivals = contenders.iter().skip(1).filter(|one| is_as_good(one, &contenders[0], gain));
    rivals.map(|one| one.candidate.name).collect()
}

/// Whether the held-out discrepancies of two contenders are indistinguishable.
fn is_as_good(other: &Contender, best: &Contender, gain: f64) -> bool {
    let difference = other.held_out.discrepancy - best.held_out.discrepancy;
    difference < (AS_GOOD * gain).max(MIN_GAIN / 2.0)
}

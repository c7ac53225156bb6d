//! Pairs of effects of which neither explains enough alone, or which mask each other.

use evpose_sensor::SensorConfig;

use super::decision::{changed_parameters, is_partial};
use super::direct_estimates::DirectEstimates;
use super::identification::{AddedEffect, Contender, DataSplits, FittedCandidate, Identification};
use super::screening::{ScreeningBase, screen};
use crate::GapError;
use crate::fit::Fit;

/// Minimum fraction of the discrepancy that a candidate explains alone to be the first of a pair.
const MIN_FRACTION: f64 = 0.03;
/// First candidates that are followed, ranked by their best partner on the screen.
const FOLLOWED: usize = 2;

impl DataSplits<'_> {
    /// Finds a pair that explains most of what `result` leaves. The first effect is one of `alone`,
    /// the contenders that were scored alone, or a readout that the time stamps prove.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn pair(
        &self,
        result: &Identification,
        alone: &[Contender],
        model: &SensorConfig,
        estimates: &DirectEstimates,
        left_out: &[String],
    ) -> Result<Option<Identification>, GapError> {
        if let Some(readout) = self.proven_readout(result, estimates, left_out)? {
            let firsts = [vec![readout], alone.to_vec()].concat();
            if let Some(pair) = self.with_partner(firsts, result, model, estimates, left_out)? {
                return Ok(Some(pair));
            }
        }
        let tried = result.added_effects.first().map(AddedEffect::name);
        let is_new = |other: &&Contender| {
            Some(other.candidate.name) != tried && explains_alone(other, result)
        };
        let mut firsts = alone
            .iter()
            .filter(is_new)
            .map(|first| Ok((self.screen_partners(first, estimates, left_out)?, first)))
            .collect::<Result<Vec<_>, GapError>>()?;
        firsts.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, first) in firsts.into_iter().take(FOLLOWED) {
            let rivals = alone.iter().filter(|other| other.candidate.name != first.candidate.name);
            let firsts = std::iter::once(first).chain(rivals).cloned().collect();
            if let Some(pair) = self.with_partner(firsts, result, model, estimates, left_out)? {
                return Ok(Some(pair));
            }
        }
        Ok(None)
    }

    /// Adds the best partner to the first of some contenders; none unless both together explain
    /// most of what `result` leaves.
    fn with_partner(
        &self,
        firsts: Vec<Contender>,
        result: &Identification,
        model: &SensorConfig,
        estimates: &DirectEstimates,
        left_out: &[String],
    ) -> Result<Option<Identification>, GapError> {
        let mut pair = result.clone();
        pair.after = firsts[0].held_out.clone();
        pair.added_effects = vec![AddedEffect {
            contenders: firsts,
            confusable: Vec::new(),
            discrepancy_without: result.before.discrepancy,
        }];
        let Some(added) = self.forward_step(&pair, model, estimates, left_out)? else {
            return Ok(None);
        };
        pair.after = added.contenders[0].held_out.clone();
        pair.added_effects.push(added);
        let is_better = pair.after.discrepancy < result.after.discrepancy;
        Ok((!is_partial(&pair) && is_better).then_some(pair))
    }

    /// The readout that the time stamps prove. Simulated pixels with more events than the camera's
    /// keep the bus busier, so that it may not lower the discrepancy alone.
    fn proven_readout(
        &self,
        result: &Identification,
        estimates: &DirectEstimates,
        left_out: &[String],
    ) -> Result<Option<Contender>, GapError> {
        let Some((name, trial)) = estimates.proven_readout(&result.before.model, left_out) else {
            return Ok(None);
        };
        let model = trial.added_to(&result.before.model);
        let (discrepancy, _) = self.train.score(&model, 1)?;
        let held_out = self.score(&model)?;
        let fit = Fit { discrepancy, model };
        Ok(Some(Contender { candidate: FittedCandidate { name, fit, trial }, held_out }))
    }

    /// Discrepancy on the screen of a candidate with its best partner.
    fn screen_partners(
        &self,
        first: &Contender,
        estimates: &DirectEstimates,
        left_out: &[String],
    ) -> Result<f64, GapError> {
        let base = ScreeningBase::new(&self.screen, estimates, &first.held_out.model)?;
        let screened = screen(&[base], left_out)?;
        Ok(screened.first().map_or(f64::INFINITY, |best| best.discrepancy))
    }
}

/// Whether a candidate explains anything beyond the parameters that it was fitted with.
fn explains_alone(other: &Contender, result: &Identification) -> bool {
    let changed = changed_parameters(&result.refitted.model, &other.held_out.model, true);
    let without = if changed.is_empty() { &result.refitted } else { &result.before };
    other.held_out.discrepancy < (1.0 - MIN_FRACTION) * without.discrepancy
}

//! Proposals: which effects of the catalogue are worth fitting beside a model.
//!
//! # Method
//! The catalogue is screened once, beside the model with its parameters refitted. Beside a model
//! with further effects, every strength that was simulated then is predicted to change the summary
//! by as much as it did there; only the candidates that are best by this prediction are simulated
//! again.

use rayon::prelude::*;

use super::screening::{ScreenedTrial, ScreeningBase, screen, sort};
use crate::{Expectation, GapError};

/// Predicted trials that are simulated beside a model.
const SIMULATED: usize = 12;
/// Of the best, those whose likes are simulated as well, and how many of these.
const RESEMBLED: usize = 4;
const RESEMBLING: usize = 4;
/// Candidates that were best beside the first models and are simulated beside every other.
const ALONE: usize = 6;
/// Variants of one candidate among them.
const VARIANTS: usize = 2;

#[derive(Debug)]
pub(super) struct Proposals {
    screened: Vec<ScreenedTrial>,
}

impl Proposals {
    /// Screens the catalogue beside each of some models.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn screen(
        bases: &[ScreeningBase<'_>],
        left_out: &[String],
    ) -> Result<Self, GapError> {
        let mut screened = Vec::new();
        for base in bases {
            screened.extend(screen(base, left_out)?);
        }
        Ok(Self { screened })
    }

    pub(super) fn len(&self) -> usize {
        let mut names: Vec<&str> = self.screened.iter().map(|one| one.name).collect();
        names.sort_unstable();
        names.dedup();
        names.len()
    }

    /// Names of the candidates that were best beside the first models, each taken by itself.
    fn best_alone(&self) -> Vec<&'static str> {
        let mut by_discrepancy: Vec<&ScreenedTrial> = self.screened.iter().collect();
        by_discrepancy.sort_by(|a, b| a.discrepancy.total_cmp(&b.discrepancy));
        let mut names: Vec<&'static str> = Vec::new();
        for one in by_discrepancy {
            if !names.contains(&one.name) {
                names.push(one.name);
            }
        }
        names.truncate(ALONE);
        names
    }

    /// The trials of the candidates that `is_free` allows which are best beside another model, the
    /// best first; behind them all slow ones, which the screen does not show.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn beside(
        &self,
        base: &ScreeningBase<'_>,
        is_free: impl Fn(&ScreenedTrial) -> bool,
    ) -> Result<Vec<ScreenedTrial>, GapError> {
        let expected = base.expected()?;
        let free: Vec<&ScreenedTrial> = self.screened.iter().filter(|one| is_free(one)).collect();
        let mut predicted: Vec<ScreenedTrial> =
            free.par_iter().map(|one| predict(base, &expected, one)).collect();
        sort(&mut predicted);
        let mut names = Vec::new();
        // Variants of one candidate would fill all places, and differ little on a short recording.
        predicted.retain(|one| {
            names.push(one.name);
            names.iter().filter(|name| **name == one.name).count() <= VARIANTS
        });
        let others = predicted.split_off(predicted.len().min(SIMULATED));
        let best = &predicted[..predicted.len().min(RESEMBLED)];
        let (likes, others): (Vec<ScreenedTrial>, Vec<ScreenedTrial>) =
            others.into_iter().partition(|one| one.resembles_one_of(best));
        predicted.extend(likes.into_iter().take(RESEMBLING));
        // Effects of one kind do not add up: those that did best on their own are tried as well.
        let best_alone = self.best_alone();
        predicted.extend(others.into_iter().filter(|one| best_alone.contains(&one.name)));
        let mut simulated = predicted
            .par_iter()
            .map(|one| {
                // A prediction is no measurement: it must not compete with simulated discrepancies.
                let fresh = ScreenedTrial { discrepancy: f64::INFINITY, ..one.clone() };
                base.around(&fresh)
            })
            .collect::<Result<Vec<_>, GapError>>()?;
        simulated.retain(|one| one.discrepancy.is_finite());
        sort(&mut simulated);
        for slow in free.into_iter().filter(|one| one.is_slow()) {
            let is_known =
                |one: &ScreenedTrial| one.name == slow.name && one.trial.is_form_of(&slow.trial);
            if !simulated.iter().any(is_known) {
                simulated.push(ScreenedTrial { discrepancy: f64::INFINITY, ..slow.clone() });
            }
        }
        Ok(simulated)
    }
}

/// The trial at its best predicted strength.
fn predict(
    base: &ScreeningBase<'_>,
    expected: &Expectation,
    screened: &ScreenedTrial,
) -> ScreenedTrial {
    let mut best =
        ScreenedTrial { discrepancy: f64::INFINITY, tried: Vec::new(), ..screened.clone() };
    for tried in &screened.tried {
        let mut moved = expected.clone();
        for (mean, change) in moved.mean.iter_mut().zip(&*tried.change) {
            // A statistic that is defined with the effect alone stays as the model has it.
            *mean += if change.is_nan() { 0.0 } else { *change };
        }
        let discrepancy = base.profiled(&moved);
        if discrepancy < best.discrepancy {
            best.trial = tried.trial.clone();
            best.discrepancy = discrepancy;
        }
    }
    best
}

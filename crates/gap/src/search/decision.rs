//! Decisions of the search: whether an effect is worth its name, and the answer.
//!
//! Significance is decided by replicates of the models on the scene at hand
//! ([`significance`](super::significance)). The constants of this file are all that decides beside
//! it, and hold for all recordings; each says why it cannot come from the recording.

use super::identification::{Left, ModelScore};
use super::significance::{Difference, Unexplained};
use crate::verdict::Answer;

/// Gap within the tolerances of statistics: two simulators of one sensor differ by up to 0.3 in the edges of
/// bins and the order of events.
pub(super) const TOLERATED_GAP: f64 = 0.42;
/// Level of significance of all candidates together.
const LEVEL: f64 = 0.01;
/// Minimum fraction of the gap as given that an effect explains beside the others. Less is
/// significant in a recording of enough events, since no two simulators agree, but not a property
/// of a camera that a user could act on.
const MIN_FRACTION: f64 = 0.04;
/// Minimum fraction of what is left without the effect that it explains, to be named beside all
/// others: a model of a camera is never complete, and what it lacks is absorbed in part by effects
/// that have nothing to do with it.
const MIN_FRACTION_OF_REST: f64 = 0.15;
/// Further fraction for each unit of what it makes worse relative to what it makes better: an
/// effect that absorbs what is not its own makes other statistics worse, which a missing one does
/// not.
const MIN_FRACTION_IF_WORSENED: f64 = 0.3;
/// Fraction of what is left without the effect from which that does not matter: no other effect is
/// there to be absorbed.
const DECISIVE_FRACTION_OF_REST: f64 = 0.4;
/// The same to be tried: before the others are found, an effect explains less of what is left.
const MIN_FRACTION_TO_TRY: f64 = 0.06;
/// Minimum fraction of the gap as given to be tried. What is named in the end explains more, but
/// beside effects that are yet to be found it may explain less.
const MIN_FRACTION_OF_GAP_TO_TRY: f64 = 0.02;
/// Minimum decrease of the discrepancy: tolerances of statistics are not known to less.
const MIN_GAIN: f64 = 25.0;
/// Level at which what is left is significant.
const LEFT_LEVEL: f64 = 0.01;
/// Gap of two runs of one model, below which nothing that is left is called significant.
const CHANCE_GAP: f64 = 1.0;
/// Fraction of the gap left above which an explanation is partial.
const PARTIAL: f64 = 0.2;
/// Multiple of the little noise that every camera has below which more of it is no effect: where the
/// given model has none, any spread at all separates events that would have been at one time, however
/// small it is.
pub(super) const MAX_EVERYDAY: f64 = 2.0;
/// Multiple of what was counted in a part of the pixels that a fit may have: those that have few
/// events may be silent by chance.
pub(super) const MAX_OF_COUNTED: f64 = 2.0;
/// Rivals that cannot be distinguished from an effect, above which its name means nothing.
const MAX_CONFUSABLE: usize = 2;

/// Evidence for an effect or a parameter on held-out data.
#[derive(Debug, Clone, Copy)]
pub(super) struct Worth {
    /// Against the model without it.
    pub(super) difference: Difference,
    pub(super) without: f64,
    /// Discrepancy of the model as given, beyond that of its own runs.
    pub(super) excess: f64,
    /// Number of candidates that it was chosen from.
    pub(super) candidates: usize,
}

impl Worth {
    /// Fraction of the gap as given that it explains.
    pub(super) fn fraction(&self) -> f64 {
        self.difference.gain / self.excess.max(1e-9)
    }
}

/// Whether an effect explains enough beside all others to be named.
pub(super) fn is_reportable(worth: &Worth) -> bool {
    let min_fraction = MIN_FRACTION + MIN_FRACTION_IF_WORSENED * worth.difference.worsened;
    let is_most = worth.difference.gain >= DECISIVE_FRACTION_OF_REST * worth.without;
    explains(worth, MIN_FRACTION_OF_REST, MIN_FRACTION)
        && (is_most || worth.fraction() >= min_fraction)
}

/// Whether an effect explains anything beyond chance, however little: enough for what the time
/// stamps prove.
pub(super) fn is_significant(worth: &Worth) -> bool {
    worth.difference.gain >= MIN_GAIN && worth.difference.is_significant(LEVEL, worth.candidates)
}

/// Whether an effect explains enough to be tried beside others that are yet to be found.
pub(super) fn is_worth_trying(worth: &Worth) -> bool {
    explains(worth, MIN_FRACTION_TO_TRY, MIN_FRACTION_OF_GAP_TO_TRY)
}

/// Whether a decrease of the discrepancy is large enough for [`is_worth_trying`], whose evidence
/// takes many simulations.
pub(super) fn is_large_enough_to_try(gain: f64, without: f64, excess: f64) -> bool {
    let fractions = [MIN_FRACTION_TO_TRY, MIN_FRACTION_OF_GAP_TO_TRY];
    is_large_enough(gain, without, excess, fractions)
}

fn is_large_enough(gain: f64, without: f64, excess: f64, [of_rest, of_gap]: [f64; 2]) -> bool {
    gain >= MIN_GAIN && gain >= of_rest * without && gain >= of_gap * excess.max(1e-9)
}

fn explains(worth: &Worth, min_fraction_of_rest: f64, min_fraction: f64) -> bool {
    let Worth { difference, without, excess, .. } = worth;
    is_large_enough(difference.gain, *without, *excess, [min_fraction_of_rest, min_fraction])
        && difference.is_significant(LEVEL, worth.candidates)
}

/// Whether a model is within the tolerances of statistics.
pub fn is_within_tolerance(score: &ModelScore) -> bool {
    score.gap <= TOLERATED_GAP
}

/// Fraction of the gap beyond what two simulators of one sensor differ by that is closed; none
/// where there is no such gap.
pub fn excess_closed(before: f64, after: f64) -> Option<f64> {
    let excess = |gap: f64| (gap - TOLERATED_GAP).max(0.0);
    (excess(before) > 0.0).then(|| 1.0 - excess(after) / excess(before))
}

/// Fraction of the discrepancy of the model as given, beyond chance, that a model leaves.
pub(super) fn fraction_left(before: &ModelScore, after: &ModelScore, left: &Unexplained) -> f64 {
    let excess = (before.discrepancy - left.chance).max(1e-9);
    ((after.discrepancy - left.chance) / excess).clamp(0.0, 1.0)
}

/// Whether a model leaves so much of the discrepancy that its explanation is partial.
pub(super) fn is_partial(after: &ModelScore, fraction_left: f64) -> bool {
    !is_within_tolerance(after) && fraction_left > PARTIAL
}

/// Whether what a model leaves is significant: beyond chance, and more than two runs of one model
/// differ by.
pub(super) fn is_left_significant(after: &ModelScore, left: &Unexplained) -> bool {
    left.p < LEFT_LEVEL && after.gap > CHANCE_GAP
}

/// Findings of a search, as its answer depends on them.
#[derive(Debug, Clone, Default)]
pub(super) struct Findings {
    /// Rivals of each named effect that the recording does not distinguish from it.
    pub(super) confusable: Vec<usize>,
    /// Count of changed parameters that are named.
    pub(super) parameters: usize,
    /// Fraction of the gap as given that a formula and names that failed their tests explain; none if
    /// there are none.
    pub(super) unnamed: Option<f64>,
}

/// The answer, from what is named and what is left.
pub(super) fn decide(findings: &Findings, left: &Left) -> Answer {
    // Effects are named before parameters. A name with many indistinguishable rivals is no answer,
    // however much it explains; and what is explained by something that is not it, or by a formula, has
    // no name.
    let unnamed = findings.unnamed.unwrap_or(0.0).max(0.0);
    let is_left = left.is_significant && left.fraction > PARTIAL || unnamed > PARTIAL;
    let confusable = &findings.confusable;
    match (confusable.len(), findings.parameters) {
        (0, 0) if findings.unnamed.is_some() || left.is_significant => Answer::NoneOfCatalogue,
        (0, 0) => Answer::NoGap,
        (0, _) if is_left => Answer::Partial,
        (0, _) => Answer::Parameter,
        _ if confusable.iter().all(|rivals| *rivals > MAX_CONFUSABLE) => Answer::Undecided,
        _ if is_left => Answer::Partial,
        _ => Answer::Effects,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(fraction: f64, is_significant: bool) -> Left {
        Left { fraction, p: if is_significant { 1e-6 } else { 0.5 }, is_significant }
    }

    fn findings(names: usize, parameters: usize, unnamed: Option<f64>) -> Findings {
        Findings { confusable: vec![0; names], parameters, unnamed }
    }

    #[test]
    fn what_is_explained_by_something_else_is_no_answer() {
        let answer = |findings: Findings| decide(&findings, &left(0.05, false));
        assert_eq!(answer(findings(1, 0, None)), Answer::Effects);
        assert_eq!(answer(findings(1, 0, Some(0.1))), Answer::Effects);
        assert_eq!(answer(findings(1, 0, Some(0.5))), Answer::Partial);
        assert_eq!(answer(findings(0, 1, Some(0.5))), Answer::Partial);
        assert_eq!(answer(findings(0, 1, None)), Answer::Parameter);
        assert_eq!(answer(findings(0, 0, Some(0.1))), Answer::NoneOfCatalogue);
        assert_eq!(answer(findings(0, 0, None)), Answer::NoGap);
    }

    #[test]
    fn only_what_is_significant_is_left() {
        let answer = |left: Left| decide(&findings(1, 0, None), &left);
        assert_eq!(answer(left(0.5, true)), Answer::Partial);
        assert_eq!(answer(left(0.5, false)), Answer::Effects);
        assert_eq!(decide(&Findings::default(), &left(1.0, true)), Answer::NoneOfCatalogue);
    }

    #[test]
    fn below_the_gap_of_two_runs_nothing_is_significant() {
        let unexplained = Unexplained { chance: 100.0, p: 1e-9 };
        let score = |gap| ModelScore {
            model: evpose_sensor::SensorConfig::default(),
            discrepancy: 500.0,
            gap,
        };
        assert!(is_left_significant(&score(1.2), &unexplained));
        assert!(!is_left_significant(&score(0.45), &unexplained));
        assert!(!is_left_significant(&score(1.2), &Unexplained { p: 0.02, ..unexplained }));
    }
}

//! Decision rule: from discrepancies and gaps of the models of a search to an answer.
//!
//! # Constants
//! Thresholds on gaps and explained fractions were set on development plans of the blind benchmark
//! (`evpose gap bench`), whose simulator of the sensor is independent: two correct simulators of
//! one ideal sensor differ by a gap of 0.02 to 0.3.

use evpose_sensor::SensorConfig;

use super::identification::{Identification, ModelScore};
use crate::parameters::ModelParameter;
use crate::verdict::Answer;

/// Largest gap that counts as closed: differences are within chance and tolerance.
pub(super) const CLOSED: f64 = 0.36;
/// Largest gap of a correct model as a rule; above it, a second effect is tried.
pub(super) const LIKE_CHANCE: f64 = 0.3;
/// Above this gap, a second effect need not close all of it.
pub(super) const OPEN: f64 = 0.44;
/// Above this gap, an effect of the sensor is certainly missing.
pub(super) const WIDE: f64 = 0.9;
/// Minimum fraction of the discrepancy that an answer explains while the gap is open: a relative of
/// the true effect explains less.
const MIN_EXPLAINED: f64 = 0.74;
/// The same while the gap is wide.
const MIN_EXPLAINED_WIDE: f64 = 0.8;
/// Above this explained fraction, the rest of a gap that is not wide may come from the finite time
/// steps of the simulation.
const NEARLY_ALL: f64 = 0.9;
/// Steps by which a parameter changes significantly, where it alone explains the gap and beside an
/// added effect, which shifts parameters by a little.
const CHANGED_STEPS: [f64; 2] = [0.8, 1.5];

/// Parameters that differ between two models by more than chance; `is_alone` if no effect was
/// added.
pub(super) fn changed_parameters(
    from: &SensorConfig,
    to: &SensorConfig,
    is_alone: bool,
) -> Vec<ModelParameter> {
    let min_steps = if is_alone { CHANGED_STEPS[0] } else { CHANGED_STEPS[1] };
    let is_changed = |parameter: &&ModelParameter| {
        parameter.steps(parameter.value(from), parameter.value(to)).abs() >= min_steps
    };
    ModelParameter::ALL.iter().filter(is_changed).copied().collect()
}

/// Fraction of the gap above `CLOSED` that the second model closes; of the discrepancy, where the
/// first has no such gap.
pub fn gap_closed(before: &ModelScore, after: &ModelScore) -> f64 {
    let excess = |gap: f64| (gap - CLOSED).max(0.0);
    if excess(before.gap) > 0.0 {
        1.0 - excess(after.gap) / excess(before.gap)
    } else {
        explained_fraction(before, after)
    }
}

/// Fraction of the discrepancy of a model that another one explains.
pub(super) fn explained_fraction(before: &ModelScore, after: &ModelScore) -> f64 {
    1.0 - after.discrepancy / before.discrepancy.max(1e-9)
}

/// Whether the corrected model leaves too much of the discrepancy unexplained.
pub(super) fn is_partial(result: &Identification) -> bool {
    let min = if result.after.gap > WIDE { MIN_EXPLAINED_WIDE } else { MIN_EXPLAINED };
    result.after.gap > CLOSED && explained_fraction(&result.before, &result.after) < min
}

/// Whether the rest of the gap may come from the finite time steps of the simulation.
pub(super) fn is_nearly_closed(result: &Identification) -> bool {
    let explained = explained_fraction(&result.before, &result.after);
    (explained > NEARLY_ALL && result.after.gap < WIDE) || result.after.gap < OPEN
}

/// The answer, from changed parameters and added effects.
pub(super) fn decide(result: &Identification) -> Answer {
    let is_open = result.after.gap > CLOSED;
    let is_wide = result.after.gap > WIDE;
    match (result.added_effects.len(), result.changed_parameters.is_empty()) {
        (0, true) if is_wide => Answer::NoneOfCatalogue,
        (0, true) if is_open => Answer::Undecided,
        (0, true) => Answer::NoGap,
        _ if is_partial(result) => Answer::NoneOfCatalogue,
        (0, false) => Answer::Parameter,
        // Four effects that do equally well are no identification.
        _ if result.added_effects.iter().any(|added| added.confusable.len() > 2) => {
            Answer::Undecided
        }
        _ => Answer::Effects,
    }
}

/// Whether the refitted parameters alone explain most of the discrepancy.
pub(super) fn parameters_explain(result: &Identification) -> bool {
    explained_fraction(&result.before, &result.refitted) > MIN_EXPLAINED
        && result.refitted.gap < WIDE
}

/// Whether a model explains the recording without the parameter changes of the refit, which leaves
/// the gap open: then it is as simple as the refit.
pub(super) fn replaces_refit(result: &Identification, score: &ModelScore) -> bool {
    let changed = |to: &SensorConfig| changed_parameters(&result.before.model, to, false);
    result.refitted.gap > CLOSED
        && !changed(&result.refitted.model).is_empty()
        && changed(&score.model).is_empty()
}

/// Drops effects that explain only a part of what the refit leaves, if the refit explains most of
/// the whole discrepancy.
pub(super) fn drop_partial_effects(result: &mut Identification, model: &SensorConfig) {
    let is_part = !result.added_effects.is_empty()
        && result.after.gap > CLOSED
        && explained_fraction(&result.refitted, &result.after) < MIN_EXPLAINED;
    if is_part
        && !replaces_refit(result, &result.after)
        && parameters_explain(result)
        && !changed_parameters(model, &result.refitted.model, true).is_empty()
    {
        result.added_effects.clear();
        result.after = result.refitted.clone();
    }
}

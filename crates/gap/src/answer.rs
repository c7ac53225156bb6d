//! What was found, in one word: how much of a gap is gone, and whether that is enough.

use evpose_sensor::SensorConfig;

use crate::naming::{Judged, Named};
use crate::parameters::Parameter;
use crate::verdict::Answer;

/// Below this gap there is none: differences are within chance and tolerance. Two independent
/// simulators of the ideal sensor are 0.02 to 0.3 apart.
pub(crate) const CLOSED: f64 = 0.36;
/// Above this gap, something that matters is missing.
pub(crate) const WIDE: f64 = 0.9;
/// With less than this share of the misfit explained and the gap still open, what was found is not
/// what is missing: a relative of the true effect goes part of the way.
const EXPLAINS: f64 = 0.74;
/// The same where the gap is still wide.
const EXPLAINS_WIDE: f64 = 0.8;

/// Numbers that differ between two models by more than chance would move them.
pub(crate) fn moved(from: &SensorConfig, to: &SensorConfig, all: bool) -> Vec<Parameter> {
    let least = if all { 0.8 } else { 1.5 };
    let is_moved = |parameter: &&Parameter| {
        parameter.steps(parameter.value(from), parameter.value(to)).abs() >= least
    };
    Parameter::ALL.iter().filter(is_moved).copied().collect()
}

/// The share of the gap that is gone.
pub fn reduction(before: &Judged, after: &Judged) -> f64 {
    let excess = |gap: f64| (gap - CLOSED).max(0.0);
    if excess(before.gap) > 0.0 {
        1.0 - excess(after.gap) / excess(before.gap)
    } else {
        explained(before, after)
    }
}

/// The share of the misfit that is gone.
pub(crate) fn explained(before: &Judged, after: &Judged) -> f64 {
    1.0 - after.misfit / before.misfit.max(1e-9)
}

/// Whether what was found leaves too much.
pub(crate) fn is_partial(named: &Named) -> bool {
    let least = if named.after.gap > WIDE { EXPLAINS_WIDE } else { EXPLAINS };
    named.after.gap > CLOSED && explained(&named.before, &named.after) < least
}

/// The answer, from what moved and what was added.
pub(crate) fn answer(named: &Named) -> Answer {
    let is_open = named.after.gap > CLOSED;
    let is_wide = named.after.gap > WIDE;
    match (named.steps.len(), named.moved.is_empty()) {
        (0, true) if is_wide => Answer::NoneOfCatalogue,
        (0, true) if is_open => Answer::Undecided,
        (0, true) => Answer::NoGap,
        _ if is_partial(named) => Answer::NoneOfCatalogue,
        (0, false) => Answer::Parameter,
        _ if named.steps.iter().any(|step| step.confusable.len() > 2) => Answer::Undecided,
        _ => Answer::Effects,
    }
}

/// Whether numbers of the model explain most of the misfit by themselves.
pub(crate) fn numbers_explain(named: &Named) -> bool {
    explained(&named.before, &named.refitted) > EXPLAINS && named.refitted.gap < WIDE
}

/// Whether what was found does without the numbers that had to move: it is as plain as these, where
/// they leave something.
pub(crate) fn is_instead(named: &Named, found: &Judged) -> bool {
    named.refitted.gap > CLOSED
        && !moved(&named.before.model, &named.refitted.model, false).is_empty()
        && moved(&named.before.model, &found.model, false).is_empty()
}

/// Effects that explain only a part of what numbers of the model leave are taken back, if these
/// explain most of the whole.
pub(crate) fn without_parts(named: &mut Named, model: &SensorConfig) {
    let is_part = !named.steps.is_empty()
        && named.after.gap > CLOSED
        && explained(&named.refitted, &named.after) < EXPLAINS;
    let is_instead = is_instead(named, &named.after);
    if is_part
        && !is_instead
        && numbers_explain(named)
        && !moved(model, &named.refitted.model, true).is_empty()
    {
        named.steps.clear();
        named.after = named.refitted.clone();
    }
}

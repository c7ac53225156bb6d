//! Findings: identified effects and parameters with what they explain, estimates, intervals and
//! probabilities.
//!
//! # Method
//! A 90 % interval ends 1.645 standard deviations away, on the scale on which the parameter is
//! fitted. Standard deviations are those of the `errors` module, scaled by `calibration`. The
//! probability of an effect is a fit to cases whose truth is known (`calibration`), by the log-odds
//! of a softmax over all contenders, and no effect, by held-out discrepancy, at a temperature that
//! allows for the correlation of statistics, and by the gap that is left. A parameter has none:
//! whether it differs is said by its interval, and whether that is the cause is known of too few.

use std::collections::BTreeMap;

use evpose_sensor::SensorConfig;

use super::calibration::{CALIBRATION, FindingEvidence, ParameterOwner};
use super::errors::{RawError, errors};
use super::found_formula::found_formula;
use crate::GapError;
use crate::free_parameter::FreeParameter;
use crate::parameters::{ModelParameter, same_as};
use crate::search::{
    AddedEffect, ChangedParameter, DataSplits, ExplainedFraction, FORMULA, Identification,
};
use crate::verdict::{Explained, Finding, FindingKind, Quantity};

/// Standard deviations to either end of a 90 % interval.
pub(super) const SIDE: f64 = 1.645;
/// Temperature: statistics are correlated, so that this much discrepancy counts as one.
const TEMPERATURE: f64 = 10.0;

#[derive(Debug, Clone)]
pub(super) struct EvidencedFinding {
    pub(super) finding: Finding,
    /// Evidence of an effect; none for a parameter of the model.
    pub(super) evidence: Option<FindingEvidence>,
    /// Uncalibrated errors of its parameters.
    pub(super) errors: BTreeMap<String, RawError>,
}

/// Findings of a search with their evidence, those that explain most first.
pub(super) fn evidenced_findings(
    splits: &DataSplits<'_>,
    result: &Identification,
) -> Result<Vec<EvidencedFinding>, GapError> {
    let trials = result.added_effects.iter().map(|added| &added.contenders[0].candidate.trial);
    let of_effects: Vec<Vec<FreeParameter>> = trials.map(FreeParameter::of_effect).collect();
    let mut free: Vec<FreeParameter> = of_effects.iter().flatten().copied().collect();
    free.extend(ModelParameter::ALL.map(FreeParameter::Model));
    // All parameters together, so that errors include their correlations.
    let errors = errors(&splits.train, &result.after.model, &free)?;
    // Parameters of the model are the last.
    let (mut rest, of_model) = errors.split_at(errors.len() - ModelParameter::ALL.len());
    let mut findings = Vec::new();
    for (i, free) in of_effects.iter().enumerate() {
        let (own, others) = rest.split_at(free.len());
        rest = others;
        findings.push(effect_finding(splits, result, i, free.iter().zip(own)));
    }
    for changed in &result.changed_parameters {
        let i = ModelParameter::ALL.iter().position(|other| *other == changed.parameter);
        findings.extend(i.map(|i| parameter_finding(result, changed, of_model[i])));
    }
    let fraction = |one: &EvidencedFinding| {
        one.finding.explained.map_or(0.0, |explained| explained.beside_others)
    };
    findings.sort_by(|a, b| fraction(b).total_cmp(&fraction(a)));
    Ok(findings)
}

/// Finding of added effect number `i`, with the errors of its parameters.
fn effect_finding<'a>(
    splits: &DataSplits<'_>,
    result: &Identification,
    i: usize,
    parameters: impl Iterator<Item = (&'a FreeParameter, &'a RawError)>,
) -> EvidencedFinding {
    let added = &result.added_effects[i];
    let mut quantities = BTreeMap::new();
    let mut errors = BTreeMap::new();
    for (free, raw) in parameters {
        if let FreeParameter::Effect(_, param) = free {
            quantities.insert(param.name.to_owned(), quantity(*free, &result.after.model, raw));
            errors.insert(param.name.to_owned(), *raw);
        }
    }
    let evidence = evidence(splits, result, added);
    let same = same_as(added.name());
    let confusable = added.confusable.iter().copied().chain(same);
    // An effect that the model has at another strength is a wrong parameter of it.
    let kind = match result.before.model.effect(added.name()) {
        _ if added.name() == FORMULA => FindingKind::Formula,
        Some(_) => FindingKind::Parameter,
        None => FindingKind::Effect,
    };
    let is_effect = kind == FindingKind::Effect;
    let finding = Finding {
        name: added.name().to_owned(),
        kind,
        parameters: quantities,
        probability: is_effect.then(|| CALIBRATION.probability(&evidence)),
        confusable_with: confusable.map(str::to_owned).collect(),
        signature: added.test.clone(),
        explained: Some(explained(&added.explained)),
        formula: result
            .after
            .model
            .effect(FORMULA)
            .filter(|_| kind == FindingKind::Formula)
            .and_then(found_formula),
    };
    EvidencedFinding { finding, evidence: Some(evidence), errors }
}

/// Finding of a parameter of the model that differs from its given value.
fn parameter_finding(
    result: &Identification,
    changed: &ChangedParameter,
    raw: RawError,
) -> EvidencedFinding {
    let parameter = changed.parameter;
    let (given, fitted) =
        (parameter.value(&result.before.model), parameter.value(&result.after.model));
    let free = FreeParameter::Model(parameter);
    let name = parameter.name().to_owned();
    let quantity = quantity(free, &result.after.model, &raw);
    // An early clock is no latency.
    let same = same_as(&name).filter(|_| fitted > given);
    let finding = Finding {
        name: name.clone(),
        kind: FindingKind::Parameter,
        parameters: BTreeMap::from([(name.clone(), quantity)]),
        probability: None,
        confusable_with: same.map(str::to_owned).into_iter().collect(),
        signature: changed.test.clone(),
        explained: Some(explained(&changed.explained)),
        formula: None,
    };
    EvidencedFinding { finding, evidence: None, errors: BTreeMap::from([(name, raw)]) }
}

fn explained(fraction: &ExplainedFraction) -> Explained {
    let ExplainedFraction { alone, beside_others, p, .. } = *fraction;
    Explained { alone, beside_others, p }
}

/// Calibrated standard deviation of a parameter, in its steps.
fn calibrated(free: FreeParameter, raw: &RawError) -> f64 {
    CALIBRATION.error(kind(free), raw.steps())
}

/// Value of a parameter in a model, with its 90 % interval.
fn quantity(free: FreeParameter, model: &SensorConfig, raw: &RawError) -> Quantity {
    let error = calibrated(free, raw);
    let at = |sides: f64| free.value(&free.stepped(model, sides * SIDE * error));
    let (value, a, b) = (free.value(model), at(-1.0), at(1.0));
    let unit = match free {
        FreeParameter::Model(parameter) => parameter.unit(),
        FreeParameter::Effect(_, param) => param.unit,
    };
    // Steps are on the scale of the parameter, and may end at its range.
    let (lo90, hi90) = (a.min(b).min(value), a.max(b).max(value));
    Quantity { value, lo90, hi90, unit: unit.into(), halves: None }
}

/// Kind of a parameter: errors of effects and of the model are calibrated separately.
fn kind(free: FreeParameter) -> ParameterOwner {
    match free {
        FreeParameter::Model(_) => ParameterOwner::OfModel,
        FreeParameter::Effect(..) => ParameterOwner::OfEffect,
    }
}

fn evidence(
    splits: &DataSplits<'_>,
    result: &Identification,
    added: &AddedEffect,
) -> FindingEvidence {
    let without = added.discrepancy_without;
    let best = added.contenders[0].held_out.discrepancy;
    let rivals = added.contenders.iter().skip(1).map(|other| other.held_out.discrepancy);
    let statistics = splits.held_out.measured.iter().filter(|value| value.is_finite()).count();
    FindingEvidence {
        log_odds: log_odds(best, rivals.chain([without]), statistics),
        gap_after: result.after.gap,
    }
}

/// Tempered log-odds of the best discrepancy against those of its rivals. No effect is always one
/// of the rivals.
fn log_odds(best: f64, rivals: impl Iterator<Item = f64>, statistics: usize) -> f64 {
    let temperature = TEMPERATURE * (best / statistics.max(1) as f64).max(1.0);
    let weights = rivals.map(|rival| (-(rival - best) / (2.0 * temperature)).exp());
    -weights.sum::<f64>().max(f64::MIN_POSITIVE).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rival_as_good_as_the_best_makes_even_odds_and_a_hopeless_one_none() {
        assert!(log_odds(200.0, [200.0].into_iter(), 600).abs() < 1e-12);
        // A discrepancy of ten counts as one: 40 more are exp(-2).
        assert!((log_odds(200.0, [240.0].into_iter(), 600) - 2.0).abs() < 1e-12);
        // With an unexplained discrepancy, differences weigh less: half the log-odds.
        assert!((log_odds(1200.0, [1240.0].into_iter(), 600) - 1.0).abs() < 1e-12);
        assert!(log_odds(200.0, [1e9].into_iter(), 600) > 100.0);
    }

    #[test]
    fn the_only_contender_is_compared_with_no_effect() {
        let weak = log_odds(200.0, std::iter::once(210.0), 600);
        let strong = log_odds(200.0, std::iter::once(2000.0), 600);
        assert!((weak - 0.5).abs() < 1e-12 && strong > 20.0);
    }
}

//! What was named, with numbers and their intervals.
//!
//! # Method
//! An interval of 90 % ends 1.645 standard deviations away, on the scale that each number is fitted
//! on. Standard deviations are those of the `errors` module, calibrated; so is the probability of a
//! name, which weighs everything that was judged, and nothing at all, by the misfit on what was held
//! out, at a temper that allows for what the numbers share.

use std::collections::BTreeMap;

use evpose_sensor::STAGES;

use super::calibration::{CALIBRATION, Evidence, NumberKind};
use super::errors::{RawError, errors};
use crate::GapError;
use crate::knob::Knob;
use crate::naming::{Bench, Contender, Named};
use crate::normal::upper_tail;
use crate::parameters::Parameter;
use crate::verdict::{Finding, FindingKind, Quantity};

/// Standard deviations to either end of an interval of 90 %.
pub(super) const SIDE: f64 = 1.645;
/// Numbers of a summary share what they see: this many misfits count as one.
const TEMPER: f64 = 10.0;

/// A finding with what it rests on.
#[derive(Debug, Clone)]
pub struct Evidenced {
    /// What is said.
    pub finding: Finding,
    /// What the name of an effect rests on; none for a number of the model.
    pub evidence: Option<Evidence>,
    /// How uncertain its numbers are, before calibration.
    pub errors: BTreeMap<String, RawError>,
}

/// Effects and parameters of an answer, the effects first.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn findings(bench: &Bench<'_>, named: &Named) -> Result<Vec<Finding>, GapError> {
    let all = evidenced(bench, named)?;
    Ok(all.into_iter().map(|evidenced| evidenced.finding).collect())
}

/// The same with what each rests on.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn evidenced(bench: &Bench<'_>, named: &Named) -> Result<Vec<Evidenced>, GapError> {
    let model = &named.after.model;
    let owned: Vec<Vec<Knob>> = named.steps.iter().map(|step| knobs(&step.contenders[0])).collect();
    let mut all: Vec<Knob> = owned.iter().flatten().copied().collect();
    all.extend(Parameter::ALL.map(Knob::Parameter));
    let raw = errors(&bench.train, model, &all)?;
    let calibrated = |knob: Knob, raw: &RawError| CALIBRATION.error(kind(knob), raw.steps());
    let quantity = |knob: Knob, raw: &RawError| {
        let error = calibrated(knob, raw);
        let at = |sides: f64| knob.value(&knob.turned(model, sides * SIDE * error));
        let (value, a, b) = (knob.value(model), at(-1.0), at(1.0));
        let unit = match knob {
            Knob::Parameter(parameter) => parameter.unit(),
            Knob::Effect(_, param) => param.unit,
        };
        let (lo90, hi90) = (a.min(b).min(value), a.max(b).max(value));
        Quantity { value, lo90, hi90, unit: unit.into(), halves: None }
    };
    let mut found = Vec::new();
    let mut place = 0;
    for (i, (step, knobs)) in named.steps.iter().zip(&owned).enumerate() {
        let mut parameters = BTreeMap::new();
        let mut errors = BTreeMap::new();
        for knob in knobs {
            if let Knob::Effect(_, param) = knob {
                parameters.insert(param.name.to_owned(), quantity(*knob, &raw[place]));
                errors.insert(param.name.to_owned(), raw[place]);
            }
            place += 1;
        }
        let evidence = evidence(bench, named, i);
        let finding = Finding {
            name: step.contenders[0].found.name.to_owned(),
            kind: FindingKind::Effect,
            parameters,
            probability: CALIBRATION.probability(&evidence),
            confusable_with: step
                .confusable
                .iter()
                .copied()
                .chain(same_as(step.contenders[0].found.name))
                .map(str::to_owned)
                .collect(),
        };
        found.push(Evidenced { finding, evidence: Some(evidence), errors });
    }
    for parameter in &named.moved {
        let Some(i) = Parameter::ALL.iter().position(|other| other == parameter) else { continue };
        let (knob, raw) = (Knob::Parameter(*parameter), raw[place + i]);
        let from = parameter.value(&named.before.model);
        let z = parameter.steps(from, parameter.value(model)) / calibrated(knob, &raw).max(1e-9);
        let name = parameter.name().to_owned();
        let finding = Finding {
            name: name.clone(),
            kind: FindingKind::Parameter,
            parameters: BTreeMap::from([(name.clone(), quantity(knob, &raw))]),
            // That it differs at all.
            probability: 1.0 - 2.0 * upper_tail(z.abs()),
            confusable_with: if parameter.value(model) > from {
                same_as(&name).map(str::to_owned).into_iter().collect()
            } else {
                Vec::new()
            },
        };
        found.push(Evidenced { finding, evidence: None, errors: BTreeMap::from([(name, raw)]) });
    }
    Ok(found)
}

/// Errors of effects and of numbers of the model are calibrated apart.
fn kind(knob: Knob) -> NumberKind {
    match knob {
        Knob::Parameter(_) => NumberKind::OfModel,
        Knob::Effect(..) => NumberKind::OfEffect,
    }
}

/// What no recording can tell a finding from: a lag of the pixels and one of the clock, where no
/// other clock has seen the scene.
fn same_as(name: &str) -> Option<&'static str> {
    match name {
        "pixel_latency" => Some("clock_offset"),
        "clock_offset" => Some("pixel_latency"),
        _ => None,
    }
}

/// The knobs of an effect.
pub(super) fn knobs(contender: &Contender) -> Vec<Knob> {
    let name = STAGES.iter().find(|spec| spec.name == contender.found.name).map(|spec| spec.name);
    let knob = |name| contender.found.trial.params.iter().map(move |param| (name, *param));
    name.into_iter().flat_map(knob).map(|(name, param)| Knob::Effect(name, param)).collect()
}

/// What the name of step `i` rests on.
fn evidence(bench: &Bench<'_>, named: &Named, i: usize) -> Evidence {
    let (judged, before) = (&named.steps[i].contenders, named.steps[i].without);
    let best = &judged[0].held;
    let rivals = judged.iter().skip(1).map(|other| other.held.misfit).chain([before]);
    let known = bench.held.measured.iter().filter(|number| number.is_finite()).count();
    Evidence {
        log_odds: log_odds(best.misfit, rivals, known),
        gain_share: 1.0 - best.misfit / before.max(1e-9),
        gap_after: named.after.gap,
        events: bench.train.events.len(),
    }
}

/// Log-odds of the best of all that were judged. Adding nothing is one of its rivals, so that there
/// always is one.
fn log_odds(best: f64, rivals: impl Iterator<Item = f64>, numbers: usize) -> f64 {
    let temper = TEMPER * (best / numbers.max(1) as f64).max(1.0);
    let weights = rivals.map(|rival| (-(rival - best) / (2.0 * temper)).exp());
    -weights.sum::<f64>().max(f64::MIN_POSITIVE).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rival_as_good_as_the_best_makes_even_odds_and_a_hopeless_one_none() {
        assert!(log_odds(200.0, [200.0].into_iter(), 600).abs() < 1e-12);
        // Ten misfits count as one: 40 more are exp(-2).
        assert!((log_odds(200.0, [240.0].into_iter(), 600) - 2.0).abs() < 1e-12);
        // Unexplained misfit is worth less: twice the numbers, half the odds.
        assert!((log_odds(1200.0, [1240.0].into_iter(), 600) - 1.0).abs() < 1e-12);
        assert!(log_odds(200.0, [1e9].into_iter(), 600) > 100.0);
    }

    #[test]
    fn the_only_contender_is_weighed_against_nothing_at_all() {
        let weak = log_odds(200.0, std::iter::once(210.0), 600);
        let strong = log_odds(200.0, std::iter::once(2000.0), 600);
        assert!((weak - 0.5).abs() < 1e-12 && strong > 20.0);
    }
}

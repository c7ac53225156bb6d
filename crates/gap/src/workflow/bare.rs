//! A verdict of a recording alone, without a scene.

use std::collections::BTreeMap;

use evpose_core::EventStream;
use evpose_sensor::{EffectConfig, STAGES, SensorConfig};

use crate::surrogate::{BareEffect, BareFindings, bare::examine};
use crate::verdict::{
    Answer, Finding, FindingKind, GapValue, Quantity, Remaining, SCHEMA, Verdict, Where,
};

/// Surrogates of each kind, in full and quick.
const REPLICATES: [usize; 2] = [199, 39];

/// A smallest p-value above this is chance.
const LEVEL: f64 = 0.05;

/// What a recording alone shows that `model` does not hold. There is no gap without a scene: gaps
/// are no numbers.
pub fn bare(events: &EventStream, model: &SensorConfig, is_quick: bool, seed: u64) -> Verdict {
    let found = examine(events, REPLICATES[usize::from(is_quick)], seed);
    let is_missing =
        |effect: &&BareEffect| effect.p.is_some() && model.effect(effect.name).is_none();
    let effects: Vec<Finding> = found.effects.iter().filter(is_missing).map(finding).collect();
    let ps = found.statistics.iter().filter_map(|statistic| statistic.adjusted_p);
    let none = GapValue { value: f64::NAN, lo: f64::NAN, hi: f64::NAN };
    let p = ps.fold(1.0, f64::min);
    let is_silent = found.effects.iter().all(|effect| effect.p.is_none());
    let verdict = match effects.is_empty() {
        false => Answer::Effects,
        // Something stands out, and no effect that both halves agree on does it.
        true if is_silent && p <= LEVEL => Answer::Undecided,
        true => Answer::NoGap,
    };
    Verdict {
        schema: SCHEMA,
        verdict,
        effects,
        remaining: Remaining {
            is_significant: false,
            nearest_stage: String::new(),
            sentence: String::new(),
        },
        gap_before: none,
        gap_after: none,
        grr: f64::NAN,
        p,
        place: Where { sentence: String::new(), shares: BTreeMap::new() },
        stage_shares: BTreeMap::new(),
        limits: Vec::new(),
        untestable: found.untestable.iter().map(|u| (u.name.to_owned(), u.why.clone())).collect(),
        c2st_before: None,
        c2st_after: None,
        notes: notes(&found),
    }
}

/// A finding as an effect of a model, with the numbers that the catalogue knows.
pub fn as_effect(finding: &Finding) -> Option<EffectConfig> {
    let spec = STAGES.iter().find(|spec| spec.name == finding.name)?;
    let mut effect = spec.typical();
    for param in spec.params {
        let value = finding.parameters.get(param.name).map(|quantity| quantity.value);
        if let Some(value) = value.filter(|value| param.allows(*value)) {
            effect = effect.with(param.name, value);
        }
    }
    Some(effect)
}

fn finding(effect: &BareEffect) -> Finding {
    let quantity = |p: &crate::surrogate::BareParameter| {
        let (value, unit, halves) = (p.value, p.unit.to_owned(), p.halves);
        (p.name.to_owned(), Quantity { value, lo90: p.lo90, hi90: p.hi90, unit, halves })
    };
    Finding {
        name: effect.name.to_owned(),
        kind: FindingKind::Effect,
        parameters: effect.parameters.iter().map(quantity).collect(),
        probability: 1.0 - effect.p.unwrap_or(1.0),
        confusable_with: effect.confusable_with.iter().map(|name| (*name).to_owned()).collect(),
    }
}

fn notes(found: &BareFindings) -> Vec<String> {
    let mut notes = vec![format!(
        "mode C, the recording alone: {} events in {:.3} s against {} surrogates of each kind; both \
         halves of the recording must agree on what is named",
        found.events, found.seconds, found.replicates
    )];
    if !found.absent.is_empty() {
        notes.push(format!("looked for and not found: {}", found.absent.join(", ")));
    }
    for effect in found.effects.iter().filter(|effect| effect.p.is_none()) {
        let numbers =
            effect.parameters.iter().map(|p| format!("{} {:.4} {}", p.name, p.value, p.unit));
        let numbers = numbers.collect::<Vec<_>>().join(", ");
        notes.push(format!("measured, no evidence of an effect: {} {numbers}", effect.name));
    }
    notes.extend(found.notes.iter().cloned());
    notes
}

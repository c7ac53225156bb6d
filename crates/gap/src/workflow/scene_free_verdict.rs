//! Verdict of a recording without a scene.

use std::collections::BTreeMap;

use evpose_core::EventStream;
use evpose_sensor::{EffectConfig, STAGES, SensorConfig};

use crate::surrogate::scene_free::test_recording;
use crate::surrogate::{SceneFreeEffect, SceneFreeFindings, SceneFreeParameter};
use crate::verdict::{
    Answer, Finding, FindingKind, GapValue, Location, Quantity, SCHEMA, Unexplained, Verdict,
};

/// Surrogates of each kind, in full and in quick runs.
const REPLICATES: [usize; 2] = [199, 39];

/// Significance level of the smallest corrected p-value.
const LEVEL: f64 = 0.05;

/// Reports the effects that a recording shows without a scene and that `model` lacks. Without a
/// scene there is no gap: all gaps are NaN.
pub fn scene_free_verdict(
    events: &EventStream,
    model: &SensorConfig,
    is_quick: bool,
    seed: u64,
) -> Verdict {
    let results = test_recording(events, REPLICATES[usize::from(is_quick)], seed);
    let is_missing =
        |effect: &&SceneFreeEffect| effect.p.is_some() && model.effect(effect.name).is_none();
    let found = results.effects.iter().filter(is_missing).map(finding);
    let (demoted, effects): (Vec<Finding>, Vec<Finding>) = found.partition(Finding::is_demoted);
    let ps = results.statistics.iter().filter_map(|statistic| statistic.adjusted_p);
    let none = GapValue { value: f64::NAN, lo: f64::NAN, hi: f64::NAN };
    let p = ps.fold(1.0, f64::min);
    let is_unexplained = results.effects.iter().all(|effect| effect.p.is_none());
    let answer = match effects.is_empty() {
        false => Answer::Effects,
        // A statistic is significant, and no effect that both halves agree on explains it.
        true if (is_unexplained || !demoted.is_empty()) && p <= LEVEL => Answer::Undecided,
        true => Answer::NoGap,
    };
    let next = next_step(&effects, &demoted);
    Verdict {
        schema: SCHEMA,
        verdict: answer,
        effects,
        demoted,
        unexplained: Unexplained {
            fraction: f64::NAN,
            p: f64::NAN,
            is_significant: false,
            nearest_stage: String::new(),
            sentence: String::new(),
            shares: BTreeMap::new(),
            responses: Vec::new(),
        },
        gap_before: none,
        gap_after: none,
        grr: f64::NAN,
        p,
        place: Location { sentence: String::new(), shares: BTreeMap::new() },
        stage_shares: BTreeMap::new(),
        limits: Vec::new(),
        untestable: results.untestable.iter().map(|u| (u.name.to_owned(), u.why.clone())).collect(),
        c2st_before: None,
        c2st_after: None,
        corrections: Vec::new(),
        is_out_of_time: false,
        next,
        notes: notes(&results),
    }
}

/// The next step: most effects need a scene.
fn next_step(effects: &[Finding], demoted: &[Finding]) -> String {
    if let Some((one, test)) = demoted.iter().find_map(|one| Some((one, one.signature.as_ref()?))) {
        return format!("to name what only looks like {}: record {}", one.name, test.recording);
    }
    match effects.is_empty() {
        true => {
            "record a scene whose light is known, and name it with --scene: most effects need one"
                .to_owned()
        }
        false => {
            "simulate with corrected.toml; a scene whose light is known (--scene) shows the other \
                  effects"
                .to_owned()
        }
    }
}

/// Converts a finding to an effect of a sensor model, with the parameters that the catalogue knows.
pub fn as_effect(finding: &Finding) -> Option<EffectConfig> {
    let spec = STAGES.find(&finding.name)?;
    let mut effect = spec.typical();
    for param in spec.number_params() {
        let value = finding.parameters.get(param.name).map(|quantity| quantity.value);
        if let Some(value) = value.filter(|value| param.allows(*value)) {
            effect = effect.with(param.name, value);
        }
    }
    Some(effect)
}

fn finding(effect: &SceneFreeEffect) -> Finding {
    let quantity = |p: &SceneFreeParameter| {
        let (value, unit, halves) = (p.value, p.unit.to_owned(), p.halves);
        (p.name.to_owned(), Quantity { value, lo90: p.lo90, hi90: p.hi90, unit, halves })
    };
    Finding {
        name: effect.name.to_owned(),
        kind: FindingKind::Effect,
        formula: None,
        parameters: effect.parameters.iter().map(quantity).collect(),
        probability: Some(1.0 - effect.p.unwrap_or(1.0)),
        confusable_with: effect.confusable_with.iter().map(|name| (*name).to_owned()).collect(),
        signature: effect.test.clone(),
        explained: None,
    }
}

fn notes(results: &SceneFreeFindings) -> Vec<String> {
    let mut notes = vec![format!(
        "mode C, the recording alone: {} events in {:.3} s against {} surrogates of each kind; both \
         halves of the recording must agree on an effect",
        results.events, results.seconds, results.replicates
    )];
    if !results.absent.is_empty() {
        notes.push(format!("tested and not significant: {}", results.absent.join(", ")));
    }
    // What was measured without a test must not read as a finding.
    for effect in results.effects.iter().filter(|effect| effect.p.is_none()) {
        let estimates =
            effect.parameters.iter().map(|p| format!("{} {:.4} {}", p.name, p.value, p.unit));
        let estimates = estimates.collect::<Vec<_>>().join(", ");
        notes.push(format!("measured, no evidence of an effect: {} {estimates}", effect.name));
    }
    notes.extend(results.notes.iter().cloned());
    notes
}

//! Cases of a plan as a namer that knows everything would answer them. Labels are made without
//! recordings, which takes no time: all but the weakest strength counts as visible.

use std::collections::BTreeMap;

use evpose_gap::verdict::{Answer, Finding, FindingKind, Quantity};
use evpose_gap::workflow::{FindingEvidence, RawError};
use gapbench_pixel::evidence::Evidence as Seen;
use gapbench_pixel::{Case, CaseKind, Label, Plan, Truth as Hidden};

use super::opened::Opened;
use super::row::Row;
use super::truth::Truth;

/// Seed of the plan.
pub(super) const SEED: u64 = 7;

/// The label of a case without a look at recordings.
pub(super) fn label(case: &Case) -> Label {
    let visible = case.kind != CaseKind::Null && case.strength.is_none_or(|strength| strength > 0);
    let evidence = Seen {
        without: 50_000,
        with: 50_000,
        added: 0,
        removed: 0,
        moved: 5_000,
        added_in_quiet: 0,
        median_shift_us: 0.0,
        visible,
    };
    let truth: Vec<Hidden> =
        case.terms().into_iter().map(|term| Hidden { term, evidence }).collect();
    Label {
        id: case.id.clone(),
        kind: case.kind,
        strength: case.strength,
        train: case.train,
        validation: case.validation,
        visible,
        stages: truth.iter().map(|truth| truth.term.stage).collect(),
        truth,
        outside_catalogue: matches!(case.kind, CaseKind::LeftOut | CaseKind::NeverCatalogued),
        leave_out: case.leave_out,
    }
}

/// All cases, in the order of the plan.
pub(super) fn opened() -> Vec<Opened> {
    let cases = Plan::from_seed(SEED);
    cases
        .iter()
        .map(|case| {
            let label = label(case);
            let truth = Truth::from_label(&label);
            Opened { row: row(&label, &truth), truth, label }
        })
        .collect()
}

fn row(label: &Label, truth: &Truth) -> Row {
    let (verdict, kind) = match label.kind {
        CaseKind::Single | CaseKind::Pair if label.visible => {
            (Answer::Effects, FindingKind::Effect)
        }
        CaseKind::Parameter => (Answer::Parameter, FindingKind::Parameter),
        CaseKind::LeftOut | CaseKind::NeverCatalogued => {
            (Answer::NoneOfCatalogue, FindingKind::Effect)
        }
        _ => (Answer::NoGap, FindingKind::Effect),
    };
    let is_said = matches!(verdict, Answer::Effects | Answer::Parameter);
    let names: Vec<&str> = match kind {
        FindingKind::Effect => truth.effects.clone(),
        FindingKind::Parameter => truth.values.iter().map(|(finding, ..)| *finding).collect(),
    };
    let effects: Vec<Finding> = names
        .iter()
        .filter(|_| is_said)
        .map(|name| {
            let of = truth.values.iter().filter(|(finding, ..)| finding == name);
            let quantity = |value: f64| Quantity {
                value: 1.02 * value,
                lo90: 0.97 * value,
                hi90: 1.06 * value,
                unit: String::new(),
                halves: None,
            };
            Finding {
                name: (*name).to_owned(),
                kind,
                parameters: of.map(|(_, key, v)| ((*key).to_owned(), quantity(*v))).collect(),
                probability: 0.99,
                confusable_with: Vec::new(),
            }
        })
        .collect();
    let raw = RawError { curvature: 0.2, widened: 1.0, blocks: 0.1, runs: 0.1 };
    let errors = |finding: &Finding| {
        let keys = finding.parameters.keys().map(|key| (key.clone(), raw)).collect();
        (finding.name.clone(), keys)
    };
    let evidence =
        FindingEvidence { log_odds: 6.0, gain_share: 0.9, gap_after: 0.3, events: 50_000 };
    let of_effects = effects.iter().filter(|finding| finding.kind == FindingKind::Effect);
    Row {
        id: label.id.clone(),
        verdict,
        evidence: of_effects.map(|finding| (finding.name.clone(), evidence)).collect(),
        errors: effects.iter().map(errors).collect::<BTreeMap<_, _>>(),
        effects,
        gap_before: 5.0,
        gap_after: 0.3,
        grr: 0.95,
        tried: Vec::new(),
        events: 50_000,
        make_s: 4.0,
        name_s: 12.0 + 0.02 * f64::from(label.id.as_bytes()[0]),
        threads: 1,
        commit: "example".to_owned(),
    }
}

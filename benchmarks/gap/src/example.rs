//! Cases of a plan as a namer that knows everything would answer them. Labels are made without
//! recordings, which takes no time: all but the weakest strength counts as visible.

use std::collections::BTreeMap;

use evpose_gap::verdict::{Answer, Finding, FindingKind, Quantity};
use evpose_gap::workflow::{FindingEvidence, RawError};
use gapbench_pixel::evidence::Evidence as Seen;
use gapbench_pixel::{Case, CaseKind, Label, Tier, Truth as Hidden};

use super::opened::Opened;
use super::part::PlanId;
use super::row::Row;
use super::truth::Truth;

/// A plan of single effects and pairs.
pub(super) const PLAN: PlanId = PlanId { seed: 7, tier: Tier::Plain };
/// A plan of up to five effects, with conventions.
pub(super) const HOME: PlanId = PlanId { seed: 7, tier: Tier::Home };

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
    case.label_of(truth)
}

pub(super) fn opened() -> Vec<Opened> {
    of_plan(PLAN)
}

/// All cases of the plan with conventions, of which none is named.
pub(super) fn opened_home() -> Vec<Opened> {
    of_plan(HOME)
}

/// Names a convention of every case beside its effects, each in the first of its right names that
/// is an effect of the catalogue and not hidden; returns their count.
pub(super) fn name_conventions(opened: &mut [Opened]) -> usize {
    let mut count = 0;
    for case in opened {
        let mut names: Vec<&str> =
            case.truth.conventions.iter().map(|names| names[0].as_str()).collect();
        names.retain(|name| !case.truth.hides(name));
        for name in names {
            case.row.effects.push(Finding { name: name.to_owned(), ..finding() });
            count += 1;
        }
    }
    count
}

/// A finding of an effect without estimates, to be given a name.
pub(super) fn finding() -> Finding {
    Finding {
        name: String::new(),
        kind: FindingKind::Effect,
        formula: None,
        parameters: BTreeMap::new(),
        probability: Some(0.99),
        confusable_with: Vec::new(),
        explained: None,
        signature: None,
    }
}

fn of_plan(plan: PlanId) -> Vec<Opened> {
    let cases = plan.cases();
    cases
        .iter()
        .map(|case| {
            let label = label(case);
            let truth = Truth::from_label(&label, plan);
            Opened { row: row(&truth), truth }
        })
        .collect()
}

fn row(truth: &Truth) -> Row {
    let (verdict, kind) = match truth.kind {
        CaseKind::Single | CaseKind::Pair | CaseKind::Several if truth.is_visible => {
            (Answer::Effects, FindingKind::Effect)
        }
        CaseKind::Parameter => (Answer::Parameter, FindingKind::Parameter),
        CaseKind::LeftOut | CaseKind::NeverCatalogued => {
            (Answer::NoneOfCatalogue, FindingKind::Effect)
        }
        _ => (Answer::NoGap, FindingKind::Effect),
    };
    let is_said = matches!(verdict, Answer::Effects | Answer::Parameter);
    let names = match kind {
        // No case hides a formula.
        FindingKind::Effect | FindingKind::Formula => &truth.effects,
        FindingKind::Parameter => &truth.parameters,
    };
    let effects: Vec<Finding> = names
        .iter()
        .filter(|_| is_said)
        .map(|name| {
            let of = truth.values.iter().filter(|(finding, ..)| finding == name);
            let quantity = |value: f64| Quantity {
                // Inside its interval, but not exactly right, as a good estimate is.
                value: 1.02 * value,
                lo90: 0.97 * value,
                hi90: 1.06 * value,
                unit: String::new(),
                halves: None,
            };
            Finding {
                name: name.clone(),
                kind,
                parameters: of.map(|(_, key, v)| (key.clone(), quantity(*v))).collect(),
                ..finding()
            }
        })
        .collect();
    let raw = RawError { curvature: 0.2, widened: 1.0, blocks: 0.1, runs: 0.1 };
    let errors = |finding: &Finding| {
        let keys = finding.parameters.keys().map(|key| (key.clone(), raw)).collect();
        (finding.name.clone(), keys)
    };
    let evidence = FindingEvidence { log_odds: 6.0, gap_after: 0.3 };
    let of_effects = effects.iter().filter(|finding| finding.kind == FindingKind::Effect);
    Row {
        id: truth.id.clone(),
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
        // Differs between cases, so that medians and plots have something to show.
        name_s: 12.0 + 0.02 * f64::from(truth.id.as_bytes()[0]),
        threads: 1,
        commit: "example".to_owned(),
    }
}

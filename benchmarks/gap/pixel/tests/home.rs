//! The plan with conventions: counts, slots, and what each convention does to a recording.

use std::collections::{HashMap, HashSet};

use gapbench_pixel::catalogue::terms;
use gapbench_pixel::convention::{CONVENTION_KINDS, CONVENTIONS_PER_CAMERA};
use gapbench_pixel::plan::uncatalogued;
use gapbench_pixel::{
    Case, CaseKind, Convention, ConventionKind, EFFECTS, Plan, Slot, TermKind, Tier, Which,
};

fn plan(seed: u64) -> Vec<Case> {
    Plan::from_seed(seed, Tier::Home)
}

fn of_kind(cases: &[Case], kind: CaseKind) -> impl Iterator<Item = &Case> {
    cases.iter().filter(move |case| case.kind == kind)
}

#[test]
fn the_plan_has_its_counts_of_cases_and_of_hidden_effects() {
    let cases = plan(7);
    let counts = [
        (CaseKind::Single, 144),
        (CaseKind::Null, 100),
        (CaseKind::Parameter, 60),
        (CaseKind::Pair, 60),
        (CaseKind::Several, 60),
        (CaseKind::LeftOut, 18),
        (CaseKind::NeverCatalogued, 14),
    ];
    for (kind, count) in counts {
        assert_eq!(of_kind(&cases, kind).count(), count, "{kind:?}");
    }
    let ids: HashSet<&str> = cases.iter().map(|case| case.id.as_str()).collect();
    assert_eq!(ids.len(), cases.len());
    let mut hidden: HashMap<usize, usize> = HashMap::new();
    for case in of_kind(&cases, CaseKind::Several) {
        *hidden.entry(case.terms().len()).or_default() += 1;
    }
    assert_eq!(hidden, HashMap::from([(3, 20), (4, 20), (5, 20)]));
    assert!(of_kind(&cases, CaseKind::Pair).all(|case| case.terms().len() == 2));
    assert!(of_kind(&cases, CaseKind::Null).all(|case| case.terms().is_empty()));
    let is_parameter = |case: &Case| case.terms().iter().all(|t| t.kind == TermKind::Parameter);
    assert!(of_kind(&cases, CaseKind::Parameter).all(is_parameter));
    let odd: HashSet<&str> =
        of_kind(&cases, CaseKind::NeverCatalogued).map(|case| case.terms()[0].name).collect();
    assert_eq!(odd.len(), uncatalogued().len());
    assert!(!odd.contains("hysteresis"));
}

#[test]
fn every_camera_has_three_to_five_conventions_of_different_kinds() {
    let [fewest, most] = CONVENTIONS_PER_CAMERA;
    let mut kinds: HashMap<ConventionKind, usize> = HashMap::new();
    let mut counts: HashMap<usize, usize> = HashMap::new();
    for seed in 0..4 {
        for case in plan(seed) {
            let distinct: HashSet<ConventionKind> =
                case.conventions.iter().map(|convention| convention.kind).collect();
            assert_eq!(distinct.len(), case.conventions.len());
            assert!((fewest..=most).contains(&distinct.len()), "{}: {distinct:?}", case.id);
            distinct.iter().for_each(|kind| *kinds.entry(*kind).or_default() += 1);
            *counts.entry(distinct.len()).or_default() += 1;
            let is_named = |convention: &Convention| !convention.names.is_empty();
            assert!(case.conventions.iter().all(is_named));
        }
    }
    // 1824 cameras; each kind is in about two of three, each count in about a third.
    assert_eq!(kinds.len(), CONVENTION_KINDS.len());
    assert!(kinds.values().all(|count| (900..1500).contains(count)), "{kinds:?}");
    assert!(counts.values().all(|count| (400..850).contains(count)), "{counts:?}");
}

#[test]
fn no_slot_is_taken_twice_and_nothing_takes_the_place_of_what_is_hidden() {
    for seed in 0..6 {
        for case in plan(seed) {
            let distinct: HashSet<Slot> = case.slots.iter().copied().collect();
            assert_eq!(distinct.len(), case.slots.len(), "{}: {:?}", case.id, case.slots);
            let whole = terms(&case.circuit, &case.nominal);
            for hidden in case.terms() {
                assert!(whole.contains(&hidden), "{}: {hidden:?} in {whole:?}", case.id);
            }
        }
    }
}

#[test]
fn effects_of_a_case_are_of_different_stages_or_at_most_two_of_one() {
    let cases = plan(3);
    for (kind, most) in [(CaseKind::Pair, 1), (CaseKind::Several, 2)] {
        for case in of_kind(&cases, kind) {
            let terms = case.terms();
            for term in &terms {
                let same = terms.iter().filter(|other| other.stage == term.stage).count();
                assert!(same <= most, "{}", case.id);
            }
        }
    }
    let seen: HashSet<&str> = of_kind(&cases, CaseKind::Several)
        .flat_map(|case| case.terms().into_iter().map(|term| term.name).collect::<Vec<_>>())
        .collect();
    assert_eq!(seen.len(), EFFECTS.len());
}

#[test]
fn strengths_of_a_single_have_camera_scenes_and_conventions_in_common() {
    let mut seen: HashMap<u64, Vec<Case>> = HashMap::new();
    for case in plan(5).into_iter().filter(|case| case.kind == CaseKind::Single) {
        seen.entry(case.camera_seed).or_default().push(case);
    }
    assert_eq!(seen.len(), 36);
    for cases in seen.values() {
        assert_eq!(cases.len(), 4);
        assert!(cases.iter().all(|case| case.conventions == cases[0].conventions));
    }
}

#[test]
fn the_plan_depends_on_the_seed_and_is_not_that_of_the_other_tier() {
    let (first, again, other) = (plan(5), plan(5), plan(6));
    let conventions = |cases: &[Case]| -> Vec<Vec<Convention>> {
        cases.iter().map(|case| case.conventions.clone()).collect()
    };
    assert_eq!(conventions(&first), conventions(&again));
    assert!(first.iter().zip(&again).all(|(a, b)| a.id == b.id && a.circuit == b.circuit));
    let ids: HashSet<String> = first.iter().map(|case| case.id.clone()).collect();
    assert!(other.iter().all(|case| !ids.contains(&case.id)));
    let plain = Plan::from_seed(5, Tier::Plain);
    assert!(plain.iter().all(|case| !ids.contains(&case.id) && case.conventions.is_empty()));
}

#[test]
fn nothing_a_measurement_gives_says_what_the_conventions_are() {
    for case in plan(3) {
        let json: serde_json::Value =
            serde_json::from_str(&case.scene_json(Which::Train)).expect("it is JSON");
        let keys: Vec<&String> = json.as_object().expect("an object").keys().collect();
        assert_eq!(keys, ["duration_s", "fps", "height", "nominal", "white", "width"]);
        assert_eq!(json["nominal"]["sigma_C"], 0.0);
    }
}

#[test]
fn every_convention_changes_the_recording_and_a_grid_is_in_all_stamps() {
    let cases = plan(9);
    let mut seen = HashSet::new();
    for case in of_kind(&cases, CaseKind::Null) {
        let new = |convention: &Convention| !seen.contains(&convention.kind);
        let Some(convention) = case.conventions.iter().find(|convention| new(convention)) else {
            continue;
        };
        seen.insert(convention.kind);
        let mut bare = case.clone();
        bare.circuit = gapbench_pixel::case::nominal_circuit(
            &case.nominal,
            gapbench_pixel::circuit::NoiseAddress::Time,
        );
        let before = bare.record(Which::Train);
        convention.install(&mut bare.circuit);
        let after = bare.record(Which::Train);
        assert_ne!(before.events, after.events, "{:?}", convention.kind);
        if convention.kind == ConventionKind::TimeGrid {
            let period_us = (convention.parameters[0].value * 1e6).round() as u64;
            assert!(after.events.iter().all(|event| event.t_us.is_multiple_of(period_us)));
        }
        if seen.len() == CONVENTION_KINDS.len() {
            break;
        }
    }
    assert_eq!(seen.len(), CONVENTION_KINDS.len());
}

#[test]
fn an_effect_is_visible_if_the_camera_without_it_records_something_else() {
    let cases = plan(9);
    let of_strength = |strength| {
        of_kind(&cases, CaseKind::Single)
            .filter(move |case| case.strength == Some(strength))
            .find(|case| case.terms()[0].name == "refractory")
            .expect("the single is in the plan")
            .label()
    };
    let (weak, strong) = (of_strength(0), of_strength(3));
    assert!(!weak.visible && strong.visible);
    assert_eq!(strong.truth.len(), 1);
    let null = of_kind(&cases, CaseKind::Null).next().expect("a null").label();
    assert!(!null.visible && null.truth.is_empty() && null.conventions.len() >= 3);
    let text = serde_json::to_string(&null).expect("labels are JSON");
    assert!(text.contains("\"conventions\"") && text.contains("\"tier\":\"home\""));
}

//! The plan: counts, anonymous names, and draws that do not depend on threads or effects.

use std::collections::{HashMap, HashSet};

use gapbench_pixel::oddity::ODDITIES;
use gapbench_pixel::{Case, CaseKind, EFFECTS, Plan, TermKind, Tier, Which};

fn of_kind(cases: &[Case], kind: CaseKind) -> Vec<&Case> {
    cases.iter().filter(|case| case.kind == kind).collect()
}

#[test]
fn the_plan_has_its_counts_of_cases() {
    let cases = Plan::from_seed(7, Tier::Plain);
    let counts = [
        (CaseKind::Single, 216),
        (CaseKind::Null, 200),
        (CaseKind::Parameter, 60),
        (CaseKind::Pair, 60),
        (CaseKind::LeftOut, 22),
        (CaseKind::NeverCatalogued, 18),
    ];
    for (kind, count) in counts {
        assert_eq!(of_kind(&cases, kind).len(), count, "{kind:?}");
    }
    let ids: HashSet<&str> = cases.iter().map(|case| case.id.as_str()).collect();
    assert_eq!(ids.len(), cases.len());
}

#[test]
fn every_effect_comes_at_four_strengths_on_three_scenes() {
    let cases = Plan::from_seed(7, Tier::Plain);
    let mut seen: HashMap<&str, HashSet<(usize, u64)>> = HashMap::new();
    for case in of_kind(&cases, CaseKind::Single) {
        let terms = case.terms();
        assert_eq!(terms.len(), 1);
        let strength = case.strength.expect("a single has a strength");
        seen.entry(terms[0].name).or_default().insert((strength, case.train.scene_seed));
    }
    assert_eq!(seen.len(), EFFECTS.len());
    assert!(seen.values().all(|takes| takes.len() == 12));
}

#[test]
fn the_groups_hide_what_they_say() {
    let cases = Plan::from_seed(11, Tier::Plain);
    for case in &cases {
        let terms = case.terms();
        assert_ne!(case.train.scene, case.validation.scene);
        assert_ne!(case.train.run_seed, case.validation.run_seed);
        match case.kind {
            CaseKind::Null => assert!(terms.is_empty()),
            CaseKind::Parameter => {
                assert!(terms.len() == 1 && terms[0].kind == TermKind::Parameter);
            }
            CaseKind::Pair => {
                assert_eq!(terms.len(), 2);
                assert_ne!(terms[0].stage, terms[1].stage);
            }
            CaseKind::LeftOut => assert_eq!(case.leave_out, Some(terms[0].name)),
            CaseKind::Single | CaseKind::NeverCatalogued => assert_eq!(terms.len(), 1),
            CaseKind::Several => panic!("a plan of single effects and pairs has none"),
        }
    }
    let odd: HashSet<&str> = of_kind(&cases, CaseKind::NeverCatalogued)
        .iter()
        .map(|case| case.terms()[0].name)
        .collect();
    assert_eq!(odd.len(), ODDITIES.len());
    assert!(EFFECTS.iter().all(|effect| !odd.contains(effect.name())));
}

#[test]
fn nothing_a_measurement_gives_says_what_is_hidden() {
    let cases = Plan::from_seed(3, Tier::Plain);
    for case in &cases {
        for which in [Which::Train, Which::Validation] {
            let json: serde_json::Value =
                serde_json::from_str(&case.scene_json(which)).expect("it is JSON");
            let keys: Vec<&String> = json.as_object().expect("an object").keys().collect();
            assert_eq!(keys, ["duration_s", "fps", "height", "nominal", "white", "width"]);
            assert_eq!(json["nominal"]["C_on"], 0.25);
        }
    }
    // Groups are mixed: no long run of one kind in the order of the plan.
    let longest = cases.chunk_by(|a, b| a.kind == b.kind).map(<[Case]>::len).max();
    assert!(longest.is_some_and(|length| length < 25));
}

#[test]
fn the_plan_and_its_recordings_depend_on_the_seed_alone() {
    let (first, again, other) = (
        Plan::from_seed(5, Tier::Plain),
        Plan::from_seed(5, Tier::Plain),
        Plan::from_seed(6, Tier::Plain),
    );
    assert_eq!(first[0].id, again[0].id);
    assert_ne!(first[0].id, other[0].id);
    let with_threads = |threads, case: &Case| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool of threads").install(|| case.record(Which::Train))
    };
    let noisy = first
        .iter()
        .find(|case| case.terms().iter().any(|term| term.name == "photoreceptor_noise"))
        .expect("one case has noise");
    assert_eq!(with_threads(1, noisy), with_threads(3, noisy));
}

#[test]
fn a_strong_single_is_visible_a_null_is_not_and_both_have_frames() {
    let cases = Plan::from_seed(9, Tier::Plain);
    let strong = of_kind(&cases, CaseKind::Single)
        .into_iter()
        .find(|case| case.strength == Some(3))
        .expect("there are strong singles");
    let label = strong.label();
    assert!(label.visible && label.truth.len() == 1 && !label.outside_catalogue);
    let null = of_kind(&cases, CaseKind::Null)[0];
    assert!(!null.label().visible);
    assert_eq!(null.frame(Which::Validation, 500).len(), 96 * 72);
    assert!(
        serde_json::to_string(&label).expect("labels are JSON").contains(strong.terms()[0].name)
    );
}

#[test]
fn the_crate_depends_on_no_other_crate_of_the_workspace() {
    let manifest = include_str!("../Cargo.toml");
    assert!(!manifest.contains("evpose-") && !manifest.contains("path ="));
}

//! Cases with made-up truths and verdicts.

use std::collections::BTreeMap;

use evpose_gap::verdict::FindingKind;
use serde_json::json;

use super::opened::Opened;
use super::row::{NamedFinding, Row, Value};

/// A case: generator, hidden effects with their visibility, verdict, names (a parameter begins
/// with `=`).
pub(super) fn case(
    id: &str,
    generator: &str,
    effects: &[(&str, bool)],
    verdict: &str,
    names: &[&str],
) -> Opened {
    let effects: Vec<serde_json::Value> = effects
        .iter()
        .map(|(name, visible)| json!({"name": name, "strength": "strong", "visible": visible}))
        .collect();
    let truth = json!({
        "generator": generator, "scene": "bars", "effects": effects,
        // The nominal spread is known to the program, and no finding.
        "parameters": {"sigma_Cp": 0.02},
    });
    let finding = |name: &&str| NamedFinding {
        name: name.trim_start_matches('=').to_owned(),
        kind: if name.starts_with('=') { FindingKind::Parameter } else { FindingKind::Effect },
        probability: Some(0.9),
        parameters: BTreeMap::from([("sigma".to_owned(), Value { value: Some(0.01) })]),
    };
    Opened {
        row: Row {
            id: id.to_owned(),
            verdict: verdict.to_owned(),
            effects: names.iter().map(finding).collect(),
            gap_before: Some(7.0),
            gap_after: None,
            seconds: 10.0 * (1 + names.len()) as f64,
            threads: 1,
            options: Vec::new(),
            commit: "abc".to_owned(),
        },
        truth: serde_json::from_value(truth).expect("the truth of an example"),
        nominal_spread: 0.02,
    }
}

pub(super) fn opened() -> Vec<Opened> {
    vec![
        // Named beside a convention: exact.
        case("a", "v2e", &[("leak", true)], "effects", &["leak_on", "frame_grid"]),
        // One of two named, and a wrong name.
        case(
            "b",
            "iebcs",
            &[("lowpass", true), ("hot", true)],
            "effects",
            &["hot_pixels", "psf_blur"],
        ),
        // Nothing hidden: a convention, and a spread below the nominal one.
        case("c", "volt", &[], "effects", &["threshold_mismatch"]),
        // Nothing hidden, and an effect named.
        case("d", "esim", &[], "effects", &["dead_pixels"]),
        // A parameter was hidden and is found; the other effect cannot be seen.
        case(
            "e",
            "esim",
            &[("thresholds", true), ("dead", false)],
            "parameter",
            &["=threshold_on"],
        ),
        // Outside the catalogue, and said so; beside it one that is named.
        case("f", "volt", &[("ghost", true), ("leak", true)], "partial", &["leak_on"]),
        // Not found at all.
        case("g", "v2e", &[("refractory", true)], "none_of_catalogue", &[]),
    ]
}

//! How the stages of the sensor share a gap.

use std::collections::BTreeMap;

use super::next_step::domain_of;
use crate::verdict::{Finding, Unexplained};

/// Fraction of the gap as given by domain, all together 1: what is left, where it is significant, in proportion to
/// `of_left`, and the rest in proportion to what each finding explains beside the others. These overlap or leave a
/// part to all of them together, so that by themselves they add up to more or less.
pub(super) fn stage_shares(
    findings: &[Finding],
    unexplained: &Unexplained,
    of_left: &BTreeMap<String, f64>,
) -> BTreeMap<String, f64> {
    let left = if unexplained.is_significant { unexplained.fraction } else { 0.0 };
    let explained = findings.iter().filter_map(|finding| {
        let fraction = finding.explained.as_ref()?.beside_others;
        let of_formula = || finding.formula.as_ref().map(|formula| formula.stage.clone());
        let stage = domain_of(&finding.name).map(str::to_owned).or_else(of_formula)?;
        Some((stage, fraction)).filter(|_| fraction > 0.0)
    });
    let explained: Vec<(String, f64)> = explained.collect();
    let of_left = of_left.iter().map(|(domain, share)| (domain.clone(), *share)).collect();
    let mut shares: BTreeMap<String, f64> = BTreeMap::new();
    for (parts, whole) in [(explained, 1.0 - left), (of_left, left)] {
        let all: f64 = parts.iter().map(|(_, part)| part).sum();
        for (domain, part) in parts.into_iter().filter(|_| all > 0.0 && whole > 0.0) {
            *shares.entry(domain).or_default() += whole * part / all;
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn shares_of_stages_add_up_to_the_whole_gap() {
        let finding = |name: &str, beside_others: f64, formula: Option<serde_json::Value>| {
            let explained = json!({"alone": 0.9, "beside_others": beside_others, "p": 0.0});
            let finding = json!({
                "name": name, "kind": "effect", "parameters": {}, "confusable_with": [],
                "explained": explained, "formula": formula,
            });
            serde_json::from_value::<Finding>(finding).unwrap()
        };
        let law = json!({
            "stage": "threshold", "expression": "1", "variable": "", "curve": [], "reading": "",
        });
        // By themselves they add up to more than all of it.
        let findings = [
            finding("refractory", 0.6, None),
            finding("leak_on", 0.2, None),
            finding("timestamp_jitter", 0.3, None),
            finding("law", 0.1, Some(law)),
        ];
        let unexplained: Unexplained = serde_json::from_value(json!({
            "fraction": 0.1, "p": 0.001, "is_significant": true, "nearest_stage": "optics",
            "sentence": "", "shares": {}, "responses": [],
        }))
        .unwrap();
        let of_left = BTreeMap::from([("optics".to_owned(), 0.2), ("clock".to_owned(), 0.2)]);
        let shares = stage_shares(&findings, &unexplained, &of_left);
        assert!((shares.values().sum::<f64>() - 1.0).abs() < 1e-12, "{shares:?}");
        assert!((shares["detector"] - 0.9 * 0.8 / 1.2).abs() < 1e-12, "{shares:?}");
        assert!((shares["clock"] - 0.9 * 0.3 / 1.2 - 0.05).abs() < 1e-12, "{shares:?}");
        assert!((shares["threshold"] - 0.9 * 0.1 / 1.2).abs() < 1e-12, "{shares:?}");
        // What is left and not significant is nobody's.
        let chance = Unexplained { is_significant: false, ..unexplained };
        let shares = stage_shares(&findings, &chance, &of_left);
        assert!(
            (shares.values().sum::<f64>() - 1.0).abs() < 1e-12 && !shares.contains_key("optics")
        );
    }
}

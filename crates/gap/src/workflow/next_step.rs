//! The next step: the recording that would separate what a verdict leaves open.

use evpose_sensor::{STAGES, StageSpec};

use crate::parameters::ModelParameter;
use crate::report::SECOND_RECORDING;
use crate::search_spec::Searched;
use crate::verdict::{Answer, Finding, Verdict};

/// Entry of the catalogue that a finding belongs to.
fn spec_of(name: &str) -> Option<&'static StageSpec> {
    let parameter = || ModelParameter::ALL.into_iter().find(|parameter| parameter.name() == name);
    STAGES.find(name).or_else(|| parameter().map(|parameter| parameter.common().place().0))
}

/// Domain of the signal chain that a finding belongs to.
pub(super) fn domain_of(name: &str) -> Option<&'static str> {
    spec_of(name).map(|spec| spec.domain.name())
}

/// The recording that shows best what an effect does.
fn recording_of(name: &str) -> Option<&'static str> {
    let search = spec_of(name)?.search();
    let of_parameter = search.common_lacks.iter().map(|(_, lack)| lack.signature);
    let signature = search.shows.iter().copied().chain(of_parameter).next();
    signature.map(|signature| signature.recording)
}

/// The next step, the most urgent alone.
pub(super) fn next_step(verdict: &Verdict) -> String {
    if verdict.is_out_of_time {
        return "run it again with a longer --budget, or without one: the search was cut off"
            .to_owned();
    }
    if let Some(demoted) = verdict.demoted.first() {
        let record = demoted.signature.as_ref().map_or("", |test| test.recording.as_str());
        return format!("to name what only looks like {}: record {record}", demoted.name);
    }
    if let Some((finding, record)) = verdict.effects.iter().find_map(confused) {
        let others = finding.confusable_with.join(", ");
        return format!("to separate {} from {others}: record {record}", finding.name);
    }
    // A formula alone leaves the verdict that nothing of the catalogue explains the gap.
    let is_found = verdict.verdict != Answer::NoneOfCatalogue || !verdict.effects.is_empty();
    match verdict.verdict {
        Answer::NoGap => {
            "use the model as it is; what this recording could not show is listed below".to_owned()
        }
        Answer::Effects | Answer::Parameter | Answer::NoneOfCatalogue
            if is_found && !verdict.unexplained.is_significant =>
        {
            match verdict.notes.iter().any(|note| note == SECOND_RECORDING) {
                true => "use corrected.toml; `evpose gap verify` checks it by other statistics"
                    .to_owned(),
                false => {
                    "check corrected.toml on a second recording of another scene: --validate and \
                          --validate-scene"
                        .to_owned()
                }
            }
        }
        _ => {
            let stage = verdict.unexplained.nearest_stage.as_str();
            let of_stage = STAGES.iter().filter(|spec| spec.domain.name() == stage);
            match of_stage.copied().find_map(|spec| recording_of(spec.name)) {
                Some(record) => {
                    format!("what is left is nearest to the {stage}: record {record}")
                }
                None => {
                    "record another scene, with other speeds, brightness and texture".to_owned()
                }
            }
        }
    }
}

/// A finding that is not distinguished from others, with the recording that would.
fn confused(finding: &Finding) -> Option<(&Finding, &'static str)> {
    let rivals = finding.confusable_with.iter().map(String::as_str);
    let mut names = rivals.chain([finding.name.as_str()]);
    let record = names.find_map(recording_of)?;
    (!finding.confusable_with.is_empty()).then_some((finding, record))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::verdict::FindingKind;

    #[test]
    fn with_a_formula_the_corrected_model_is_the_next_step() {
        let gap = json!({"value": 0.9, "lo": 0.8, "hi": 1.0});
        let mut verdict: Verdict = serde_json::from_value(json!({
            "schema": 1, "verdict": Answer::NoneOfCatalogue, "effects": [], "p": 0.0, "grr": 0.9,
            "unexplained": {
                "fraction": 0.1, "p": 0.5, "is_significant": false, "nearest_stage": "detector",
                "sentence": "", "shares": {}, "responses": [],
            },
            "gap_before": gap, "gap_after": gap, "where": {"sentence": "", "shares": {}},
            "stage_shares": {}, "limits": [], "untestable": {}, "c2st_before": null,
            "c2st_after": null, "notes": [SECOND_RECORDING],
        }))
        .unwrap();
        assert!(next_step(&verdict).contains("record"), "{}", next_step(&verdict));
        let formula = json!({
            "name": "law", "kind": FindingKind::Formula, "parameters": {}, "confusable_with": [],
        });
        verdict.effects.push(serde_json::from_value(formula).unwrap());
        assert!(next_step(&verdict).starts_with("use corrected.toml"), "{}", next_step(&verdict));
    }
}

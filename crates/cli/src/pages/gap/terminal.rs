//! A report in at most twenty-five lines.

use evpose_gap::report::ReportData;
use evpose_gap::verdict::{Answer, Verdict};

use crate::pages::gap::explained;
use crate::pages::gap::words::{self, gap, probability};
use crate::pages::gap::wrapped::wrapped;
use evpose_report::format::{percent, short};

const LINES: usize = 25;
/// Column of the text behind a label.
const INDENT: usize = 8;
/// Column of the text behind the label of what explains the gap.
const EXPLAINED_INDENT: usize = 14;
/// Lines that findings with their values may take.
const FINDING_LINES: usize = 9;

/// The report, line by line.
pub fn lines(data: &ReportData) -> Vec<String> {
    let verdict = &data.verdict;
    let mut lines = answer(verdict);
    lines.extend(gap_and_location(verdict));
    lines.extend(alternatives(data));
    lines.extend(limits_and_notes(verdict));
    lines.truncate(LINES);
    lines
}

/// The headline, what explains the gap, and the first findings with their values.
fn answer(verdict: &Verdict) -> Vec<String> {
    let mut lines = wrapped("", &words::headline(verdict).to_uppercase(), 3, 0);
    if verdict.is_out_of_time {
        // The second line, in a headline of one: what was found may not be all.
        lines.splice(1..1, wrapped("", words::OUT_OF_TIME, 2, 2));
    }
    for correction in &verdict.corrections {
        lines.extend(wrapped("", &format!("input corrected: {correction}"), 2, 2));
    }
    if explained::has_fractions(verdict) {
        // At most three lines: the whole report has twenty-five.
        let text = explained::line(verdict);
        lines.extend(wrapped("EXPLAINED BY", &text, 3, EXPLAINED_INDENT));
    }
    if verdict.verdict == Answer::Undecided
        && let Some(alternatives) = words::alternatives(verdict)
    {
        let text = format!("the recording does not distinguish: {alternatives}");
        lines.extend(wrapped("", &text, 2, 2));
    }
    for (i, finding) in verdict.effects.iter().enumerate() {
        let values = words::parameters(finding);
        let sure =
            finding.probability.map_or_else(String::new, |right| match verdict.is_scene_free() {
                true => format!("by chance {}", probability(1.0 - right)),
                false => format!("probability {}", short(right)),
            });
        let text = [values, sure].into_iter().filter(|part| !part.is_empty());
        let text = format!("{}: {}", finding.name, text.collect::<Vec<_>>().join("; "));
        let mut of_finding = wrapped("", &text, 2, 2);
        // Summaries only while there is room for the rest of the report.
        if let Some(formula) = words::formula(finding) {
            of_finding.extend(wrapped("", &formula, 2, 4));
        } else if let Some(summary) = words::summary(&finding.name).filter(|_| lines.len() < 6) {
            of_finding.extend(wrapped("", summary, 1, 4));
        }
        if let Some(test) = finding.signature.as_ref().filter(|_| lines.len() < 6) {
            of_finding.extend(wrapped("", &test.shows, 2, 4));
        }
        if !finding.confusable_with.is_empty() && verdict.verdict != Answer::Undecided {
            let text =
                format!("here not to be distinguished from {}", finding.confusable_with.join(", "));
            of_finding.extend(wrapped("", &text, 1, 4));
        }
        // Others are named at least.
        if lines.len() + of_finding.len() > FINDING_LINES {
            let names = verdict.effects[i..].iter().map(|finding| finding.name.as_str());
            let text = format!("and {}", names.collect::<Vec<_>>().join(", "));
            lines.extend(wrapped("", &text, 2, 2));
            break;
        }
        lines.extend(of_finding);
    }
    for finding in &verdict.demoted {
        let failed = words::failed(finding).unwrap_or_default();
        lines.extend(wrapped("", &format!("{} {failed}", finding.name), 3, 2));
    }
    if !verdict.next.is_empty() {
        lines.extend(wrapped("NEXT", &verdict.next, 2, INDENT));
    }
    lines
}

/// The gap, or the p-value without a scene, and the location of the disagreement.
fn gap_and_location(verdict: &Verdict) -> Vec<String> {
    let is_scene_free = verdict.is_scene_free();
    let gaps = if is_scene_free { words::NO_GAP.to_owned() } else { gaps(verdict) };
    let mut lines = wrapped("GAP", &gaps, 2, INDENT);
    if is_scene_free {
        let text = match verdict.verdict {
            Answer::Undecided => "; this recording does not determine it without a scene",
            _ => "",
        };
        let text = format!("{} of the largest deviation{text}", probability(verdict.p));
        lines.extend(wrapped("CHANCE", &text, 1, INDENT));
    }
    if !verdict.place.sentence.is_empty() {
        lines.extend(wrapped("WHERE", &verdict.place.sentence, 3, INDENT));
    }
    let axes = verdict.place.shares.iter().map(|(name, share)| (words::axis(name), *share));
    let by_axis = shares(&axes.collect());
    if !by_axis.is_empty() {
        lines.extend(wrapped("", &format!("distinguished by {by_axis}"), 2, INDENT));
    }
    let stages = shares(&verdict.stage_shares);
    if !stages.is_empty() {
        lines.extend(wrapped("STAGE", &stages, 1, INDENT));
    }
    lines
}

/// The ablation, the classifier, and what is left.
fn alternatives(data: &ReportData) -> Vec<String> {
    let verdict = &data.verdict;
    let mut lines = Vec::new();
    let ablation = data.ablation.iter();
    let trials: Vec<String> =
        ablation.map(|row| format!("{}: {}", words::change(row), short(row.gap.value))).collect();
    if !trials.is_empty() {
        lines.extend(wrapped("TRIED", &format!("gap with {}", trials.join("; ")), 2, INDENT));
    }
    let auc = |auc: f64| format!("{auc:.2}");
    if let Some(before) = verdict.c2st_before {
        let after = verdict.c2st_after.map_or_else(String::new, |after| {
            format!(", {} after ({})", auc(after.auc), probability(after.p))
        });
        let text = format!(
            "a classifier separates measured from simulated events with AUC {} before \
             ({}){after}; 0.5 is chance",
            auc(before.auc),
            probability(before.p)
        );
        let rest = words::separated(verdict)
            .map_or("", |_| ": something is left that no statistic measures");
        lines.extend(wrapped("CHECK", &(text + rest), 3, INDENT));
    }
    let left = &verdict.unexplained;
    if left.is_significant {
        let text = match left.nearest_stage.as_str() {
            "" => left.sentence.clone(),
            stage => format!("nearest to the {stage}: {}", left.sentence),
        };
        lines.extend(wrapped("LEFT", &text, 2, INDENT));
        let axes = left.shares.iter().map(|(name, share)| (words::axis(name), *share));
        let by_axis = shares(&axes.collect());
        if !by_axis.is_empty() {
            lines.extend(wrapped("", &format!("distinguished by {by_axis}"), 1, INDENT));
        }
        if let Some(response) = left.responses.first() {
            lines.extend(wrapped("", &format!("response: {response}"), 2, INDENT));
        }
    }
    lines
}

/// Detection limits, untestable effects, and notes.
fn limits_and_notes(verdict: &Verdict) -> Vec<String> {
    let mut lines = Vec::new();
    let limits: Vec<String> = verdict
        .limits
        .iter()
        .map(|limit| format!("{} {} {}", limit.name, short(limit.value), limit.unit))
        .map(|text| text.trim_end().to_owned())
        .collect();
    if !limits.is_empty() {
        let text = format!("would have shown from: {}", limits.join(", "));
        lines.extend(wrapped("LIMITS", &text, 3, INDENT));
    }
    if !verdict.untestable.is_empty() {
        lines.extend(wrapped("UNSEEN", &unseen(verdict), 3, INDENT));
    }
    // Without a scene, notes are much of the report.
    let notes = if verdict.is_scene_free() { 6 } else { 2 };
    for note in verdict.notes.iter().take(notes) {
        lines.extend(wrapped("NOTE", note, 2, INDENT));
    }
    lines
}

fn gaps(verdict: &Verdict) -> String {
    let before = gap(&verdict.gap_before);
    if verdict.effects.is_empty() {
        let chance = probability(verdict.p);
        return format!("{before}; {}. Largest deviation by chance: {chance}", words::APART);
    }
    format!("{before} as given, {} as corrected; {}", gap(&verdict.gap_after), words::APART)
}

/// Effects that cannot be tested, with the reason where it is not that of most.
fn unseen(verdict: &Verdict) -> String {
    if !verdict.is_scene_free() {
        let names: Vec<&str> = verdict.untestable.keys().map(String::as_str).collect();
        return format!("not testable here: {}", names.join(", "));
    }
    let mut reasons: Vec<&String> = verdict.untestable.values().collect();
    // Sorted, so that names of effects do not decide ties.
    reasons.sort();
    let count = |reason: &String| reasons.iter().filter(|other| **other == reason).count();
    let Some(usual) = reasons.iter().max_by_key(|reason| count(reason)) else {
        return String::new();
    };
    let others = verdict.untestable.iter().filter(|(_, reason)| reason != usual);
    let others: Vec<String> = others.map(|(name, reason)| format!("{name} ({reason})")).collect();
    if others.is_empty() {
        return format!("not testable here: {} effects, {usual}", count(usual));
    }
    format!("not testable here: {}; {} others: {usual}", others.join(", "), count(usual))
}

/// The largest four, in percent.
fn shares(shares: &std::collections::BTreeMap<String, f64>) -> String {
    let mut shares: Vec<(&String, f64)> = shares.iter().map(|(name, s)| (name, *s)).collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let shares = shares.into_iter().filter(|(_, share)| *share >= 0.01).take(4);
    shares.map(|(name, share)| format!("{name} {}", percent(share))).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use evpose_gap::verdict::{Finding, SignatureTest};

    use super::*;
    use crate::pages::gap::example;
    use crate::pages::gap::wrapped::COLUMNS;

    #[test]
    fn a_report_fits_on_a_screen_and_says_what_matters() {
        let lines = lines(&example::data());
        assert!(lines.len() <= LINES, "{lines:#?}");
        assert!(lines.iter().all(|line| line.chars().count() <= COLUMNS), "{lines:#?}");
        let text = lines.join("\n");
        for word in
            ["LEAK_ON", "GAP", "WHERE", "EXPLAINED BY", "TRIED", "CHECK", "LIMITS", "UNSEEN"]
        {
            assert!(text.contains(word), "{word} is missing in\n{text}");
        }
    }

    #[test]
    fn a_partial_explanation_is_named_as_partial() {
        let mut verdict = example::verdict();
        verdict.verdict = Answer::Partial;
        verdict.unexplained.fraction = 0.34;
        verdict.unexplained.is_significant = true;
        let finding = verdict.effects[0].clone();
        let more = (0..9).map(|i| Finding { name: format!("effect_{i}"), ..finding.clone() });
        verdict.effects.extend(more);
        let lines = lines(&ReportData::from_verdict(verdict));
        assert!(lines.len() <= LINES, "{lines:#?}");
        let text = lines.join(" ");
        for part in ["EXPLAINED IN PART", "EXPLAINED BY  leak_on 93%", "unexplained 34%", "LEFT"] {
            assert!(text.contains(part), "{part} is missing in\n{text}");
        }
        // All ten are named, those without room for their values as well.
        assert!(text.contains("  and effect_"), "{text}");
        assert!((0..9).all(|i| text.contains(&format!("effect_{i}"))), "{text}");
    }

    #[test]
    fn what_explains_but_is_not_it_says_what_it_would_have_to_show() {
        let mut verdict = example::verdict();
        verdict.verdict = Answer::NoneOfCatalogue;
        let mut finding = verdict.effects.remove(0);
        finding.signature = Some(SignatureTest {
            passes: false,
            p: 1.0,
            must: "make ON events".to_owned(),
            shows: "rate: 0 Hz measured".to_owned(),
            recording: "a grey card".to_owned(),
        });
        verdict.demoted.push(finding);
        let text = lines(&ReportData::from_verdict(verdict)).join(" ");
        for part in [
            "SOMETHING IS MISSING THAT IS LIKE LEAK_ON, BUT IS NOT IT",
            "EXPLAINED BY  nothing; like leak_on 93%, but not by it",
            "leak_on explains, but is not it: it would have to make ON events; rate: 0 Hz measured",
            "NEXT    record it again",
        ] {
            assert!(text.contains(part), "{part} is missing in\n{text}");
        }
    }

    #[test]
    fn the_second_line_says_that_time_was_over_and_others_what_was_corrected() {
        let mut verdict = example::verdict();
        verdict.is_out_of_time = true;
        verdict.corrections.push("mirrored".to_owned());
        let lines = lines(&ReportData::from_verdict(verdict));
        assert!(lines[1].contains("OUT OF TIME"), "{lines:#?}");
        assert!(lines.iter().any(|line| line.contains("input corrected: mirrored")), "{lines:#?}");
    }

    #[test]
    fn an_undecided_verdict_lists_what_would_do_or_says_that_nothing_does() {
        let mut verdict = example::verdict();
        verdict.verdict = Answer::Undecided;
        let said = |verdict: &Verdict| {
            let lines = lines(&ReportData::from_verdict(verdict.clone())).join("\n");
            lines + &words::meaning(verdict)
        };
        assert!(said(&verdict).contains("not distinguish: leak_on or parasitic_photo_leak"));
        verdict.effects.clear();
        let text = said(&verdict);
        assert!(text.contains("No cause is clear enough"), "{text}");
        assert!(!text.contains(": .") && !text.contains("perfect match"), "{text}");
    }
}

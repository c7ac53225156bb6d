//! A report in at most twenty-five lines.

use evpose_gap::report::ReportData;
use evpose_gap::verdict::{Answer, FindingKind, Verdict};

use crate::format::{percent, short};
use crate::gap::words::{self, gap, probability};

/// Columns of a line at most.
const COLUMNS: usize = 100;
/// Lines at most.
const LINES: usize = 25;
/// Column of the text behind a label.
const INDENT: usize = 8;

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

/// The headline, and the first findings with their values.
fn answer(verdict: &Verdict) -> Vec<String> {
    let mut lines = wrapped("", &words::headline(verdict).to_uppercase(), 2, 0);
    for finding in verdict.effects.iter().take(3) {
        let values = words::parameters(finding);
        let sure = match verdict.is_scene_free() {
            true => format!("by chance {}", probability(1.0 - finding.probability)),
            false => format!("probability {}", short(finding.probability)),
        };
        let text = [values, sure].into_iter().filter(|part| !part.is_empty());
        let text = format!("{}: {}", finding.name, text.collect::<Vec<_>>().join("; "));
        lines.extend(wrapped("", &text, 2, 2));
        // Summaries only while there is room for the rest of the report.
        if let Some(summary) = words::summary(&finding.name).filter(|_| lines.len() < 6) {
            lines.extend(wrapped("", summary, 1, 4));
        }
        if !finding.confusable_with.is_empty() {
            let text =
                format!("here not to be distinguished from {}", finding.confusable_with.join(", "));
            lines.extend(wrapped("", &text, 1, 4));
        }
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

/// The ablation, the next best candidates, the classifier, and the remaining disagreement.
fn alternatives(data: &ReportData) -> Vec<String> {
    let verdict = &data.verdict;
    let mut lines = Vec::new();
    let ablation = data.ablation.iter();
    let trials: Vec<String> =
        ablation.map(|row| format!("{}: {}", words::change(row), short(row.gap.value))).collect();
    if !trials.is_empty() {
        lines.extend(wrapped("TRIED", &format!("gap with {}", trials.join("; ")), 2, INDENT));
    }
    let others = others(data);
    if !others.is_empty() {
        lines.extend(wrapped("OTHERS", &others, 2, INDENT));
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
        lines.extend(wrapped("CHECK", &text, 2, INDENT));
    }
    if verdict.remaining.is_significant {
        let text = format!(
            "nearest to the {}: {}",
            verdict.remaining.nearest_stage, verdict.remaining.sentence
        );
        lines.extend(wrapped("LEFT", &text, 2, INDENT));
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
        return format!("{before}; 1 is a perfect match ({})", probability(verdict.p));
    }
    let is_parameter = verdict.effects.iter().all(|f| f.kind == FindingKind::Parameter);
    let how = if is_parameter { "set right" } else { "added" };
    format!(
        "{before} as given, {} with that {how}; 1 is a perfect match: {} closed",
        gap(&verdict.gap_after),
        words::closed(verdict)
    )
}

/// Effects that cannot be tested, with the reason where it is not that of most.
fn unseen(verdict: &Verdict) -> String {
    if !verdict.is_scene_free() {
        let names: Vec<&str> = verdict.untestable.keys().map(String::as_str).collect();
        return format!("not testable here: {}", names.join(", "));
    }
    let mut reasons: Vec<&String> = verdict.untestable.values().collect();
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

/// The next best candidates.
fn others(data: &ReportData) -> String {
    let is_named = |name: &str| data.verdict.effects.iter().any(|finding| finding.name == name);
    let (Some(best), Some(without)) = (data.candidates.first(), data.discrepancy_without) else {
        return String::new();
    };
    let next = data.candidates.iter().filter(|candidate| !is_named(&candidate.name)).take(3);
    let next: Vec<String> = next
        .map(|candidate| format!("{} {}", candidate.name, short(candidate.discrepancy)))
        .collect();
    if next.is_empty() {
        return String::new();
    }
    format!(
        "discrepancy {} at best, {} without any; next {}",
        short(best.discrepancy),
        short(without),
        next.join(", ")
    )
}

/// `text` behind a label, in lines of no more than a hundred columns, shortened to `max_lines`
/// lines.
fn wrapped(label: &str, text: &str, max_lines: usize, indent: usize) -> Vec<String> {
    let mut lines = vec![format!("{label:<indent$}")];
    let mut is_new = true;
    for word in text.split_whitespace() {
        let line = &lines[lines.len() - 1];
        let columns = line.chars().count() + usize::from(!is_new) + word.chars().count();
        if columns > COLUMNS && !is_new {
            lines.push(" ".repeat(indent));
            is_new = true;
        }
        let last = lines.len() - 1;
        if !is_new {
            lines[last].push(' ');
        }
        lines[last].push_str(word);
        is_new = false;
    }
    if lines.len() > max_lines {
        lines.truncate(max_lines);
        let last = &mut lines[max_lines - 1];
        while last.chars().count() > COLUMNS - 4 {
            last.pop();
        }
        last.push_str(" ...");
    }
    for line in &mut lines {
        // A word that is longer than a line.
        *line = line.chars().take(COLUMNS).collect();
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::example;

    #[test]
    fn a_report_fits_on_a_screen_and_says_what_matters() {
        let lines = lines(&example::data());
        assert!(lines.len() <= LINES, "{lines:#?}");
        assert!(lines.iter().all(|line| line.chars().count() <= COLUMNS), "{lines:#?}");
        let text = lines.join("\n");
        for word in ["LEAK_ON", "GAP", "WHERE", "TRIED", "CHECK", "LIMITS", "UNSEEN"] {
            assert!(text.contains(word), "{word} is missing in\n{text}");
        }
    }

    #[test]
    fn long_text_is_wrapped_behind_its_label_and_shortened() {
        let text = "word ".repeat(60);
        let lines = wrapped("LABEL", &text, 2, 8);
        assert_eq!(lines.len(), 2);
        assert!(lines[0].starts_with("LABEL   word") && lines[1].starts_with("        word"));
        assert!(lines[1].ends_with("...") && lines[1].len() <= COLUMNS);
    }
}

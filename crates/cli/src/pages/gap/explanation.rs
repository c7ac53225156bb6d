//! The explanation: from the gap as given over all that explains it to what is left.

use evpose_gap::report::ReportData;
use evpose_gap::verdict::{Answer, Finding, FindingKind, Verdict};

use super::closing::{alike, named, values};
use super::sections::wrapped_table;
use super::{CORRECTED, MODEL, explained};
use crate::pages::gap::words;
use evpose_report::bars::Along;
use evpose_report::colour::Colour;
use evpose_report::drawing::DrawingError;
use evpose_report::format::{percent, short};
use evpose_report::html::{HtmlPage, escape};
use evpose_report::waterfall::{self, WaterfallStep};

/// Colours of parameters of the model, of what several explain jointly, and of what is left.
const PARAMETER: Colour = (201, 152, 32);
const JOINTLY: Colour = (168, 205, 190);
/// Of what explains, but is not it.
const DEMOTED: Colour = (176, 142, 168);
const LEFT: Colour = (163, 38, 46);

/// The waterfall, and the table under it.
pub(crate) fn explanation(page: &mut HtmlPage, data: &ReportData) -> Result<(), DrawingError> {
    let verdict = &data.verdict;
    if !explained::has_fractions(verdict) {
        return Ok(());
    }
    let title = match verdict.verdict {
        Answer::Partial => "What explains a part of the gap",
        Answer::NoneOfCatalogue if verdict.effects.is_empty() => "Nothing explains the gap",
        Answer::Undecided => "What may explain the gap",
        _ => "What explains the gap",
    };
    page.section(
        title,
        "From the gap of the model as given to what is left, on held-out data. Each bar is the \
         fraction of the discrepancy, beyond that of the model's own runs, that comes back when that \
         one is dropped from the corrected model and the others are fitted again.",
    );
    let steps = steps(verdict);
    let levels = || steps.iter().flat_map(|step| [step.from, step.to]);
    // Fractions may be negative, or sum to more than all.
    let (low, high) = (levels().fold(0.0, f64::min), levels().fold(1.0, f64::max));
    let along = Along {
        name: "fraction of the gap as given",
        range: (low, 1.02 * high),
        labels: 225.0,
        notes: 160.0,
        length: 560.0,
        ..Along::shares()
    };
    page.markup(&format!("<figure>{}</figure>", waterfall::svg(&steps, &along)?));
    if let Some(text) = joint_in_words(explained::jointly(verdict), verdict.effects.len()) {
        page.markup(&format!("<p class=\"soft\">{text}</p>"));
    }
    for finding in &verdict.demoted {
        let failed = words::failed(finding).unwrap_or_default();
        let text = format!("<b>{}</b> {}.", escape(&finding.name), escape(&failed));
        page.markup(&format!("<p class=\"say\">{text}</p>"));
    }
    if verdict.effects.is_empty() {
        return Ok(());
    }
    table(page, verdict);
    Ok(())
}

/// Bars from the gap as given to what is left.
fn steps(verdict: &Verdict) -> Vec<WaterfallStep> {
    let mut level = 1.0;
    let mut steps = vec![WaterfallStep {
        label: "gap as given".to_owned(),
        from: 0.0,
        to: level,
        colour: MODEL,
        note: words::gap(&verdict.gap_before),
    }];
    // Each bar begins where the last one ended: the joint part leads to what is left.
    let mut explain = |label: String, fraction: f64, colour| {
        let from = level;
        level -= fraction;
        steps.push(WaterfallStep { label, from, to: level, colour, note: percent(fraction) });
    };
    for finding in &verdict.effects {
        let colour = match finding.kind {
            FindingKind::Effect | FindingKind::Formula => CORRECTED,
            FindingKind::Parameter => PARAMETER,
        };
        explain(label(finding), explained::beside_others(finding), colour);
    }
    for finding in &verdict.demoted {
        let label = format!("like {}", finding.name);
        explain(label, explained::beside_others(finding), DEMOTED);
    }
    let joint = explained::jointly(verdict);
    if joint != 0.0 && verdict.effects.len() + verdict.demoted.len() > 0 {
        let name = if joint > 0.0 { "jointly" } else { "counted twice" };
        explain(name.to_owned(), joint, JOINTLY);
    }
    let left = &verdict.unexplained;
    let significant = if left.is_significant { ", significant" } else { "" };
    steps.push(WaterfallStep {
        label: "unexplained".to_owned(),
        from: 0.0,
        to: left.fraction,
        colour: LEFT,
        note: format!("{}{significant}", percent(left.fraction)),
    });
    steps
}

/// The name of a finding, with the number of others that would do in its place.
fn label(finding: &Finding) -> String {
    match finding.confusable_with.as_slice() {
        [] => finding.name.clone(),
        [other] => format!("{} or {other}", finding.name),
        others => format!("{} or {} others", finding.name, others.len()),
    }
}

/// Meaning of the bar between the findings and what is left.
fn joint_in_words(joint: f64, findings: usize) -> Option<&'static str> {
    match findings {
        0 => None,
        _ if joint < 0.0 => Some(
            "Counted twice: what only several of these together explain comes back when any is dropped.",
        ),
        _ if joint == 0.0 => None,
        1 => Some(
            "Jointly: what comes with values of the model that were fitted beside it, and stays \
             explained by these when it is dropped.",
        ),
        _ => Some(
            "Jointly: what any of several of these can explain, or values of the model fitted beside them, \
             does not come back when one is dropped.",
        ),
    }
}

fn table(page: &mut HtmlPage, verdict: &Verdict) {
    let row = |finding: &Finding| {
        let explained = finding.explained;
        let fraction = |of: fn(&evpose_gap::verdict::Explained) -> f64| {
            explained.as_ref().map_or_else(|| "-".to_owned(), |explained| percent(of(explained)))
        };
        let p = explained.map_or_else(|| "-".to_owned(), |e| words::probability(e.p));
        let summary = words::summary(&finding.name).unwrap_or_default();
        let shows = finding.signature.as_ref().map_or("", |test| test.shows.as_str());
        vec![
            format!("{}<br>{}<br>{}", named(finding), escape(summary), escape(shows)),
            values(finding),
            fraction(|explained| explained.alone),
            fraction(|explained| explained.beside_others),
            escape(&p),
            finding.probability.map_or_else(|| "-".to_owned(), short),
            alike(finding),
        ]
    };
    let rows: Vec<Vec<String>> = verdict.effects.iter().map(row).collect();
    let header = [
        "name",
        "values with 90 % intervals",
        "explains alone",
        "beside the others",
        "by chance",
        "probability",
        "cannot be distinguished from",
    ];
    wrapped_table(page, &header, &rows);
    page.markup(&format!(
        "<p class=\"soft\">Alone: added to the model as given (add-one). Beside the others: dropped \
         from the corrected model (drop-one). By chance: as much, if the model without it were true, \
         from replicates of that model on this scene. {}</p>",
        words::FITTED
    ));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pages::gap::example;

    #[test]
    fn bars_lead_from_the_whole_gap_to_what_is_left() {
        let steps = steps(&example::verdict());
        let labels: Vec<&str> = steps.iter().map(|step| step.label.as_str()).collect();
        let expected =
            ["gap as given", "leak_on or parasitic_photo_leak", "jointly", "unexplained"];
        assert_eq!(labels, expected);
        assert!(steps.windows(2).take(2).all(|pair| pair[0].to == pair[1].from), "{steps:?}");
        let (joint, left) = (&steps[2], &steps[3]);
        assert!(left.from == 0.0 && (joint.to - left.to).abs() < 1e-9, "{steps:?}");
    }
}

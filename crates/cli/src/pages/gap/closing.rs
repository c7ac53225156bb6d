//! Identified effects, and how the gap closes and opens again with them.

use evpose_gap::report::{Ablation, ModelChange, ReportData};
use evpose_gap::verdict::{Finding, FindingKind, GapValue};

use super::sections::wrapped_table;
use super::{CORRECTED, MODEL, explained, key};
use crate::pages::gap::words;
use evpose_report::bars::{self, Along, Bar};
use evpose_report::drawing::DrawingError;
use evpose_report::format::short;
use evpose_report::html::{HtmlPage, escape};

/// Identified effects with their parameters, where nothing says what fraction they explain: without
/// a scene.
pub(crate) fn findings(page: &mut HtmlPage, data: &ReportData) {
    // With fractions, the explanation is a section of its own.
    let verdict = &data.verdict;
    if verdict.effects.is_empty() || explained::has_fractions(verdict) {
        return;
    }
    match verdict.is_scene_free() {
        true => page.section(
            "What it is consistent with",
            "Both halves of the recording agree on it. Intervals are from the two halves.",
        ),
        false => page.section("What is missing or set wrong", words::FITTED),
    };
    let row = |finding: &Finding| {
        vec![
            named(finding),
            escape(words::summary(&finding.name).unwrap_or_default()),
            values(finding),
            match finding.probability {
                None => "-".to_owned(),
                // Without a scene it is one minus the p-value.
                Some(right) if verdict.is_scene_free() => escape(&words::probability(1.0 - right)),
                Some(right) => short(right),
            },
            alike(finding),
        ]
    };
    let rows: Vec<Vec<String>> = verdict.effects.iter().map(row).collect();
    let sure = if verdict.is_scene_free() { "by chance" } else { "probability" };
    let header = ["name", "what it does", "values", sure, "here not to be distinguished from"];
    wrapped_table(page, &header, &rows);
}

/// The name of a finding and its kind, as a cell.
pub(crate) fn named(finding: &Finding) -> String {
    let kind = match finding.kind {
        FindingKind::Effect => "effect",
        FindingKind::Parameter => "parameter of the model",
        FindingKind::Formula => "formula",
    };
    // A formula says more than its name.
    let name = words::formula(finding).unwrap_or_else(|| finding.name.clone());
    format!("<b>{}</b><br><small>{kind}</small>", escape(&name))
}

/// Its parameters with their intervals, as a cell.
pub(crate) fn values(finding: &Finding) -> String {
    let value = |(name, value)| escape(&format!("{name} = {}", words::quantity(value)));
    finding.parameters.iter().map(value).collect::<Vec<_>>().join("<br>")
}

/// Effects that the recording does not distinguish from it, as a cell.
pub(crate) fn alike(finding: &Finding) -> String {
    match finding.confusable_with.is_empty() {
        true => "nothing".to_owned(),
        false => escape(&finding.confusable_with.join(", ")),
    }
}

/// Gaps before and after, and what taking the answer back does.
pub(crate) fn closing(page: &mut HtmlPage, data: &ReportData) -> Result<(), DrawingError> {
    let interval = |gap: &GapValue| Some((gap.lo, gap.hi));
    if !data.ablation.is_empty() {
        page.section(
            "Ablation: add one, drop one, swap",
            "If the answer is right, the gap closes with it, opens again without it, and stays open \
             with the nearest other effect in its place.",
        );
        // The axis reaches 1 at least, which is the gap of two runs of one model.
        let largest = data.ablation.iter().map(|row| row.gap.hi).fold(1.0, f64::max);
        let bar = |row: &Ablation| Bar {
            label: words::change(row),
            value: row.gap.value,
            interval: interval(&row.gap),
            colour: match row.change {
                ModelChange::Added => CORRECTED,
                ModelChange::None | ModelChange::Dropped => MODEL,
                ModelChange::Swapped => (214, 140, 60),
            },
            note: words::gap(&row.gap),
        };
        let bars: Vec<Bar> = data.ablation.iter().map(bar).collect();
        page.markup(&bars::svg(&bars, &Along { labels: 260.0, ..Along::gap(largest) })?);
    }
    if data.blocks.is_empty() {
        return Ok(());
    }
    page.section(
        "The gap by what is measured",
        "1 is the gap between two runs of one model. All on the part of the recording that was held \
         out.",
    );
    key(page, &[("model as given", MODEL), ("corrected", CORRECTED)]);
    let largest = data.blocks.iter().map(|row| row.before.hi.max(row.after.hi)).fold(1.0, f64::max);
    // Without effects the corrected model is the model.
    let has_after = !data.verdict.effects.is_empty();
    let mut bars = Vec::new();
    for row in &data.blocks {
        let bar = |label: &str, gap: &GapValue, colour| Bar {
            label: label.to_owned(),
            value: gap.value,
            interval: interval(gap),
            colour,
            note: short(gap.value),
        };
        bars.push(bar(words::block(row.block), &row.before, MODEL));
        if has_after {
            bars.push(bar("", &row.after, CORRECTED));
        }
    }
    page.markup(&bars::svg(&bars, &Along::gap(largest))?);
    Ok(())
}

//! Alternatives, limits of detection, and evidence of the answer.

use evpose_gap::report::{Ranked, ReportData};

use super::diff::{Line, diff};
use super::{CORRECTED, MODEL, matrix};
use crate::pages::gap::words;
use evpose_report::bars::{self, Along, Bar};
use evpose_report::drawing::DrawingError;
use evpose_report::format::short;
use evpose_report::html::{HtmlPage, escape};

/// Statistics that are listed.
const ROWS: usize = 400;
/// Candidates that are drawn.
const RANKED: usize = 16;

/// Everything else that was tried, and what looks alike.
pub(crate) fn alternatives(page: &mut HtmlPage, data: &ReportData) -> Result<(), DrawingError> {
    let named: Vec<String> = data.verdict.effects.iter().map(|f| f.name.clone()).collect();
    if !data.candidates.is_empty() {
        page.section(
            "Everything that was tried",
            "Discrepancy of the model with each effect of the catalogue in turn, its strength and the parameters \
             of the model fitted to it: the smaller, the better it explains the recording. Pale: tried \
             at a few strengths only, because others did better.",
        );
        let largest = data.candidates.iter().map(|c| c.discrepancy).fold(0.0, f64::max);
        // The mark of no effect is on the axis, also where every effect does better.
        let largest = data.discrepancy_without.unwrap_or(0.0).max(largest);
        let bar = |candidate: &Ranked| Bar {
            label: candidate.name.clone(),
            value: candidate.discrepancy,
            interval: candidate
                .error
                .map(|e| (candidate.discrepancy - e, candidate.discrepancy + e)),
            colour: match (named.contains(&candidate.name), candidate.is_fitted) {
                (true, _) => CORRECTED,
                (false, true) => MODEL,
                (false, false) => (214, 218, 226),
            },
            note: short(candidate.discrepancy),
        };
        let bars: Vec<Bar> = data.candidates.iter().take(RANKED).map(bar).collect();
        let along = Along {
            name: "discrepancy",
            range: (0.0, 1.08 * largest),
            is_log: false,
            mark: data.discrepancy_without.map(|discrepancy| (discrepancy, "with no effect")),
            ..Along::gap(largest)
        };
        page.markup(&bars::svg(&bars, &along)?);
        if data.candidates.len() > RANKED {
            let rest = data.candidates[RANKED..].iter();
            let rest: Vec<String> =
                rest.map(|c| format!("{}: discrepancy {}", c.name, short(c.discrepancy))).collect();
            page.details(&format!("{} more", rest.len()), &rest.join("\n"));
        }
    }
    if !data.confusability.names.is_empty() {
        let alike = matrix::alike(&data.confusability);
        let alike = match alike.is_empty() {
            true => "No two effects look the same in this recording.".to_owned(),
            false => format!("Not distinguishable here: {}.", alike.join("; ")),
        };
        page.section(
            "What looks alike in this recording",
            &format!(
                "Dark where two effects change the same statistics in the same proportion (cosine of the \
                 angle between what they do, in percent from 80 on). {alike}"
            ),
        );
        page.markup(&matrix::svg(&data.confusability, &named)?);
    }
    Ok(())
}

/// Effects below the limit of detection.
pub(crate) fn limits(page: &mut HtmlPage, data: &ReportData) {
    let verdict = &data.verdict;
    if verdict.limits.is_empty() && verdict.untestable.is_empty() {
        return;
    }
    let (title, about) = match verdict.limits.is_empty() {
        true => ("What would not have shown", "Effects of which this recording says nothing."),
        false => (
            "What would have shown, and what would not",
            "The least strength at which each effect would have been seen in this recording, and \
             effects of which it says nothing.",
        ),
    };
    page.section(title, about);
    let rows: Vec<Vec<String>> = verdict
        .limits
        .iter()
        .map(|limit| {
            let value = format!("{} {}", short(limit.value), limit.unit);
            vec![escape(&limit.name), escape(&limit.parameter), escape(value.trim_end())]
        })
        .collect();
    let untestable: Vec<Vec<String>> = verdict
        .untestable
        .iter()
        .map(|(name, reason)| vec![escape(name), escape(reason)])
        .collect();
    page.markup("<div class=\"row\"><div>");
    if !rows.is_empty() {
        page.table(&["effect", "number", "shows from"], &rows);
    }
    page.markup("</div><div>");
    if !untestable.is_empty() {
        wrapped_table(page, &["untestable here", "why"], &untestable);
    }
    page.markup("</div></div>");
}

/// Observations that would overturn the answer.
pub(crate) fn doubts(page: &mut HtmlPage, data: &ReportData) {
    let verdict = &data.verdict;
    if data.doubts.is_empty() && verdict.notes.is_empty() {
        return;
    }
    page.section(
        "How could this be wrong?",
        "What the answer rests on, and what would show that it does not hold.",
    );
    let rows: Vec<Vec<String>> = data
        .doubts
        .iter()
        .map(|doubt| vec![escape(&doubt.assumption), escape(&doubt.overturned_by)])
        .collect();
    if !rows.is_empty() {
        wrapped_table(page, &["it is assumed that", "what would overturn it"], &rows);
    }
    if !verdict.notes.is_empty() {
        let notes: String =
            verdict.notes.iter().map(|note| format!("<li>{}</li>", escape(note))).collect();
        page.markup(&format!("<h3>Noticed about the inputs</h3><ul>{notes}</ul>"));
    }
}

/// Every number that was compared.
pub(crate) fn statistics(page: &mut HtmlPage, data: &ReportData) {
    if data.probes.is_empty() {
        return;
    }
    page.section(
        "Every number that was compared",
        "In standard deviations from what runs of the model give, and, for counts, relative to it. \
         Click on a heading to sort.",
    );
    let rows: String = data
        .probes
        .iter()
        .take(ROWS)
        .map(|row| {
            let relative =
                row.relative.map_or_else(|| "-".to_owned(), |r| format!("{:+.0}%", 100.0 * r));
            format!(
                "<tr><td>{}</td><td>{}</td><td>{:+.1}</td><td>{:+.1}</td><td>{relative}</td></tr>",
                words::block(row.block),
                escape(&row.name),
                row.before,
                row.after
            )
        })
        .collect();
    page.markup(&format!(
        "<div class=\"scroll\"><table class=\"sort\"><tr><th>block</th><th>number</th><th>sd before</th>\
         <th>sd after</th><th>measured over model</th></tr>{rows}</table></div>"
    ));
    if data.probes.len() > ROWS {
        page.markup(&format!(
            "<p class=\"soft\">The {ROWS} that differ most of {}.</p>",
            data.probes.len()
        ));
    }
}

/// The models, and where everything comes from.
pub(crate) fn origin(page: &mut HtmlPage, data: &ReportData) {
    if !data.model_before.is_empty() {
        page.section("The model before and after", "");
        let lines: String = diff(&data.model_before, &data.model_after)
            .into_iter()
            .map(|line| match line {
                Line::Same(text) => format!("<span>  {}</span>", escape(text)),
                Line::Taken(text) => format!("<span class=\"del\">- {}</span>", escape(text)),
                Line::Added(text) => format!("<span class=\"add\">+ {}</span>", escape(text)),
            })
            .collect();
        page.markup(&format!("<pre class=\"diff\">{lines}</pre>"));
    }
    if !data.provenance.is_empty() {
        page.section("Provenance", "");
        let rows: Vec<Vec<String>> = data
            .provenance
            .iter()
            .map(|fact| vec![escape(&fact.name), escape(&fact.value)])
            .collect();
        wrapped_table(page, &["", ""], &rows);
    }
}

/// A table of text rather than of values.
pub(crate) fn wrapped_table(page: &mut HtmlPage, header: &[&str], rows: &[Vec<String>]) {
    page.markup("<div class=\"wrap\">");
    page.table(header, rows);
    page.markup("</div>");
}

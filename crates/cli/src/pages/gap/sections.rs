//! Alternatives, limits of detection, and evidence of the answer.

use evpose_gap::report::ReportData;

use super::diff::{Line, diff};
use super::matrix;
use crate::pages::gap::words;
use evpose_report::drawing::DrawingError;
use evpose_report::format::short;
use evpose_report::html::{HtmlPage, escape};

/// Statistics that are listed.
const ROWS: usize = 400;

/// Effects that look alike.
pub(crate) fn alternatives(page: &mut HtmlPage, data: &ReportData) -> Result<(), DrawingError> {
    let named: Vec<String> = data.verdict.effects.iter().map(|f| f.name.clone()).collect();
    if !data.confusability.names.is_empty() {
        let alike = matrix::alike(&data.confusability);
        let alike = match alike.is_empty() {
            true => "No two effects look the same in this recording.".to_owned(),
            false => format!(
                "Alike here while they are weak: {}. Whether one that is named is distinguished \
                 from another is said beside its values.",
                alike.join("; ")
            ),
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
        page.table(&["effect", "parameter", "shows from"], &rows);
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
        "Every statistic that was compared",
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
        "<div class=\"scroll\"><table class=\"sort\"><tr><th>family</th><th>statistic</th><th>sd before</th>\
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

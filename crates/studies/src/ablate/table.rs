//! The outcome as a table, the same on the terminal and as Markdown.

use evpose_core::stats::interval::Interval;

use super::networks_table;
use super::outcome::{FindingOutcome, Means, Outcome, RowOutcome};
use crate::study::{VERDICTS, listed};
use evpose_report::format::{with_interval, with_interval_or_dash};

/// Metrics of the table: heading, name of the figure, digits.
const METRICS: [(&str, &str, usize); 4] = [
    ("AUC 2D", "auc_2d", 3),
    ("AUC 3D", "auc_3d", 3),
    ("MPJPE mm", "mpjpe_mm", 1),
    ("wrist mm", "translation_mm", 1),
];

/// Headings.
pub(super) fn header() -> Vec<&'static str> {
    let figures = METRICS.iter().map(|figure| figure.0);
    let rest = ["parameters", "at full width", "poses/s", "training s", "published: here"];
    std::iter::once("row").chain(figures).chain(rest).collect()
}

/// The cells of each row, and of the mean pose.
pub(super) fn rows(outcome: &Outcome) -> Vec<Vec<String>> {
    let mut rows: Vec<Vec<String>> = outcome.rows.iter().map(cells).collect();
    let mut last = vec!["mean pose".to_owned()];
    last.extend(figures(&outcome.mean_pose));
    last.resize(header().len(), "-".to_owned());
    rows.push(last);
    rows
}

fn cells(row: &RowOutcome) -> Vec<String> {
    let mut cells = vec![row.name.to_owned()];
    cells.extend(figures(&row.means));
    cells.push(thousands(row.parameters));
    cells.push(thousands(row.parameters_as_published));
    cells.push(with_interval(&row.poses_per_s, 0));
    cells.push(row.training_s.map_or_else(|| "-".to_owned(), |s| format!("{:.0}", s.estimate)));
    let findings: Vec<String> = row.findings.iter().map(finding_text).collect();
    cells.push(if findings.is_empty() { "-".to_owned() } else { findings.join("; ") });
    cells
}

fn figures(means: &Means) -> impl Iterator<Item = String> {
    METRICS.iter().map(|(_, name, digits)| with_interval_or_dash(means.get(name), *digits))
}

/// `worse than lnes-100: 2D found, 3D within noise`.
fn finding_text(finding: &FindingOutcome) -> String {
    let checks = finding.checks.iter();
    let checks: Vec<String> =
        checks.map(|check| format!("{} {}", check.measure, check.verdict)).collect();
    format!("{} {}: {}", finding.relation.words(), finding.than, checks.join(", "))
}

/// `11,182,725`.
pub(super) fn thousands(count: usize) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// The table as Markdown whose columns are aligned, for reading as it is.
pub(super) fn aligned(outcome: &Outcome) -> String {
    align(&header(), &rows(outcome))
}

/// Rows as Markdown whose columns are aligned.
pub(super) fn align(header: &[&str], rows: &[Vec<String>]) -> String {
    let header: Vec<String> = header.iter().map(|&cell| cell.to_owned()).collect();
    // In characters, not bytes: cells hold `±`.
    let width = |column: usize| {
        std::iter::once(&header).chain(rows).map(|row| row[column].chars().count()).max()
    };
    let widths: Vec<usize> = (0..header.len()).map(|i| width(i).unwrap_or(0)).collect();
    let line = |cells: &[String]| {
        let cells = cells.iter().zip(&widths).enumerate().map(|(i, (cell, &width))| {
            // Names and words begin at the left, values end at the right.
            if i == 0 || i + 1 == widths.len() {
                format!("{cell:<width$}")
            } else {
                format!("{cell:>width$}")
            }
        });
        format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "))
    };
    let rule = widths.iter().enumerate().map(|(i, &width)| {
        let dashes = "-".repeat(width + 1);
        if i == 0 || i + 1 == widths.len() { format!("{dashes}-") } else { format!("{dashes}:") }
    });
    let mut text = line(&header) + &format!("|{}|\n", rule.collect::<Vec<_>>().join("|"));
    rows.iter().for_each(|row| text += &line(row));
    text
}

/// Content of `ablation.md`.
pub(super) fn markdown(outcome: &Outcome) -> String {
    let mut text =
        format!("# What each part of the hand method is worth\n\n{}\n", aligned(outcome));
    text += &format!("{}\n\n", legend(outcome));
    text += "| row | published | measure | here minus the other row | |\n|---|---|---|---:|---|\n";
    for row in &outcome.rows {
        for finding in &row.findings {
            for check in &finding.checks {
                text += &format!(
                    "| {} | {} | {} | {} | {} |\n",
                    row.name,
                    finding.published,
                    check.measure,
                    difference(&check.difference, check.measure),
                    check.verdict
                );
            }
        }
    }
    if let Some(networks) = networks_table::aligned(outcome) {
        text += &format!("\n## The networks\n\n{networks}\n{}\n", networks_table::LEGEND);
    }
    text
}

/// A difference with its interval, in the digits of its measure.
pub(super) fn difference(interval: &Interval, measure: &str) -> String {
    with_interval(interval, if measure == "poses/s" { 0 } else { 3 })
}

/// Legend of the columns, with the origin of the values.
pub(super) fn legend(outcome: &Outcome) -> String {
    let made = outcome
        .made
        .iter()
        .map(|made| format!("commit {} on {}, device {}", made.commit, made.machine, made.device));
    format!(
        "Means over seeds {} with 95% intervals of Student's t. AUC: larger is better; MPJPE and \
         wrist errors: smaller. poses/s: the network alone, one window at a time. Verdicts follow \
         from the interval of the difference between two rows, seed by seed: {VERDICTS}. \
         Config {}, a pose every {} ms; {}.",
        listed(&outcome.seeds),
        outcome.config,
        outcome.stride_ms,
        made.collect::<Vec<_>>().join("; ")
    )
}

#[cfg(test)]
mod tests {
    use anyhow::Result;

    use super::super::outcome::tests::outcome;
    use super::super::rows::FULL;
    use super::*;

    #[test]
    fn the_table_has_a_line_for_every_row_and_says_what_was_found() -> Result<()> {
        let outcome = outcome(&[(FULL, [0.5, 0.6, 0.7]), ("eoi", [0.4, 0.5, 0.6])])?;
        let text = aligned(&outcome);
        let lines: Vec<&str> = text.lines().collect();
        // Header, rule, the full method, EOI, no filter, the mean pose.
        assert_eq!(lines.len(), 6, "{text}");
        assert!(lines[2].contains("| 0.600 ± 0.248 |"), "{text}");
        assert!(lines[3].contains("worse than lnes-100: 2D found, 3D found"), "{text}");
        assert!(lines[5].starts_with("| mean pose"), "{text}");
        let width = |line: &&str| line.chars().count();
        assert!(lines.iter().all(|line| width(line) == width(&lines[0])), "{text}");
        assert!(
            markdown(&outcome).contains("| eoi | LNES beats EOI at 100 ms | 2D | -0.100 ± 0.000 |")
        );
        Ok(())
    }

    #[test]
    fn thousands_are_set_apart() {
        let written = [7, 999, 1_000, 11_182_725].map(thousands);
        assert_eq!(written, ["7", "999", "1,000", "11,182,725"]);
    }
}

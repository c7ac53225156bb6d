//! Scores as a table of the terminal and of a page, and a line a case for other programs.

use std::path::Path;

use anyhow::Result;

use super::names::{CONVENTIONS, Convention, HIDDEN};
use super::opened::Opened;
use super::score::{Group, OutsideScores};
use crate::files::{self, SCORES, TABLE};
use crate::table::{self, rate};
use evpose_report::format::short;

const GROUPS: &str = "groups.md";
const CASES: &str = "cases.csv";

/// Figures of a group: heading and cell.
type Column = (&'static str, fn(&Group) -> String);

const COLUMNS: &[Column] = &[
    ("cases", |group| group.cases.to_string()),
    ("visible effects named", |group| rate(&group.recall)),
    ("names right", |group| rate(&group.precision)),
    ("names right, conventions aside", |group| rate(&group.strict_precision)),
    ("exact sets", |group| rate(&group.exact_sets)),
    ("cases with a wrong name", |group| rate(&group.wrong_names)),
    ("nulls named", |group| rate(&group.nulls_named)),
    ("left open outside the catalogue", |group| rate(&group.outside_open)),
    ("parameters right", |group| rate(&group.parameters)),
    ("seconds: median, 90 %, max", |group| {
        group.seconds.map_or_else(String::new, |s| {
            format!("{}, {}, {}", short(s.median), short(s.p90), short(s.max))
        })
    }),
];

/// The scores for the terminal: a block a group.
pub(super) fn lines(scores: &OutsideScores) -> Vec<String> {
    let mut lines: Vec<String> =
        table::rows(&scores.headlines).lines().map(str::to_owned).collect();
    for group in &scores.groups {
        lines.push(group.title.clone());
        for (heading, cell) in COLUMNS {
            let cell = cell(group);
            if !cell.is_empty() {
                lines.push(format!("  {heading:<34}{cell}"));
            }
        }
    }
    for (strength, recall) in scores.strengths.iter().filter(|(_, recall)| recall.n > 0) {
        lines.push(format!("{:<36}{}", format!("{strength} effects named"), rate(recall)));
    }
    lines.push(format!("{} cases; programs {}", scores.cases, scores.commits.join(", ")));
    lines
}

pub(super) fn texts(
    opened: &[Opened],
    scores: &OutsideScores,
) -> Result<Vec<(&'static str, String)>> {
    let of = format!("{} cases; programs {}", scores.cases, scores.commits.join(", "));
    Ok(vec![
        (SCORES, files::json(scores)?),
        (TABLE, format!("{}\n{of}.\n", table::rows(&scores.headlines))),
        (GROUPS, markdown(scores)),
        (CASES, csv(opened)),
    ])
}

/// The answer key, and the conventions, as tables in Markdown.
pub(crate) fn key() -> String {
    let names = |names: &[&str]| {
        let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        if names.is_empty() { "none: outside the catalogue".to_owned() } else { names.join(", ") }
    };
    let mut text = "| hidden | names that are right |\n|---|---|\n".to_owned();
    for hidden in HIDDEN {
        text += &format!("| {} | {} |\n", names(hidden.names), names(hidden.right));
    }
    text += "\n| generator | name | right | reason |\n|---|---|---|---|\n";
    for convention in CONVENTIONS {
        let Convention { generator, name, applies, reason } = convention;
        let (generator, applies) = (generator.name(), applies.words());
        text += &format!("| {generator} | `{name}` | {applies} | {reason} |\n");
    }
    text
}

/// The scores of groups as a table in Markdown. Intervals are Wilson's of 95 %.
fn markdown(scores: &OutsideScores) -> String {
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut first = vec![String::new()];
    first.extend(COLUMNS.iter().map(|(heading, _)| (*heading).to_owned()));
    let mut text = row(first) + &row(vec!["---".to_owned(); COLUMNS.len() + 1]);
    for group in &scores.groups {
        let cells = COLUMNS.iter().map(|(_, cell)| cell(group));
        text += &row(std::iter::once(group.title.clone()).chain(cells).collect());
    }
    text += "\n| strength | visible effects named |\n| --- | --- |\n";
    for (strength, recall) in &scores.strengths {
        text += &row(vec![strength.clone(), rate(recall)]);
    }
    text
}

fn csv(opened: &[Opened]) -> String {
    let mut text =
        "case,generator,scene,hidden,verdict,named,exact,wrong,gap_before,gap_after,seconds\n"
            .to_owned();
    for case in opened {
        let names = |is_in: &dyn Fn(&str) -> bool| {
            let names = case.row.effects.iter().map(|finding| finding.name.as_str());
            names.filter(|name| is_in(name)).collect::<Vec<_>>().join(" + ")
        };
        let wrong: Vec<&str> = case
            .named()
            .filter(|finding| !case.is_right(finding))
            .map(|finding| finding.name.as_str())
            .collect();
        let gap = |gap: Option<f64>| gap.map_or_else(String::new, |gap| format!("{gap:.3}"));
        let cells = [
            case.row.id.clone(),
            case.truth.generator.name().to_owned(),
            case.truth.scene.clone(),
            format!("\"{}\"", case.title()),
            case.row.verdict.clone(),
            names(&|_| true),
            case.is_exact().to_string(),
            wrong.join(" + "),
            gap(case.row.gap_before),
            gap(case.row.gap_after),
            format!("{:.1}", case.row.seconds),
        ];
        text += &cells.join(",");
        text.push('\n');
    }
    text
}

pub(super) fn write(dir: &Path, opened: &[Opened], scores: &OutsideScores) -> Result<()> {
    for (name, text) in texts(opened, scores)? {
        files::write(dir, name, text.as_bytes())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outside::{example, score::score_cases};

    #[test]
    fn tables_have_a_row_for_each_group_and_each_case() {
        let opened = example::opened();
        let scores = score_cases(&opened, Vec::new());
        let markdown = markdown(&scores);
        let rows: Vec<&str> = markdown.lines().take_while(|line| !line.is_empty()).collect();
        assert_eq!(rows.len(), scores.groups.len() + 2);
        assert!(rows.iter().all(|row| row.matches('|').count() == COLUMNS.len() + 2));
        assert_eq!(csv(&opened).lines().count(), opened.len() + 1);
        assert!(lines(&scores).iter().any(|line| line.starts_with("DVS-Voltmeter")));
    }
}

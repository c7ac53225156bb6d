//! The results of a study: tables with notes and curves, the same as Markdown, on the terminal and as a page.

use anyhow::Result;
use evpose_report::chart::{self, Series};
use evpose_report::colour::{PALETTE, palette};
use evpose_report::html::{HtmlPage, escape};

/// Characters of a cell of a page that stand in one line.
const LINE: usize = 34;

/// A table with what is said of it. Without rows it is on the page alone, for its curves.
#[derive(Debug, Default)]
pub(crate) struct StudyTable {
    pub(crate) title: String,
    pub(crate) columns: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
    /// Legend and verdicts, a paragraph each.
    pub(crate) notes: Vec<String>,
    /// Charts, SVG.
    pub(crate) curves: Vec<String>,
}

impl StudyTable {
    pub(crate) fn new(
        title: &str,
        columns: impl IntoIterator<Item = impl AsRef<str>>,
        rows: impl Iterator<Item = Vec<String>>,
        note: &str,
    ) -> Self {
        let (columns, rows) = (strings(columns), rows.collect());
        Self { columns, rows, ..Self::charts(title, note, Vec::new()) }
    }

    pub(crate) fn charts(title: &str, note: &str, curves: Vec<String>) -> Self {
        let notes = strings(Some(note).filter(|note| !note.is_empty()));
        Self { title: title.to_owned(), notes, curves, ..Self::default() }
    }
}

#[derive(Debug)]
pub(crate) struct StudyReport {
    pub(crate) title: String,
    pub(crate) about: String,
    pub(crate) tables: Vec<StudyTable>,
    /// Texts behind a fold of the page: configs, descriptions of rows.
    pub(crate) details: Vec<(String, String)>,
}

impl StudyReport {
    /// As Markdown whose columns are aligned, for reading as it is.
    pub(crate) fn markdown(&self) -> String {
        let tables = self.tables.iter().filter(|table| !table.rows.is_empty()).map(|table| {
            let notes: String = table.notes.iter().map(|note| format!("\n{note}\n")).collect();
            format!("\n## {}\n\n{}{notes}", table.title, align(&table.columns, &table.rows))
        });
        format!("# {}\n\n{}\n", self.title, self.about) + &tables.collect::<String>()
    }

    pub(crate) fn html(&self) -> String {
        let mut page = HtmlPage::new(&self.title, &self.about);
        let cell = |cell: &String| match cell.chars().count() > LINE {
            true => format!("<span class=\"words\">{}</span>", escape(cell)),
            false => escape(cell),
        };
        for table in self.tables.iter().filter(|t| !(t.rows.is_empty() && t.curves.is_empty())) {
            let (first, rest) = table
                .notes
                .split_first()
                .map_or(("", &[][..]), |(first, rest)| (first.as_str(), rest));
            page.section(&table.title, first);
            rest.iter().for_each(|note| page.markup(&format!("<p>{}</p>", escape(note))));
            if !table.rows.is_empty() {
                let columns: Vec<&str> = table.columns.iter().map(String::as_str).collect();
                let rows = table.rows.iter().map(|row| row.iter().map(cell).collect());
                page.table(&columns, &rows.collect::<Vec<_>>());
            }
            if !table.curves.is_empty() {
                page.plots(&table.curves);
            }
        }
        for (name, text) in &self.details {
            page.details(name, text);
        }
        page.finish()
    }
}

fn align(columns: &[String], rows: &[Vec<String>]) -> String {
    // In characters, not bytes: cells hold `±`.
    let width = |column: usize| {
        let cells = rows.iter().map(|row| &row[column]).chain([&columns[column]]);
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns.len()).map(width).collect();
    let last = widths.len().saturating_sub(1);
    let line = |cells: &[String]| {
        let cells = cells.iter().zip(&widths).enumerate().map(|(i, (cell, &width))| match i {
            // Names begin at the left, values end at the right, and words at the end of a line go on.
            0 => format!("{cell:<width$}"),
            _ if i == last => cell.clone(),
            _ => format!("{cell:>width$}"),
        });
        format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "))
    };
    let rule = widths.iter().enumerate().map(|(i, &width)| match i {
        0 => "-".repeat(width + 2),
        _ if i == last => "---".to_owned(),
        _ => "-".repeat(width + 1) + ":",
    });
    let rule = format!("|{}|\n", rule.collect::<Vec<_>>().join("|"));
    line(columns) + &rule + &rows.iter().map(|row| line(row)).collect::<String>()
}

/// Cells or headings.
pub(crate) fn strings<S: AsRef<str>>(texts: impl IntoIterator<Item = S>) -> Vec<String> {
    texts.into_iter().map(|text| text.as_ref().to_owned()).collect()
}

/// The mean of curves of several seeds, point by point.
pub(crate) fn mean_curve<'a>(curves: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
    let curves: Vec<&[f64]> = curves.collect();
    let points = curves.iter().map(|curve| curve.len()).min().unwrap_or(0);
    let at = |i: usize| curves.iter().map(|curve| curve[i]).sum::<f64>() / curves.len() as f64;
    (0..points).map(at).collect()
}

/// Shares of correct joints at 1 %, 2 %, … of the diagonal of the torso, one curve a name. A chart has no more
/// curves than there are colours, and the first one is in all.
pub(crate) fn pck_charts(curves: &[(&str, &[f64])]) -> Result<StudyTable> {
    let Some((first, others)) = curves.split_first() else { return Ok(StudyTable::default()) };
    let line = |(index, (name, curve)): (usize, &(&str, &[f64]))| {
        let points = (1..).zip(*curve).map(|(percent, y)| (f64::from(percent) / 100.0, *y));
        Series::line(*name, palette(index), points.collect())
    };
    let chart = |others: &[(&str, &[f64])]| -> Result<String> {
        let series = std::iter::once(first).chain(others).enumerate().map(line);
        Ok(chart::pck("PCK", "threshold, diagonals of the torso", series.collect())?)
    };
    let curves = match others {
        [] => vec![chart(others)?],
        _ => others.chunks(PALETTE.len() - 1).map(chart).collect::<Result<_>>()?,
    };
    let note = "The share of joints nearer than a threshold, mean over seeds.";
    Ok(StudyTable::charts("Correct joints", note, curves))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> StudyReport {
        let words = "a statement that is longer than a line of a cell".to_owned();
        let table = StudyTable {
            title: "All rows".to_owned(),
            columns: strings(["row", "AUC", "published"]),
            rows: vec![
                vec!["full".to_owned(), "0.6 ± 0.1".to_owned(), "-".to_owned()],
                vec!["a<b".to_owned(), "0.5".to_owned(), words],
            ],
            notes: strings(["Means over seeds.", "Nothing was found."]),
            curves: vec!["<svg>".to_owned()],
        };
        let (title, about) = ("Rows".to_owned(), "Trained here.".to_owned());
        let charts = StudyTable { title: "Curves".to_owned(), ..StudyTable::default() };
        let details = vec![("Config".to_owned(), "seed = 1".to_owned())];
        StudyReport { title, about, tables: vec![table, charts], details }
    }

    #[test]
    fn markdown_is_aligned_and_the_page_holds_what_it_says_and_the_curves() {
        let text = report().markdown();
        let rows = "| row  |       AUC | published |\n|------|----------:|---|\n| full | 0.6 ± 0.1 | - |\n";
        assert!(text.starts_with("# Rows\n\nTrained here.\n\n## All rows\n\n| row "), "{text}");
        assert!(
            text.contains(rows) && text.contains("\n| a<b  |       0.5 | a statement"),
            "{text}"
        );
        assert!(text.ends_with("\nMeans over seeds.\n\nNothing was found.\n"), "{text}");
        let page = report().html();
        assert!(page.contains("<td>a&lt;b</td>") && page.contains("<span class=\"words\">a stat"));
        assert!(page.contains("Nothing was found.") && page.matches("<svg").count() == 1);
        assert!(page.contains("seed = 1") && !page.contains("Curves") && !page.contains("<script"));
    }

    #[test]
    fn a_chart_has_as_many_curves_as_there_are_colours_and_the_first_in_each() -> Result<()> {
        let curve = [0.1, 0.5];
        let charts = |count| {
            Ok::<_, anyhow::Error>(pck_charts(&vec![("a", &curve[..]); count])?.curves.len())
        };
        assert_eq!([charts(0)?, charts(1)?, charts(6)?, charts(7)?], [0, 1, 1, 2]);
        assert_eq!(mean_curve([&[0.0, 1.0][..], &[1.0][..]].into_iter()), [0.5]);
        Ok(())
    }
}

//! The outcome as a page: table, findings, curves.

use anyhow::Result;
use evpose_pose::metric::Pck;

use super::networks_table;
use super::outcome::{Outcome, RowOutcome};
use super::rows::Group;
use super::table;
use super::trial::CURVE_STRIDE;
use evpose_report::chart::{self, Series};
use evpose_report::colour::palette;
use evpose_report::html::{HtmlPage, escape};

/// Charts: group, heading and text.
const CHARTS: [(Group, &str, &str); 3] = [
    (
        Group::Input,
        "Input of the network",
        "Windows of other lengths, and representations without time stamps.",
    ),
    (Group::Method, "Augmentation and filter", "Without augmentation, and without the filter."),
    (Group::Backbone, "The network", "Other backbones at the same relative width."),
];

/// The page as one HTML document.
pub(super) fn html(outcome: &Outcome, config: &str) -> Result<String> {
    let mut page = HtmlPage::new(
        "Ablation of the hand method",
        "Every row is the full method with one thing changed, simulated, trained and evaluated by \
         evpose on this machine.",
    );
    page.section("All rows", &table::legend(outcome));
    // The last column, what was published, has a table of its own below.
    let header = table::header();
    let figures = header.len() - 1;
    let rows = table::rows(outcome);
    page.text_table(&header[..figures], rows.iter().map(|row| &row[..figures]));

    page.section(
        "Published findings",
        "Statements of the supplement of EventHands, and their tests: the difference of the areas under \
         the curves (of poses per second for statements about speed) between the row and the one it is \
         compared with.",
    );
    page.table(&["row", "published", "measure", "difference", "here"], &findings(outcome));

    if let Some(rows) = networks_table::rows(outcome) {
        page.section("The networks", networks_table::LEGEND);
        page.text_table(&networks_table::HEADER, rows);
    }

    for (group, heading, text) in CHARTS {
        let shown = |row: &&RowOutcome| row.row.group == group || row.row.group == Group::Full;
        let shown: Vec<&RowOutcome> = outcome.rows.iter().filter(shown).collect();
        if shown.len() < 2 {
            continue;
        }
        page.section(heading, text);
        page.plots(&[
            curves("3D, relative to the wrist", "threshold in mm", &shown, |row| &row.pck_3d)?,
            curves("2D", "threshold in percent of the palm", &shown, |row| &row.pck_2d)?,
        ]);
    }
    page.section("How it was made", "");
    let about = outcome.rows.iter().map(|row| format!("{}: {}", row.name, row.about));
    page.details("Rows", &about.collect::<Vec<_>>().join("\n"));
    page.details("Config of the full method", config);
    Ok(page.finish())
}

fn findings(outcome: &Outcome) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for row in &outcome.rows {
        for finding in &row.findings {
            for check in &finding.checks {
                let difference = table::difference(&check.difference, check.measure);
                let verdict = check.verdict.to_string();
                let [name, words, measure, difference, verdict] =
                    [row.name, finding.published, check.measure, &difference, &verdict].map(escape);
                let words = format!("<span class=\"words\">{words}</span>");
                rows.push(vec![name, words, measure, difference, verdict]);
            }
        }
    }
    rows
}

/// Shares of correct points, mean over seeds, one curve a row.
fn curves(
    title: &str,
    x: &str,
    rows: &[&RowOutcome],
    get: fn(&RowOutcome) -> &Vec<f64>,
) -> Result<String> {
    let curves = rows
        .iter()
        .enumerate()
        .map(|(index, row)| {
            let points = get(row).iter().enumerate();
            let points = points.map(|(i, &share)| (Pck::threshold(i * CURVE_STRIDE), share));
            Series::line(row.name, palette(index), points.collect())
        })
        .collect();
    Ok(chart::pck(title, x, curves)?)
}

#[cfg(test)]
mod tests {
    use super::super::outcome::tests::outcome;
    use super::super::rows::FULL;
    use super::*;

    #[test]
    fn the_page_holds_curves_of_every_group_that_ran() -> Result<()> {
        let all = [(FULL, [0.5, 0.6, 0.7]), ("eoi", [0.4, 0.5, 0.6])];
        let page = html(&outcome(&all)?, "seed = 1")?;
        // Input and, through the full method, the filter: two charts each.
        assert_eq!(page.matches("<svg").count(), 4);
        assert!(page.contains("LNES beats EOI at 100 ms") && !page.contains("The network</h2>"));
        assert!(!page.contains("<script"));
        Ok(())
    }
}

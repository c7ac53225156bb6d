//! The outcome as a page: curves, tables, orderings.

use anyhow::Result;
use evpose_report::colour::PALETTE;
use evpose_report::html::{HtmlPage, escape};

use crate::compare::measure::Measure;
use crate::compare::outcome::{Outcome, SystemOutcome};
use crate::compare::system::MOVE_ENET;
use crate::compare::table;
use crate::study::pck_chart;

/// The page as one HTML document.
pub(crate) fn html(outcome: &Outcome, configs: &str) -> Result<String> {
    let mut page = HtmlPage::new(
        "Systems that estimate poses of people",
        "Trained and evaluated by evpose on this machine, on people that are in no training set.",
    );
    page.section("Correct joints", "The share of joints nearer than a threshold, mean over seeds.");
    page.plots(&curves(outcome)?);
    page.section("All systems", &table::legend(outcome));
    let header = table::header();
    let figures = header.len() - 1;
    let ran = outcome.systems.iter().filter(|system| system.missing.is_none());
    let rows: Vec<Vec<String>> = ran.map(table::cells).collect();
    page.text_table(&header[..figures], rows.iter().map(|row| &row[..figures]));
    missing(&mut page, outcome);
    page.section(
        "Published orderings",
        "Statements of MoveEnet's tables and text about two systems, and their tests: the first system \
         minus the second.",
    );
    let rows: Vec<Vec<String>> = outcome
        .orderings
        .iter()
        .map(|ordering| {
            vec![
                format!("<span class=\"words\">{}</span>", escape(&ordering.statement)),
                escape(&table::difference(ordering)),
                escape(&table::verdict(ordering)),
            ]
        })
        .collect();
    page.table(&["published", "difference here", "here"], &rows);
    published(&mut page, outcome);
    let about = outcome.systems.iter().map(|system| format!("{}: {}", system.name, system.about));
    page.details("Systems", &about.collect::<Vec<_>>().join("\n"));
    page.details("Configs of both stages of MoveEnet", configs);
    Ok(page.finish())
}

/// Charts with as many curves as there are colours; MoveEnet is in each.
fn curves(outcome: &Outcome) -> Result<Vec<String>> {
    let has_curve = |system: &&SystemOutcome| !system.curve.is_empty();
    let (ours, others): (Vec<&SystemOutcome>, Vec<&SystemOutcome>) =
        outcome.systems.iter().filter(has_curve).partition(|system| system.name == MOVE_ENET);
    let room = PALETTE.len() - ours.len();
    let chart = |others: &[&SystemOutcome]| {
        pck_chart(ours.iter().chain(others).map(|system| (system.name, &*system.curve)))
    };
    if others.is_empty() {
        return Ok(vec![chart(&[])?]);
    }
    others.chunks(room).map(chart).collect()
}

/// Systems that did not run, and how to make them.
fn missing(page: &mut HtmlPage, outcome: &Outcome) {
    let rows: Vec<Vec<String>> = outcome
        .systems
        .iter()
        .filter_map(|system| {
            let reason = escape(system.missing.as_ref()?);
            Some(vec![escape(system.name), format!("<span class=\"words\">{reason}</span>")])
        })
        .collect();
    if !rows.is_empty() {
        page.section("Systems that did not run", "No figure here stands for them.");
        page.table(&["system", "reason"], &rows);
    }
}

/// Published figures beside those of here.
fn published(page: &mut HtmlPage, outcome: &Outcome) {
    let figures = outcome
        .systems
        .iter()
        .flat_map(|system| system.published.iter().map(move |figure| (system, figure)));
    let rows = figures.map(|(system, figure)| {
        let measure: Measure = figure.measure;
        let here = system.mean(measure).map_or_else(
            || "-".to_owned(),
            |mean| format!("{:.*}", measure.digits(), mean.estimate),
        );
        let (set, value) = (figure.data_set.to_string(), figure.value.to_string());
        [system.name.to_owned(), measure.name().to_owned(), set, value, here]
    });
    page.section(
        "Published figures",
        "Of other people before other cameras, beside those of here.",
    );
    page.text_table(&["system", "measure", "published on", "published", "here"], rows);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::outcome::tests::outcome;

    #[test]
    fn the_page_holds_curves_figures_and_what_is_missing() -> Result<()> {
        let page = html(&outcome(&[0.8, 0.6, 0.7])?, "seed = 1")?;
        assert_eq!(page.matches("<svg").count(), 1, "two systems in one chart");
        assert!(page.contains("lift-mono worse than move-enet") && page.contains("26.79"));
        assert!(page.contains("openpose-pim") && page.contains("give --openpose FILE.onnx"));
        assert!(!page.contains("<script") && page.contains("</html>"));
        Ok(())
    }
}

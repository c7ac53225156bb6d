//! The page of a benchmark: what is reached, and what it rests on.

mod charts;
mod groups;
mod matrix;

use anyhow::Result;

use super::confusion::Confusion;
use super::opened::Opened;
use super::own::OwnRow;
use super::score::Scores;
use super::table::{cases, figure, interval, target, word};
use super::targets::{Headline, Reached};
use evpose_report::html::{HtmlPage, escape};

pub(super) const NAME: &str = "index.html";

const STYLE: &str = "<style>
svg text{font-family:system-ui,sans-serif}
.goal{color:#0a7d56;font-weight:600}.met{color:#8a6100;font-weight:600}
.missed{color:#a3262e;font-weight:700}
.plots{align-items:flex-start}
td:last-child,th:last-child{text-align:left}
.scroll{max-height:420px;overflow:auto;border:1px solid var(--line);background:#fff;padding:0 10px}
.wide{overflow-x:auto}.wrap td{white-space:normal;text-align:left}.wrap th{text-align:left}
</style>";

pub(super) fn page(opened: &[Opened], scores: &Scores, own: &[OwnRow]) -> Result<String> {
    let mut page = HtmlPage::new(
        "Hidden effects: what is found and what is not",
        &format!(
            "{}: recordings of an independent pixel, named without their labels.",
            cases(scores)
        ),
    );
    page.markup(STYLE);
    headlines(&mut page, scores);
    groups::section(&mut page, scores);
    if scores.own.is_some() {
        page.section(
            "Recordings of our own model",
            "Nothing is missing here, so that probabilities must be uniform: steps along the line, \
             inside the grey band in 95 of 100 benchmarks at each place.",
        );
        page.plots(&[charts::quantiles(own)?]);
    }
    page.section(
        "What was said of what",
        "Rows: what is hidden, with singles first. Columns: what was said. Green is what is to be \
         said, red a name that is not there, grey neither. Cells count cases.",
    );
    page.markup(&format!(
        "<div class=\"wide\">{}</div>",
        matrix::svg(&Confusion::from_cases(opened))?
    ));
    if !scores.power.is_empty() {
        page.section(
            "How strong an effect must be",
            "Share of singles that are named right at each of four strengths, with intervals of \
             95 %. The number of cases in which it can be seen at all is below each strength.",
        );
        page.plots(&charts::power(&scores.power)?);
    }
    if !scores.reliability.is_empty() {
        page.section(
            "Whether probabilities hold",
            "The stated probability of the first name of each case, and the share of them that is \
             right, with intervals of 95 %. On the line they hold.",
        );
        page.plots(&[charts::reliability(&scores.reliability)?]);
    }
    if !scores.coverage.is_empty() {
        page.section(
            "Whether intervals hold",
            "Share of the estimates of right names whose interval of 90 % holds the true value, by \
             parameter, with intervals of 95 %. On the right, the relative errors of the estimates.",
        );
        page.plots(&[charts::coverage(&scores.coverage)?, charts::errors(&scores.estimates)?]);
    }
    page.section("How long it takes", "Seconds a case, to make its files and to name from them.");
    page.plots(&[charts::times(opened)?]);
    misses(&mut page, opened, scores);
    if !scores.notes.is_empty() {
        page.section("Cases with a note", "");
        page.details("All notes", &scores.notes.join("\n"));
    }
    page.section("Provenance", "");
    page.details(
        "Programs and plan",
        &format!("{}\nprograms {}", cases(scores), scores.commits.join(", ")),
    );
    Ok(page.finish())
}

fn headlines(page: &mut HtmlPage, scores: &Scores) {
    page.section(
        "What is to be reached",
        "Figures are strict: a source follower for a low-pass whose follower is too fast to be seen \
         is a wrong name. The counts of a lenient rule are beside them.",
    );
    let row = |headline: &Headline| {
        let unit = headline.unit;
        let class = match headline.reached() {
            Reached::Goal => "goal",
            Reached::Required => "met",
            Reached::Missed => "missed",
            Reached::Unknown => "soft",
        };
        vec![
            escape(headline.name),
            escape(&headline.cases),
            headline.value.map_or_else(|| "-".to_owned(), |v| figure(unit, v)),
            format!("<small>{}</small>", escape(&interval(headline))),
            headline.required.map_or_else(String::new, |aim| escape(&target(unit, aim))),
            headline.goal.map_or_else(String::new, |aim| escape(&target(unit, aim))),
            format!("<span class=\"{class}\">{}</span>", word(headline.reached())),
            format!("<small>{}</small>", escape(&headline.note)),
        ]
    };
    let rows: Vec<Vec<String>> = scores.headlines.iter().map(row).collect();
    let header = ["", "cases", "figure", "95 % interval", "required", "goal", "", ""];
    page.table(&header, &rows);
}

fn misses(page: &mut HtmlPage, opened: &[Opened], scores: &Scores) {
    page.section(
        "What went wrong",
        &format!(
            "{} cases: names that are not there, and visible effects that were not identified.",
            scores.misses.len()
        ),
    );
    if scores.misses.is_empty() {
        return;
    }
    let row = |case: &Opened| {
        let scene = case.truth.scene.clone();
        let strength = case.truth.strength.map_or_else(String::new, |s| s.to_string());
        // The three best: the column has no room for more.
        let tried = case.row.tried.first().map_or_else(String::new, |tried| {
            let first = tried.iter().take(3);
            first.map(|(name, left)| format!("{name} {left:.0}")).collect::<Vec<_>>().join(", ")
        });
        let answer = if case.is_wrong() {
            format!("<span class=\"missed\">{}</span>", escape(&case.answer_label()))
        } else {
            escape(&case.answer_label())
        };
        let names = case.names().join(" + ");
        // Not twice: most answers are nothing but the names.
        let named = if case.answer_label() == names { String::new() } else { escape(&names) };
        let gap = format!("{:.2} to {:.2}", case.row.gap_before, case.row.gap_after);
        let (title, hidden) = (escape(&case.title()), escape(&case.hidden()));
        vec![case.row.id.clone(), title, hidden, strength, scene, answer, named, gap, tried]
    };
    let rows: Vec<Vec<String>> = opened.iter().filter(|case| case.is_miss()).map(row).collect();
    page.markup("<div class=\"scroll wrap\">");
    let header = [
        "case",
        "row",
        "hidden",
        "strength",
        "scene",
        "said",
        "names",
        "gap",
        "best, with the discrepancy they leave",
    ];
    page.table(&header, &rows);
    page.markup("</div>");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{example, own, score};

    #[test]
    fn the_page_holds_all_that_was_scored_and_nothing_from_elsewhere() -> Result<()> {
        let mut opened = example::opened();
        for (i, case) in opened.iter_mut().enumerate() {
            for effect in &mut case.row.effects {
                effect.probability = Some(0.3 + 0.7 * ((i * 37) % 100) as f64 / 100.0);
                if i % 11 == 0 {
                    effect.name = "reset_overshoot".to_owned();
                }
            }
        }
        let own: Vec<OwnRow> = (0..200)
            .map(|set| OwnRow {
                set,
                case: String::new(),
                p: ((set * 73) % 200 + 1) as f64 / 200.0,
                events: 1,
                seconds: 1.0,
            })
            .collect();
        let scores = score::score_cases(&opened, own::summary(&own), Vec::new());
        let text = page(&opened, &scores, &own)?;
        for words in [
            "visible singles named right",
            "runs of our own model",
            "reset_overshoot",
            "MISSED",
            "goal met",
            "never catalogued",
            "two effects",
        ] {
            assert!(text.contains(words), "{words}");
        }
        assert!(
            !text.contains("http://")
                || text.matches("http://").count()
                    == text.matches("xmlns=\"http://www.w3.org/2000/svg\"").count()
        );
        assert!(!text.contains("<script src") && !text.contains("NaN"));
        Ok(())
    }

    #[test]
    fn a_page_of_no_cases_is_a_page() -> Result<()> {
        let scores = score::score_cases(&[], None, Vec::new());
        assert!(page(&[], &scores, &[])?.contains("0 cases of"));
        Ok(())
    }
}

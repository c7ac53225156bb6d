//! Recall and precision by the count of hidden effects, as a table.

use crate::group::Group;
use crate::score::Scores;
use crate::stats::Rate;
use crate::table::figure;
use crate::targets::Unit;
use evpose_report::html::HtmlPage;

pub(super) fn section(page: &mut HtmlPage, scores: &Scores) {
    page.section(
        "By the count of hidden effects",
        "Recall: visible effects that are named. Precision: names that are right; those of \
         conventions are, and count no miss where they are missing. As expected: cases whose set of \
         names is exact, or whose answer is the right one. Wrong name: cases with a name that is not \
         there. Intervals are of 95 %.",
    );
    let cell = |rate: &Rate| match rate.share {
        None => "-".to_owned(),
        Some(share) => format!(
            "{}/{} ({}) <small>{} to {}</small>",
            rate.of,
            rate.n,
            figure(Unit::Share, share),
            figure(Unit::Share, rate.lo95),
            figure(Unit::Share, rate.hi95)
        ),
    };
    let row = |group: &Group| {
        let seconds = group.seconds.map_or_else(String::new, |seconds| {
            format!(
                "{:.1} <small>{:.1} to {:.1}</small>",
                seconds.value, seconds.lo95, seconds.hi95
            )
        });
        vec![
            group.name.to_owned(),
            group.cases.to_string(),
            cell(&group.recall),
            cell(&group.precision),
            cell(&group.exact),
            cell(&group.wrong),
            seconds,
        ]
    };
    let rows: Vec<Vec<String>> = scores.groups.iter().map(row).collect();
    let header = ["", "cases", "recall", "precision", "as expected", "wrong name", "median s"];
    page.table(&header, &rows);
}

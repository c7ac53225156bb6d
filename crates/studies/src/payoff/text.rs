//! The result as lines of text.

use evpose_cli::pages::held_out::cell;
use evpose_cli::tasks::Metric;
use evpose_core::stats::interval::Interval;

use crate::payoff::models::{CORRECTED_MODEL, GIVEN};
use crate::payoff::study::Payoff;
use crate::payoff::table::{MetricRow, Worth};

/// Width of the first column and of the others.
const COLUMNS: (usize, usize) = (16, 26);

/// A value with its interval.
pub(crate) fn value(interval: Option<Interval>, metric: &Metric) -> String {
    let (estimate, bounds) = cell(interval, metric.digits);
    format!("{estimate} {bounds}").trim_end().to_owned()
}

/// A difference with its sign and its interval.
pub(crate) fn difference(interval: Option<Interval>, metric: &Metric) -> String {
    let digits = metric.digits;
    match interval {
        None => "-".to_owned(),
        Some(Interval { estimate, low: Some(low), high: Some(high) }) => {
            format!("{estimate:+.digits$} [{low:+.digits$}, {high:+.digits$}]")
        }
        Some(Interval { estimate, .. }) => format!("{estimate:+.digits$}"),
    }
}

/// Meaning of the main metric's difference, in a sentence.
pub(crate) fn sentence(payoff: &Payoff) -> String {
    let Some(row) = payoff.table.rows.first() else { return "Nothing was measured.".to_owned() };
    let worth = difference(row.difference, &row.metric);
    let heading = row.metric.heading;
    let recordings = payoff.table.recordings;
    match row.worth() {
        Worth::Better => format!(
            "Closing the gap was worth {worth} of {heading} on {recordings} recordings of the \
             measured camera."
        ),
        Worth::Worse => format!(
            "The corrected model trains a worse network: {worth} of {heading} on {recordings} \
             recordings of the measured camera."
        ),
        Worth::Undecided => format!(
            "These {recordings} recordings show no difference between the networks: {worth} of \
             {heading}."
        ),
    }
}

/// Headings of the table.
pub(crate) fn header(payoff: &Payoff) -> Vec<String> {
    let has_bound = payoff.models.len() > 2;
    let mut header = vec!["trained on".to_owned()];
    header.extend(payoff.models.iter().map(|model| (*model).to_owned()));
    header.push(format!("{CORRECTED_MODEL} - {GIVEN}"));
    header.extend(has_bound.then(|| "of what can be gained".to_owned()));
    header
}

/// Cells of a metric's row.
pub(crate) fn cells(payoff: &Payoff, row: &MetricRow) -> Vec<String> {
    let mut cells = vec![row.metric.heading.to_owned()];
    let scores = payoff.models.iter().map(|model| row.scores.get(model).copied().flatten());
    cells.extend(scores.map(|score| value(score, &row.metric)));
    cells.push(difference(row.difference, &row.metric));
    if payoff.models.len() > 2 {
        let (estimate, bounds) = cell(row.fraction_of_upper_bound, 2);
        cells.push(format!("{estimate} {bounds}").trim_end().to_owned());
    }
    cells
}

/// The differences under each seed, in a line; none for a single seed.
pub(crate) fn seeds(payoff: &Payoff, row: &MetricRow) -> Option<String> {
    let digits = row.metric.digits;
    let of = |(seed, difference): (&u64, &Option<f64>)| {
        let value = difference.map_or_else(|| "-".to_owned(), |d| format!("{d:+.digits$}"));
        format!("seed {seed}: {value}")
    };
    let each: Vec<String> = payoff.seeds.iter().zip(&row.difference_by_seed).map(of).collect();
    (each.len() > 1).then(|| format!("{} by seed: {}", row.metric.heading, each.join(", ")))
}

/// Everything that is printed.
pub(crate) fn lines(payoff: &Payoff) -> Vec<String> {
    let line = |cells: Vec<String>| {
        let mut text = String::new();
        for (index, cell) in cells.iter().enumerate() {
            let width = if index == 0 { COLUMNS.0 } else { COLUMNS.1 };
            text += &if index == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") };
        }
        text.trim_end().to_owned()
    };
    let mut lines = vec![sentence(payoff), String::new(), line(header(payoff))];
    lines.extend(payoff.table.rows.iter().map(|row| line(cells(payoff, row))));
    lines.extend(payoff.table.rows.iter().filter_map(|row| seeds(payoff, row)));
    lines
}

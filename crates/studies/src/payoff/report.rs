//! The result as tables and charts.

use anyhow::Result;
use evpose_cli::pages::held_out::cell;
use evpose_cli::tasks::Metric;
use evpose_core::stats::interval::Interval;
use evpose_report::bars::{self, Along, Bar};
use evpose_report::chart::{self, Chart, ChartAxis, Mark, Series};
use evpose_report::colour::palette;

use crate::payoff::models::{CORRECTED_MODEL, GIVEN};
use crate::payoff::study::Payoff;
use crate::payoff::table::MetricRow;
use crate::study::{StudyReport, StudyTable, Verdict, strings};

/// Size of the chart of differences, pixels.
const DIFFERENCES: (u32, u32) = (560, 300);

pub(crate) fn report(payoff: &Payoff, details: Vec<(String, String)>) -> Result<StudyReport> {
    let mut tables = vec![accuracy(payoff)?];
    if let Some(row) = payoff.table.rows.first() {
        let note = "The difference on each recording, sorted. Blue: the corrected model trains the better network; \
                    orange: the worse.";
        tables.push(StudyTable::charts("Recording by recording", note, vec![differences(row)?]));
    }
    let facts = payoff.facts().into_iter().map(|(name, value)| vec![name.to_owned(), value]);
    tables.push(StudyTable::new("Study", ["fact", "value"], facts, ""));
    let title = "What closing the gap is worth".to_owned();
    Ok(StudyReport { title, about: sentence(payoff), tables, details })
}

fn accuracy(payoff: &Payoff) -> Result<StudyTable> {
    let has_bound = payoff.models.len() > 2;
    let mut columns = strings(["metric"].iter().chain(&payoff.models));
    columns.push(format!("{CORRECTED_MODEL} - {GIVEN}"));
    columns.extend(has_bound.then(|| "of what can be gained".to_owned()));
    let rows = &payoff.table.rows;
    let note = "Networks of the same seed and the same number of steps, trained on simulations of the same scenes, \
                evaluated on the same recordings of the measured camera. Intervals of 95 % by a bootstrap over whole \
                recordings; differences are paired by recording.";
    let cells = rows.iter().map(|row| cells(payoff, row));
    let mut table = StudyTable::new("Accuracy", columns, cells, note);
    table.notes.extend(rows.iter().filter_map(|row| by_seed(payoff, row)));
    table.curves = rows.iter().map(|row| score_bars(payoff, row)).collect::<Result<_>>()?;
    Ok(table)
}

fn cells(payoff: &Payoff, row: &MetricRow) -> Vec<String> {
    let value = |interval: Option<Interval>, digits: usize| {
        let (estimate, bounds) = cell(interval, digits);
        format!("{estimate} {bounds}").trim_end().to_owned()
    };
    let mut cells = vec![row.metric.heading.to_owned()];
    let scores = payoff.models.iter().map(|model| row.scores.get(model).copied().flatten());
    cells.extend(scores.map(|score| value(score, row.metric.digits)));
    cells.push(difference(row.difference, &row.metric));
    let has_bound = payoff.models.len() > 2;
    cells.extend(has_bound.then(|| value(row.fraction_of_upper_bound, 2)));
    cells
}

/// A difference with its sign and its interval.
fn difference(interval: Option<Interval>, metric: &Metric) -> String {
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
fn sentence(payoff: &Payoff) -> String {
    let Some(row) = payoff.table.rows.first() else { return "Nothing was measured.".to_owned() };
    let worth = format!("{} of {}", difference(row.difference, &row.metric), row.metric.heading);
    let recordings = format!("{} recordings of the measured camera", payoff.table.recordings);
    // The relation that is tested is `worse`: where it is reversed, the correction helped.
    match row.is_worse() {
        Some(Verdict::Reversed) => format!("Closing the gap was worth {worth} on {recordings}."),
        Some(Verdict::Found) => {
            format!("The corrected model trains a worse network: {worth} on {recordings}.")
        }
        _ => {
            format!("No difference between the networks can be seen on {recordings}: {worth}.")
        }
    }
}

/// The differences under each seed, in a line; none for a single seed.
fn by_seed(payoff: &Payoff, row: &MetricRow) -> Option<String> {
    let digits = row.metric.digits;
    let of = |(seed, difference): (&u64, &Option<f64>)| {
        let value = difference.map_or_else(|| "-".to_owned(), |d| format!("{d:+.digits$}"));
        format!("seed {seed}: {value}")
    };
    let each: Vec<String> = payoff.seeds.iter().zip(&row.difference_by_seed).map(of).collect();
    (each.len() > 1).then(|| format!("{} by seed: {}", row.metric.heading, each.join(", ")))
}

/// A bar for each model.
fn score_bars(payoff: &Payoff, row: &MetricRow) -> Result<String> {
    let bar = |(index, model): (usize, &&'static str)| {
        let score = row.scores.get(model).copied().flatten()?;
        Some(Bar {
            label: (*model).to_owned(),
            value: score.estimate,
            interval: score.low.zip(score.high),
            colour: palette(index),
            note: String::new(),
        })
    };
    let bars: Vec<Bar> = payoff.models.iter().enumerate().filter_map(bar).collect();
    let ends = bars.iter().map(|bar| bar.interval.map_or(bar.value, |interval| interval.1));
    let largest = ends.fold(0.0, f64::max);
    // An axis needs a length, also where all scores are 0.
    let range = (0.0, if largest > 0.0 { 1.05 * largest } else { 1.0 });
    let along = Along { name: row.metric.heading, range, notes: 30.0, ..Along::shares() };
    Ok(bars::svg(&bars, &along)?)
}

/// The differences of all recordings in ascending order, each a stroke from zero.
fn differences(row: &MetricRow) -> Result<String> {
    let mut values: Vec<f64> = row.difference_by_recording.iter().copied().flatten().collect();
    values.sort_by(f64::total_cmp);
    let last = values.len() as f64;
    // The line at zero comes first, under all strokes.
    let mut series = vec![Series::line("", palette(4), vec![(0.5, 0.0), (last + 0.5, 0.0)])];
    series.extend((1..).map(f64::from).zip(values).map(|(x, value)| {
        let is_better = (value > 0.0) != row.metric.is_error;
        let colour = palette(usize::from(!is_better));
        // Wide enough to be seen: a band, not a line.
        let corners = [(-0.3, 0.0), (0.3, 0.0), (0.3, value), (-0.3, value)];
        let points = corners.map(|(dx, y)| (x + dx, y)).to_vec();
        Series { label: String::new(), colour, mark: Mark::Band, points }
    }));
    let name = format!("{}, {CORRECTED_MODEL} - {GIVEN}", row.metric.heading);
    let chart = Chart {
        title: String::new(),
        x: ChartAxis::new("recording").whole(),
        y: ChartAxis::new(&name).from_zero(),
        series,
    };
    Ok(chart::svg(&chart, DIFFERENCES)?)
}

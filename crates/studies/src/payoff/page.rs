//! The result as a page.

use anyhow::Result;
use evpose_report::bars::{self, Along, Bar};
use evpose_report::chart::{self, Chart, ChartAxis, Mark, Series};
use evpose_report::colour::palette;
use evpose_report::html::{HtmlPage, escape};

use crate::payoff::models::{CORRECTED_MODEL, GIVEN, NamedModel};
use crate::payoff::study::Payoff;
use crate::payoff::table::MetricRow;
use crate::payoff::text;

/// Size of the chart of differences, pixels.
const DIFFERENCES: (u32, u32) = (560, 300);

/// The page of a study, with its models and its config.
pub(crate) fn html(payoff: &Payoff, models: &[NamedModel], config: &str) -> Result<String> {
    let mut page = HtmlPage::new("What closing the gap is worth", &text::sentence(payoff));
    page.section(
        "Accuracy",
        "Networks of the same seed and the same number of steps, trained on simulations of the same \
         scenes, evaluated on the same recordings of the measured camera. Intervals of 95 % by a \
         bootstrap over whole recordings; differences are paired by recording.",
    );
    let header = text::header(payoff);
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    page.text_table(&header, payoff.table.rows.iter().map(|row| text::cells(payoff, row)));
    for line in payoff.table.rows.iter().filter_map(|row| text::seeds(payoff, row)) {
        page.markup(&format!("<p class=\"soft\">{}</p>", escape(&line)));
    }
    let rows = payoff.table.rows.iter();
    let plots = rows.map(|row| score_bars(payoff, row)).collect::<Result<Vec<_>>>()?;
    page.plots(&plots);
    if let Some(row) = payoff.table.rows.first() {
        page.section(
            "Recording by recording",
            "The difference on each recording, sorted. Blue: the corrected model trains the better \
             network; orange: the worse.",
        );
        page.plots(&[differences(row)?]);
    }
    page.section("Study", "");
    let facts: Vec<Vec<String>> = payoff
        .facts()
        .into_iter()
        .map(|(name, value)| {
            vec![escape(name), format!("<span class=\"words\">{}</span>", escape(&value))]
        })
        .collect();
    page.table(&["", ""], &facts);
    for model in models {
        page.details(&format!("model: {}", model.name), &model.sensor.to_toml());
    }
    page.details("config", config);
    Ok(page.finish())
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

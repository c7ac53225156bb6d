//! Learning curves: what a training logged, over the samples that it had seen.

use evpose_train::training::TrainingSpan;
use evpose_train::{HistoryLine, HistorySplit};

use evpose_report::chart::{self, Chart, ChartAxis, Series};
use evpose_report::colour::palette;
use evpose_report::drawing::DrawingError;

/// Points of a training curve: as many as a chart can show.
const POINTS: usize = 200;
/// Size of one chart of the image, pixels.
const CHART: (u32, u32) = (460, 280);

/// A logged value that is worth a chart.
struct Curve {
    name: &'static str,
    title: &'static str,
    y: &'static str,
    /// Falls by orders of magnitude.
    is_log: bool,
}

/// Values of all tasks; a training has some of them.
const CURVES: [Curve; 7] = [
    Curve { name: "loss", title: "Loss L", y: "L", is_log: true },
    Curve { name: "translation", title: "Wrist position", y: "RMS error in mm", is_log: true },
    Curve { name: "rotation", title: "Wrist rotation", y: "RMS error in degrees", is_log: false },
    Curve { name: "articulation", title: "Articulation", y: "RMS error", is_log: false },
    Curve { name: "accuracy", title: "Joints, one pass", y: "PCK@0.2", is_log: false },
    Curve { name: "heatmap", title: "Heatmaps", y: "loss", is_log: true },
    Curve { name: "offsets", title: "Offsets within cells", y: "loss", is_log: true },
];

/// A chart for each value that was logged, of training and validation.
pub fn charts(history: &[HistoryLine], length: TrainingSpan) -> Vec<Chart> {
    let logged = |curve: &&Curve| history.iter().any(|line| line.values.contains_key(curve.name));
    CURVES.iter().filter(logged).map(|curve| chart_of(curve, history, length)).collect()
}

/// All charts side by side, as an SVG document.
///
/// # Errors
/// If the SVG backend fails.
pub fn image(history: &[HistoryLine], length: TrainingSpan) -> Result<String, DrawingError> {
    chart::grid(&charts(history, length), 2, CHART)
}

fn chart_of(curve: &Curve, history: &[HistoryLine], length: TrainingSpan) -> Chart {
    let y = match curve.is_log {
        true => ChartAxis::log(curve.y),
        false => ChartAxis::new(curve.y).from_zero(),
    };
    Chart {
        title: curve.title.to_owned(),
        x: ChartAxis::new("training samples, in thousands").from_zero(),
        y,
        series: vec![
            Series::line("training", palette(0), training(curve.name, history, length)),
            Series::line("validation", palette(1), validation(curve.name, history, length)),
        ],
    }
}

/// Means over neighbouring steps.
fn training(name: &str, history: &[HistoryLine], length: TrainingSpan) -> Vec<(f64, f64)> {
    let lines: Vec<&HistoryLine> =
        history.iter().filter(|line| line.part == HistorySplit::Train).collect();
    let group = lines.len().div_ceil(POINTS).max(1);
    lines
        .chunks(group)
        .filter_map(|group| {
            let values: Vec<f64> =
                group.iter().filter_map(|line| line.values.get(name).copied()).collect();
            let last = group.last()?;
            // Intervals are counted from 1, batches within each of them.
            let step = (last.interval as u64 - 1) * length.steps_per_validation + last.batch as u64;
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            Some((thousands(step, length), mean))
        })
        .collect()
}

/// Means over the batches of each validation.
fn validation(name: &str, history: &[HistoryLine], length: TrainingSpan) -> Vec<(f64, f64)> {
    let intervals = history.iter().map(|line| line.interval as u64).max().unwrap_or(0);
    (1..=intervals)
        .filter_map(|interval| {
            let (mut sum, mut samples) = (0.0, 0);
            let of_interval = |line: &&HistoryLine| {
                line.part == HistorySplit::Valid && line.interval as u64 == interval
            };
            for line in history.iter().filter(of_interval) {
                // The last batch may be smaller, so that batches are weighted by their samples.
                sum += line.values.get(name)? * line.samples as f64;
                samples += line.samples;
            }
            // The last interval may be cut short.
            let steps = (interval * length.steps_per_validation).min(length.steps);
            (samples > 0).then(|| (thousands(steps, length), sum / samples as f64))
        })
        .collect()
}

fn thousands(steps: u64, length: TrainingSpan) -> f64 {
    (steps * length.batch_size as u64) as f64 / 1e3
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn line(interval: usize, batch: usize, part: HistorySplit, loss: f64) -> HistoryLine {
        let values = BTreeMap::from([("loss".to_owned(), loss), ("other".to_owned(), 1.0)]);
        HistoryLine { interval, batch, part, samples: 10, values }
    }

    #[test]
    fn curves_lie_at_the_samples_that_were_seen() -> Result<(), DrawingError> {
        use HistorySplit::{Train, Valid};
        let length = TrainingSpan { batch_size: 10, steps_per_validation: 2, steps: 3 };
        let history = [
            line(1, 1, Train, 4.0),
            line(1, 2, Train, 3.0),
            line(1, 1, Valid, 5.0),
            line(1, 2, Valid, 7.0),
            line(2, 1, Train, 2.0),
            line(2, 1, Valid, 4.0),
        ];
        let charts = charts(&history, length);
        assert_eq!(charts.len(), 1, "the loss alone is known");
        assert_eq!(charts[0].series[0].points, [(0.01, 4.0), (0.02, 3.0), (0.03, 2.0)]);
        assert_eq!(charts[0].series[1].points, [(0.02, 6.0), (0.03, 4.0)]);
        assert!(image(&history, length)?.contains("validation"));
        Ok(())
    }
}

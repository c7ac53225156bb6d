//! Places of a formula: all pixels, more and more of them to one side, columns, rows, or patches.
//!
//! # Method
//! Statistics of a recording are sums over pixels and over parts of the image. Where values are random, those of a
//! model lie in other places than the camera's, so that a formula of columns may lower the discrepancy less than one
//! of rows, or one that is the same everywhere. How alike neighbours are separates them. Residuals of counts,
//! `2 sqrt(n + 3/8)` less the same of a run without the formula, differ from column to column as much as any
//! two pixels do where columns have values of their own, and less where rows have. Both differences, relative to
//! the variance over the image, are compared with those of runs of each formula. Where those of the formula that
//! was found are too far off, the best of the formulas that come at least twice as near takes its place.

use evpose_core::EventStream;
use evpose_sensor::SensorConfig;

use super::formula_terms::{TERMS, Term};
use crate::{GapError, Objective};

/// Variables that depend on the place alone; a constant has none.
const OF_PLACE: [&str; 6] = ["", "column", "row", "column_noise", "row_noise", "patch"];
/// Stages that change how many events a pixel has.
const STAGES: [&str; 2] = ["threshold", "loss"];
/// Runs of each formula.
const RUNS: u64 = 3;

/// All terms of places at the stage of this one; none if it is none itself.
pub(super) fn of_places(own: &Term) -> Vec<&'static Term> {
    let is_of_place =
        |term: &Term| STAGES.contains(&term.stage) && OF_PLACE.contains(&term.variable);
    let is_other = |term: &&Term| is_of_place(term) && term.stage == own.stage;
    if is_of_place(own) { TERMS.iter().filter(is_other).collect() } else { Vec::new() }
}

/// How far the neighbours of runs of models are from those of the recording in likeness, each as the square of
/// standard errors by the number of columns and rows.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn unlikeness(
    objective: &Objective<'_>,
    models: &[SensorConfig],
    without: &SensorConfig,
) -> Result<Vec<f64>, GapError> {
    let mut squares = vec![f64::INFINITY; models.len()];
    let Some(base) = objective.events_of_run(without, RUNS)? else { return Ok(squares) };
    let measured = differences(&objective.events, &base);
    let lines = [base.sensor().width, base.sensor().height].map(f64::from);
    // Logarithms of variances of so many values.
    let variance = 2.0 / lines[0] + 2.0 / lines[1];
    for (square, model) in squares.iter_mut().zip(models) {
        let mut sum = 0.0;
        for run in 0..RUNS {
            sum += objective.events_of_run(model, run)?.map_or(f64::INFINITY, |events| {
                let simulated = differences(&events, &base);
                (0..2).map(|k| (measured[k] / simulated[k]).ln().powi(2)).sum()
            });
        }
        *square = sum / RUNS as f64 / variance;
    }
    Ok(squares)
}

/// Variance of differences between neighbours along rows and along columns, over that between any two pixels.
fn differences(events: &EventStream, base: &EventStream) -> [f64; 2] {
    let (width, height) = (usize::from(base.sensor().width), usize::from(base.sensor().height));
    let root = |events: &EventStream| {
        let mut counts = vec![0.375; width * height];
        for (x, y) in events.x().iter().zip(events.y()) {
            counts[usize::from(*y) * width + usize::from(*x)] += 1.0;
        }
        counts.into_iter().map(|n: f64| 2.0 * n.sqrt()).collect::<Vec<f64>>()
    };
    let residuals: Vec<f64> = root(events).iter().zip(root(base)).map(|(a, b)| a - b).collect();
    let mean_square = |pairs: &mut dyn Iterator<Item = f64>| {
        let (n, sum) = pairs.fold((0.0, 0.0), |(n, sum), d| (n + 1.0, sum + d * d));
        // Nothing differs in recordings that are the base itself.
        sum / f64::max(n, 1.0) + 1e-9
    };
    let mean = residuals.iter().sum::<f64>() / residuals.len().max(1) as f64;
    let all = 2.0 * mean_square(&mut residuals.iter().map(|r| r - mean));
    let rows = residuals.chunks_exact(width);
    let along = mean_square(&mut rows.flat_map(|row| row.windows(2)).map(|pair| pair[1] - pair[0]));
    let down = mean_square(&mut residuals.iter().zip(&residuals[width..]).map(|(a, b)| b - a));
    [along / all, down / all]
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Micros, Polarity, SensorSize};

    use super::*;

    /// Pixels with this many events each.
    fn stream(count: impl Fn(usize, usize) -> usize) -> EventStream {
        let size = SensorSize { width: 12, height: 8 };
        let pixels = (0..96).map(|i| (i % 12, i / 12));
        let event =
            |(x, y)| Event { t: Micros(0), x: x as u16, y: y as u16, polarity: Polarity::On };
        let events = pixels.flat_map(|at| std::iter::repeat_n(event(at), count(at.0, at.1)));
        EventStream::from_events(size, events).unwrap()
    }

    #[test]
    fn columns_differ_along_rows_and_rows_along_columns() {
        let base = stream(|_, _| 9);
        let [along, down] = differences(&stream(|x, _| 4 + 5 * (x * x % 5)), &base);
        assert!(along > 0.5 && down < 1e-6, "{along} {down}");
        let [along, down] = differences(&stream(|_, y| 4 + 5 * (y * y % 5)), &base);
        assert!(along < 1e-6 && down > 0.5, "{along} {down}");
    }

    #[test]
    fn losses_and_thresholds_have_terms_of_places() {
        let count = |stage: &str, variable: &str| {
            let is = |term: &&Term| term.stage == stage && term.variable == variable;
            of_places(TERMS.iter().find(is).unwrap()).len()
        };
        assert_eq!([count("loss", ""), count("loss", "row_noise")], [7, 7]);
        assert_eq!([count("threshold", "patch"), count("threshold", "time_s")], [5, 0]);
        assert_eq!(count("delay", "row"), 0);
    }
}

//! Residuals over the image, its rows and columns, and time, with their significance.
//!
//! # Model
//! Counts are compared as `2 sqrt(n + 3/8)`, of variance one for independent events, scaled by the
//! scatter of runs of the model at counts of that size. The tolerance is one percent of the count.
//! The false discovery rate is 5 %.

use serde::{Deserialize, Serialize};

use super::arrows::{Arrow, arrows};
use super::significance::discoveries;
use crate::View;

const IMAGE_COLUMNS: usize = 96;
/// Number of parts of the window.
const STRIP: usize = 100;
/// Number of outlier pixels that are listed.
const LISTED: usize = 50;
/// Number of runs whose largest outlier is computed.
const NULL_RUNS: usize = 4;
/// Minimum pixels per run in a class of similar counts for a scatter of its own.
const MIN_CLASS: f64 = 100.0;
/// Radius of the neighbourhood of a pixel, pixels.
const RADIUS: usize = 2;
/// Tolerance as a fraction of a count.
const TOLERANCE: f64 = 0.01;
/// Lower bound of the scatter of runs.
const MIN_SCATTER: f64 = 0.5;

/// Residuals of a recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Maps {
    /// Map over the image.
    pub image: ResidualImage,
    /// Profile over rows.
    pub rows: Profile,
    /// Profile over columns.
    pub columns: Profile,
    /// Profile over hundredths of the window.
    pub times: Profile,
    /// Outlier pixels with too many or too few events, the largest deviation first; at most fifty.
    pub pixels: Vec<OddPixel>,
    /// Number of pixels with too many events.
    pub hot: usize,
    /// Number of pixels with too few events.
    pub silent: usize,
    /// Excess events of all hot pixels over the model.
    pub hot_events: f64,
    /// Displacements of parts of the image.
    pub arrows: Vec<Arrow>,
}

/// Residuals over the image, binned to blocks of pixels.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ResidualImage {
    /// Columns of the map.
    pub width: usize,
    /// Rows of the map.
    pub height: usize,
    /// Side of a block, pixels.
    pub side_px: usize,
    /// Residuals of blocks, row by row.
    pub residuals: Profile,
}

/// Residuals along a line.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// In standard deviations, positive where more events were measured.
    pub z: Vec<f64>,
    /// Significance of each residual.
    pub is_significant: Vec<bool>,
}

/// A pixel that deviates from the model and from its neighbours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OddPixel {
    /// Column.
    pub x: u16,
    /// Row.
    pub y: u16,
    /// Number of measured events.
    pub measured: f64,
    /// Mean number of events over runs of the model.
    pub expected: f64,
    /// Deviation in standard deviations, minus the mean of its neighbours.
    pub z: f64,
}

/// Computes all maps of a recording against runs of the model.
pub(super) fn maps(measured: &View<'_>, runs: &[View<'_>]) -> Maps {
    let size = measured.size();
    let (width, height) = (usize::from(size.width), usize::from(size.height));
    let count = |view: &View<'_>| {
        let mut counts = vec![0.0; width * height];
        for event in view.events() {
            counts[event.pixel as usize] += 1.0;
        }
        counts
    };
    let pixels = count(measured);
    let of_runs: Vec<Vec<f64>> = runs.iter().map(count).collect();
    let side = width.div_ceil(IMAGE_COLUMNS);
    let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
    let along = |bins: usize, bin: &dyn Fn(usize) -> usize| {
        let sum = |counts: &Vec<f64>| {
            let mut sums = vec![0.0; bins];
            for (p, count) in counts.iter().enumerate() {
                sums[bin(p)] += count;
            }
            sums
        };
        Profile::from_counts(&sum(&pixels), &of_runs.iter().map(sum).collect::<Vec<_>>())
    };
    let strip = |view: &View<'_>| {
        let mut counts = vec![0.0; STRIP];
        let length = view.window.length().0.max(1) as usize;
        for event in view.events() {
            let since = view.since_start_us(event.t_us).max(0) as usize;
            counts[(since * STRIP / length).min(STRIP - 1)] += 1.0;
        }
        counts
    };
    // Minus the neighbours: a model that is wrong over a region has no outlier pixels for that.
    let alone = minus_neighbours(&Profile::from_counts(&pixels, &of_runs).z, width);
    // Some models have outlier pixels of their own: only larger ones than between runs count.
    let of_run = |i: usize| {
        let others: Vec<&Vec<f64>> =
            of_runs.iter().enumerate().filter(|(k, _)| *k != i).map(|(_, run)| run).collect();
        minus_neighbours(&Profile::from_counts(&of_runs[i], &others).z, width)
            .into_iter()
            .fold(0.0, |a: f64, z| a.max(z.abs()))
    };
    let by_chance = (0..of_runs.len().min(NULL_RUNS)).map(of_run).fold(0.0, f64::max);
    let is_odd = discoveries(&alone);
    let is_odd = |p: &usize| is_odd[*p] && alone[*p].abs() > by_chance;
    let mut odd: Vec<usize> = (0..pixels.len()).filter(is_odd).collect();
    let expected = |p: usize| of_runs.iter().map(|run| run[p]).sum::<f64>() / of_runs.len() as f64;
    let hot: Vec<usize> = odd.iter().copied().filter(|p| alone[*p] > 0.0).collect();
    let hot_events = hot.iter().map(|p| pixels[*p] - expected(*p)).sum();
    let (hot, silent) = (hot.len(), odd.len() - hot.len());
    odd.sort_by(|a, b| alone[*b].abs().total_cmp(&alone[*a].abs()));
    let describe = |p: &usize| OddPixel {
        x: (p % width) as u16,
        y: (p / width) as u16,
        measured: pixels[*p],
        expected: expected(*p),
        z: alone[*p],
    };
    Maps {
        image: ResidualImage {
            width: columns,
            height: rows,
            side_px: side,
            residuals: along(columns * rows, &|p| p / width / side * columns + p % width / side),
        },
        rows: along(height, &|p| p / width),
        columns: along(width, &|p| p % width),
        times: Profile::from_counts(&strip(measured), &runs.iter().map(strip).collect::<Vec<_>>()),
        pixels: odd.iter().take(LISTED).map(describe).collect(),
        hot,
        silent,
        hot_events,
        arrows: arrows(measured, runs),
    }
}

fn minus_neighbours(z: &[f64], width: usize) -> Vec<f64> {
    let height = z.len() / width;
    let alone = |p: usize| {
        let (x, y) = (p % width, p / width);
        let (left, right) = (x.saturating_sub(RADIUS), (x + RADIUS + 1).min(width));
        let (top, bottom) = (y.saturating_sub(RADIUS), (y + RADIUS + 1).min(height));
        let rows = (top..bottom).map(|y| z[y * width + left..y * width + right].iter());
        let sum: f64 = rows.flatten().sum();
        // At the border there are fewer neighbours.
        let others = (right - left) * (bottom - top) - 1;
        z[p] - (sum - z[p]) / others.max(1) as f64
    };
    (0..z.len()).map(alone).collect()
}

impl Profile {
    /// Residuals of counts against runs of the model.
    fn from_counts<T: AsRef<[f64]>>(counts: &[f64], runs: &[T]) -> Self {
        let sum = |i: usize| runs.iter().map(|run| run.as_ref()[i]).sum::<f64>();
        let n = runs.len() as f64;
        // Roots of counts have a variance that does not depend on their mean (Anscombe).
        let deviation = |count: f64, others: f64, n: f64| {
            let expected = others / n;
            let tolerance = TOLERANCE * expected.sqrt();
            let sd = (1.0 + 1.0 / n + tolerance * tolerance).sqrt();
            2.0 * ((count + 0.375).sqrt() - (expected + 0.375).sqrt()) / sd
        };
        // Threshold mismatch scatters large counts more than small ones.
        let class = |sum: f64| (1.0 + sum / n).log2() as usize;
        let mut scatter = [(0.0, 0.0); 64];
        let mut all = (0.0, 0.0);
        // Each run against the others, as the recording against all.
        for run in runs.iter().filter(|_| n > 1.0) {
            for (i, count) in run.as_ref().iter().enumerate() {
                let sum = sum(i);
                if sum > 0.0 {
                    let square = deviation(*count, sum - count, n - 1.0).powi(2);
                    for (squares, used) in [&mut all, &mut scatter[class(sum)]] {
                        *squares += square;
                        *used += 1.0;
                    }
                }
            }
        }
        let scatter = |sum: f64| {
            let own = scatter[class(sum)];
            // Classes of few counts have the scatter of all.
            let (squares, used) = if own.1 >= MIN_CLASS * n { own } else { all };
            if used > 0.0 { f64::sqrt(squares / used).max(MIN_SCATTER) } else { 1.0 }
        };
        let z = |(i, count): (usize, &f64)| deviation(*count, sum(i), n) / scatter(sum(i));
        let z: Vec<f64> = counts.iter().enumerate().map(z).collect();
        let is_significant = discoveries(&z);
        Self { z, is_significant }
    }

    /// Number of significant residuals.
    pub fn significant(&self) -> usize {
        self.is_significant.iter().filter(|is| **is).count()
    }
}

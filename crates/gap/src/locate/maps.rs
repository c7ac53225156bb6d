//! Residuals over the image, its rows and columns, and time: what is significant in each.
//!
//! # Model
//! Counts are compared as `2 sqrt(n + 3/8)`, of variance one for independent events; what runs of
//! the model differ by among themselves, at counts of that size, scales it. One percent more or
//! fewer does not matter. Of what is called significant, one in twenty may be chance.

use serde::{Deserialize, Serialize};

use super::arrows::{Arrow, arrows};
use super::significance::discoveries;
use crate::View;

/// Most columns of a residual image.
const IMAGE_COLUMNS: usize = 96;
/// Parts of the window.
const STRIP: usize = 100;
/// Odd pixels that are listed.
const LISTED: usize = 50;
/// Runs of which the oddest pixel is looked for.
const TRIED: usize = 4;
/// Pixels of about the same count, at least, of which the scatter is taken.
const ALIKE: f64 = 100.0;
/// How far around a pixel reaches, pixels.
const AROUND: usize = 2;
/// Part of a count that does not matter.
const TOLERANCE: f64 = 0.01;
/// Least that the scatter of runs is taken for.
const LEAST_SCATTER: f64 = 0.5;

/// Residuals of a recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Maps {
    /// Over the image.
    pub image: ResidualImage,
    /// Row by row.
    pub rows: Profile,
    /// Column by column.
    pub columns: Profile,
    /// Over the window, hundredths of it.
    pub times: Profile,
    /// Pixels with too many or too few events, the oddest first; no more than fifty.
    pub pixels: Vec<OddPixel>,
    /// How many pixels have too many.
    pub hot: usize,
    /// How many have too few.
    pub silent: usize,
    /// Events that hot pixels have beyond those of the model.
    pub hot_events: f64,
    /// How far parts of the image are displaced.
    #[serde(default)]
    pub arrows: Vec<Arrow>,
}

/// Residuals over the image, several pixels together where there are many.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ResidualImage {
    /// Columns of the map.
    pub width: usize,
    /// Its rows.
    pub height: usize,
    /// Side of what is one in the map, pixels.
    pub side_px: usize,
    /// In standard deviations, positive where more was measured.
    pub residuals: Profile,
}

/// Residuals along a line.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// In standard deviations, positive where more was measured.
    pub z: Vec<f64>,
    /// Which are significant.
    pub is_significant: Vec<bool>,
}

/// A pixel that neither the model nor the pixels around it explain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OddPixel {
    /// Column.
    pub x: u16,
    /// Row.
    pub y: u16,
    /// Events measured.
    pub measured: f64,
    /// Those of the model, the mean of its runs.
    pub expected: f64,
    /// In standard deviations, less the mean of the pixels around it.
    pub z: f64,
}

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
        Profile::of(&sum(&pixels), &of_runs.iter().map(sum).collect::<Vec<_>>())
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
    let alone = stand_out(&Profile::of(&pixels, &of_runs).z, width);
    // Some models make odd pixels of their own: what a run has against the others is none.
    let of_run = |i: usize| {
        let others: Vec<&Vec<f64>> =
            of_runs.iter().enumerate().filter(|(k, _)| *k != i).map(|(_, run)| run).collect();
        stand_out(&Profile::of(&of_runs[i], &others).z, width)
            .into_iter()
            .fold(0.0, |a: f64, z| a.max(z.abs()))
    };
    let by_chance = (0..of_runs.len().min(TRIED)).map(of_run).fold(0.0, f64::max);
    let is_odd = discoveries(&alone);
    let is_odd = |p: &usize| is_odd[*p] && alone[*p].abs() > by_chance;
    let mut odd: Vec<usize> = (0..pixels.len()).filter(is_odd).collect();
    let expected = |p: usize| of_runs.iter().map(|run| run[p]).sum::<f64>() / of_runs.len() as f64;
    let hot: Vec<usize> = odd.iter().copied().filter(|p| alone[*p] > 0.0).collect();
    let hot_events = hot.iter().map(|p| pixels[*p] - expected(*p)).sum();
    let (hot, silent) = (hot.len(), odd.len() - hot.len());
    odd.sort_by(|a, b| alone[*b].abs().total_cmp(&alone[*a].abs()));
    let tell = |p: &usize| OddPixel {
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
        times: Profile::of(&strip(measured), &runs.iter().map(strip).collect::<Vec<_>>()),
        pixels: odd.iter().take(LISTED).map(tell).collect(),
        hot,
        silent,
        hot_events,
        arrows: arrows(measured, runs),
    }
}

/// Residuals of pixels less the mean of those around them.
fn stand_out(z: &[f64], width: usize) -> Vec<f64> {
    let height = z.len() / width;
    let alone = |p: usize| {
        let (x, y) = (p % width, p / width);
        let (left, right) = (x.saturating_sub(AROUND), (x + AROUND + 1).min(width));
        let (top, bottom) = (y.saturating_sub(AROUND), (y + AROUND + 1).min(height));
        let rows = (top..bottom).map(|y| z[y * width + left..y * width + right].iter());
        let sum: f64 = rows.flatten().sum();
        let others = (right - left) * (bottom - top) - 1;
        z[p] - (sum - z[p]) / others.max(1) as f64
    };
    (0..z.len()).map(alone).collect()
}

impl Profile {
    /// Residuals of counts against those of runs.
    fn of<T: AsRef<[f64]>>(counts: &[f64], runs: &[T]) -> Self {
        let sum = |i: usize| runs.iter().map(|run| run.as_ref()[i]).sum::<f64>();
        let n = runs.len() as f64;
        let deviation = |count: f64, others: f64, n: f64| {
            let expected = others / n;
            let tolerance = TOLERANCE * expected.sqrt();
            let sd = (1.0 + 1.0 / n + tolerance * tolerance).sqrt();
            2.0 * ((count + 0.375).sqrt() - (expected + 0.375).sqrt()) / sd
        };
        // Thresholds that differ from pixel to pixel scatter large counts more than small ones.
        let class = |sum: f64| (1.0 + sum / n).log2() as usize;
        let mut scatter = [(0.0, 0.0); 64];
        let mut all = (0.0, 0.0);
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
            let (squares, used) = if own.1 >= ALIKE * n { own } else { all };
            if used > 0.0 { f64::sqrt(squares / used).max(LEAST_SCATTER) } else { 1.0 }
        };
        let z = |(i, count): (usize, &f64)| deviation(*count, sum(i), n) / scatter(sum(i));
        let z: Vec<f64> = counts.iter().enumerate().map(z).collect();
        let is_significant = discoveries(&z);
        Self { z, is_significant }
    }

    /// How many are significant.
    pub fn significant(&self) -> usize {
        self.is_significant.iter().filter(|is| **is).count()
    }
}

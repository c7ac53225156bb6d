//! Events of all pixels one behind the other: groups at one stamp, rows, gaps, and a ceiling.

use super::train::{Mark, Train};

/// Bins in a window, for the ceiling.
const BINS: i64 = 10;
/// Length of the bins in which a ceiling is measured.
const CEILING_BIN_US: i64 = 1_000;
/// A lower ceiling cannot be told from chance.
pub(super) const LEAST_CEILING: usize = 50;
/// Fewest pairs of events that chance would make closer than a bus allows.
const LEAST_PAIRS: f64 = 50.0;

/// Part of neighbouring events for which something holds.
fn share(train: &Train, holds: impl Fn(&Mark, &Mark) -> bool) -> Option<f64> {
    let pairs = train.marks.windows(2);
    let n = pairs.len();
    let held = pairs.filter(|pair| holds(&pair[0], &pair[1])).count();
    (n > 0).then(|| held as f64 / n as f64)
}

/// Part of the events with the stamp of the event before.
pub(super) fn same_stamp(train: &Train) -> Option<f64> {
    share(train, |a, b| a.t_us == b.t_us)
}

/// Part of the events in the row of the event before.
pub(super) fn same_row(train: &Train) -> Option<f64> {
    let width = u32::from(train.size.width);
    share(train, |a, b| a.pixel / width == b.pixel / width)
}

/// Part of the events in the column of the event before.
pub(super) fn same_column(train: &Train) -> Option<f64> {
    let width = u32::from(train.size.width);
    share(train, |a, b| a.pixel % width == b.pixel % width)
}

/// Logarithm of the gap that a hundredth of the gaps are below.
pub(super) fn lower_gap(train: &Train) -> Option<f64> {
    gap_us(train, 0.01).map(|us| (us as f64 + 0.5).ln())
}

fn gap_us(train: &Train, part: f64) -> Option<i64> {
    let mut gaps: Vec<i64> =
        train.marks.windows(2).map(|pair| pair[1].t_us - pair[0].t_us).collect();
    let rank = (part * gaps.len() as f64) as usize;
    (rank > 0).then(|| *gaps.select_nth_unstable(rank).1)
}

/// How much counts in tenths of a window vary about a tenth of the window's, over what chance
/// makes of it, in the busiest tenth of the windows: less than one below a ceiling.
pub(super) fn unevenness(train: &Train, window_us: i64) -> Option<f64> {
    let mut windows: Vec<[f64; BINS as usize]> = Vec::new();
    let mut current = i64::MIN;
    for mark in &train.marks {
        let window = mark.t_us.div_euclid(window_us);
        if window != current {
            windows.push([0.0; BINS as usize]);
            current = window;
        }
        let bin = mark.t_us.rem_euclid(window_us) * BINS / window_us;
        if let Some(counts) = windows.last_mut() {
            counts[bin as usize] += 1.0;
        }
    }
    let sum = |counts: &[f64; BINS as usize]| counts.iter().sum::<f64>();
    // The windows at the ends are not whole.
    let last = windows.len().checked_sub(1)?;
    let inner = windows.get_mut(1..last)?;
    inner.sort_by(|a, b| sum(b).total_cmp(&sum(a)));
    let busiest = &inner[..inner.len().div_ceil(10)];
    let ratios = busiest.iter().map(|counts| {
        let mean = sum(counts) / BINS as f64;
        counts.iter().map(|count| (count - mean).powi(2)).sum::<f64>() / mean
    });
    let n = busiest.len() as f64 * (BINS - 1) as f64;
    (n > 0.0).then(|| ratios.sum::<f64>() / n)
}

/// Pairs of events closer than `gap_us` that chance would make.
fn expected_pairs(train: &Train, gap_us: f64) -> f64 {
    let window_us = 5_000;
    let windows = train.marks.chunk_by(|a, b| a.t_us / window_us == b.t_us / window_us);
    windows.map(|window| (window.len() as f64).powi(2) * gap_us / window_us as f64).sum()
}

/// Whether events are dense enough for the longest service time of a bus to show, 50 us.
pub(super) fn is_dense(train: &Train) -> bool {
    expected_pairs(train, 50.0) >= LEAST_PAIRS
}

/// Events a second that one bus seems to carry: no two events are closer than the time that one
/// takes, though many would be by chance.
pub(super) fn bus_rate_hz(train: &Train) -> Option<f64> {
    let gap_us = gap_us(train, 0.01).filter(|us| *us >= 1)?;
    let expected = expected_pairs(train, gap_us as f64);
    let gaps = || train.marks.windows(2).map(|pair| pair[1].t_us - pair[0].t_us);
    let closer = gaps().filter(|us| *us < gap_us).count() as f64;
    if expected < LEAST_PAIRS || closer > 0.1 * expected {
        return None;
    }
    // Events that queue are one service time apart, rounded to whole microseconds up or down.
    let queued: Vec<i64> = gaps().filter(|us| (gap_us..=gap_us + 1).contains(us)).collect();
    let mean_us = queued.iter().sum::<i64>() as f64 / queued.len() as f64;
    (queued.len() as f64 > 3.0 * expected / gap_us as f64).then(|| 1e6 / mean_us)
}

/// Events a second that get through at most: the busiest milliseconds all have the same count.
pub(super) fn ceiling_hz(train: &Train) -> Option<f64> {
    let counts = counts_per_bin(train);
    let top = *counts.last()?;
    let near = counts.iter().filter(|count| 1.01 * **count as f64 >= top as f64).count();
    let next = counts.iter().filter(|count| 1.05 * **count as f64 >= top as f64).count();
    // Poisson counts thin out towards their maximum; a ceiling holds most of those near it.
    let is_ceiling = top >= LEAST_CEILING && near >= 10 && 4 * near >= 3 * next;
    is_ceiling.then(|| top as f64 * 1e6 / CEILING_BIN_US as f64)
}

/// Events of the busiest millisecond.
pub(super) fn busiest(train: &Train) -> usize {
    counts_per_bin(train).last().copied().unwrap_or(0)
}

/// Counts of milliseconds with events, the smallest first.
fn counts_per_bin(train: &Train) -> Vec<usize> {
    // The end of a window belongs to it.
    let bin = |mark: &Mark| (mark.t_us - 1).div_euclid(CEILING_BIN_US);
    let bins = train.marks.chunk_by(|a, b| bin(a) == bin(b));
    let mut counts: Vec<usize> = bins.map(<[Mark]>::len).collect();
    counts.sort_unstable();
    counts
}

//! Succession of events of all pixels: shared stamps and rows, intervals of a bus, and a rate
//! limit.

use super::train::{Mark, Train};

/// Bins per window of the unevenness statistic.
const BINS: i64 = 10;
/// Length of the bins in which a rate limit is measured.
const CEILING_BIN_US: i64 = 1_000;
/// Minimum events per bin of a detectable rate limit.
pub(super) const MIN_CEILING: usize = 50;
/// Minimum expected pairs of Poisson events closer than a bus allows.
const MIN_PAIRS: f64 = 50.0;

/// Fraction of successive events for which a condition holds.
pub(super) fn fraction(train: &Train, holds: impl Fn(&Mark, &Mark) -> bool) -> Option<f64> {
    let pairs = train.marks.windows(2);
    let n = pairs.len();
    let count = pairs.filter(|pair| holds(&pair[0], &pair[1])).count();
    (n > 0).then(|| count as f64 / n as f64)
}

/// Logarithm of the 1 % quantile of the intervals between events of the sensor.
pub(super) fn lower_gap(train: &Train) -> Option<f64> {
    gap_us(train, 0.01).map(|us| (us as f64 + 0.5).ln())
}

fn gap_us(train: &Train, part: f64) -> Option<i64> {
    let mut gaps: Vec<i64> =
        train.marks.windows(2).map(|pair| pair[1].t_us - pair[0].t_us).collect();
    let rank = (part * gaps.len() as f64) as usize;
    (rank > 0).then(|| *gaps.select_nth_unstable(rank).1)
}

/// Dispersion (variance over mean) of counts in tenths of a window, in the busiest tenth of all
/// windows: one for Poisson events, less under a rate limit.
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
    // The first and the last window are incomplete.
    let last = windows.len().checked_sub(1)?;
    let inner = windows.get_mut(1..last)?;
    inner.sort_by(|a, b| sum(b).total_cmp(&sum(a)));
    let busiest = &inner[..inner.len().div_ceil(10)];
    let ratios = busiest.iter().map(|counts| {
        let mean = sum(counts) / BINS as f64;
        counts.iter().map(|count| (count - mean).powi(2)).sum::<f64>() / mean
    });
    // Each window has a mean of its own, which takes a degree of freedom.
    let n = busiest.len() as f64 * (BINS - 1) as f64;
    (n > 0.0).then(|| ratios.sum::<f64>() / n)
}

/// Expected pairs of Poisson events closer than `gap_us`.
fn expected_pairs(train: &Train, gap_us: f64) -> f64 {
    let window_us = 5_000;
    let windows = train.marks.chunk_by(|a, b| a.t_us / window_us == b.t_us / window_us);
    windows.map(|window| (window.len() as f64).powi(2) * gap_us / window_us as f64).sum()
}

/// Whether events are dense enough to show the longest service time of a bus, 50 us.
pub(super) fn is_dense(train: &Train) -> bool {
    expected_pairs(train, 50.0) >= MIN_PAIRS
}

/// Rate of a bus, events per second: no two events are closer than its service time, although many
/// would be by chance.
pub(super) fn bus_rate_hz(train: &Train) -> Option<f64> {
    let gap_us = gap_us(train, 0.01).filter(|us| *us >= 1)?;
    let expected = expected_pairs(train, gap_us as f64);
    let gaps = || train.marks.windows(2).map(|pair| pair[1].t_us - pair[0].t_us);
    let closer = gaps().filter(|us| *us < gap_us).count() as f64;
    if expected < MIN_PAIRS || closer > 0.1 * expected {
        return None;
    }
    // Queued events are one service time apart, rounded to whole microseconds.
    let queued: Vec<i64> = gaps().filter(|us| (gap_us..=gap_us + 1).contains(us)).collect();
    let mean_us = queued.iter().sum::<i64>() as f64 / queued.len() as f64;
    (queued.len() as f64 > 3.0 * expected / gap_us as f64).then(|| 1e6 / mean_us)
}

/// Rate limit, events per second: the busiest milliseconds all have the same count.
pub(super) fn ceiling_hz(train: &Train) -> Option<f64> {
    let counts = counts_per_bin(train);
    let top = *counts.last()?;
    let near = counts.iter().filter(|count| 1.01 * **count as f64 >= top as f64).count();
    let next = counts.iter().filter(|count| 1.05 * **count as f64 >= top as f64).count();
    // Poisson counts thin out towards their maximum; a limit gathers counts at it.
    let is_ceiling = top >= MIN_CEILING && near >= 10 && 4 * near >= 3 * next;
    is_ceiling.then(|| top as f64 * 1e6 / CEILING_BIN_US as f64)
}

pub(super) fn busiest(train: &Train) -> usize {
    counts_per_bin(train).last().copied().unwrap_or(0)
}

/// Counts of all milliseconds with events, in ascending order.
fn counts_per_bin(train: &Train) -> Vec<usize> {
    // The end of a window belongs to it.
    let bin = |mark: &Mark| (mark.t_us - 1).div_euclid(CEILING_BIN_US);
    let bins = train.marks.chunk_by(|a, b| bin(a) == bin(b));
    let mut counts: Vec<usize> = bins.map(<[Mark]>::len).collect();
    counts.sort_unstable();
    counts
}

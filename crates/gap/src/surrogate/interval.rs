//! Inter-event intervals of pixels: their lower edge, and the succession of polarities.

use super::train::Train;

/// Quantile of the short intervals that is the lower edge.
const EDGE: f64 = 0.02;
/// Largest fraction of the intervals around an edge that lie below it.
const BELOW: f64 = 0.05;
/// Minimum intervals above an edge.
const MIN_ABOVE: usize = 30;
/// Largest logarithm of the ratio of two edges that agree.
const SAME_EDGE: f64 = 0.15;
/// Range of edges: 10 us to 50 ms, in steps of 2 %.
const EDGES_US: (f64, f64) = (10.0, 5e4);

/// An interval in microseconds, and whether the polarities of its ends differ.
pub(super) type Interval = (i64, bool);

/// Intervals shorter than `max_us`, in order of their ends, with their pixels.
pub(super) fn intervals(train: &Train, max_us: i64) -> Vec<(u32, Interval)> {
    let mut last = vec![None; train.size.pixels()];
    let mut intervals = Vec::new();
    for mark in &train.marks {
        if let Some((t_us, is_on)) = last[mark.pixel as usize].replace((mark.t_us, mark.is_on)) {
            let interval_us: i64 = mark.t_us - t_us;
            // Longer ones are not redrawn by windows of this length: all surrogates have the same.
            if interval_us < max_us {
                intervals.push((mark.pixel, (interval_us, is_on != mark.is_on)));
            }
        }
    }
    intervals
}

/// Logarithm of the 2 % quantile of the intervals shorter than a window, which is large under a
/// refractory period. None with fewer than fifty intervals.
pub(super) fn lower_edge(intervals: &[(u32, Interval)]) -> Option<f64> {
    let mut lengths: Vec<i64> = intervals.iter().map(|(_, (us, _))| *us).collect();
    let rank = (EDGE * lengths.len() as f64) as usize;
    if rank == 0 {
        return None;
    }
    let (_, edge, _) = lengths.select_nth_unstable(rank);
    // Intervals of 0 us occur where stamps are coarse.
    Some((*edge as f64 + 0.5).ln())
}

/// Fraction of the intervals shorter than a window that are between events of opposite polarity.
pub(super) fn alternation(intervals: &[(u32, Interval)]) -> Option<f64> {
    let changes = intervals.iter().filter(|(_, (_, changes))| *changes).count();
    (!intervals.is_empty()).then(|| changes as f64 / intervals.len() as f64)
}

/// Refractory period of all pixels, microseconds: an edge with hardly any intervals below and many
/// above. Light makes edges as well; a refractory period is the same in the busier and in the
/// quieter half of the pixels, and between events of the same and of opposite polarity.
pub(super) fn refractory_us(train: &Train) -> Option<f64> {
    // Twice the longest edge, so that there are intervals above any.
    let all = intervals(train, 2 * EDGES_US.1 as i64);
    let mut counts = vec![0u32; train.size.pixels()];
    for mark in &train.marks {
        counts[mark.pixel as usize] += 1;
    }
    let mut by_interval: Vec<u32> = all.iter().map(|(pixel, _)| counts[*pixel as usize]).collect();
    by_interval.sort_unstable();
    let middle = *by_interval.get(by_interval.len() / 2)?;
    let lengths = |belongs: &dyn Fn(u32, bool) -> bool| {
        let own = all.iter().filter(|(pixel, (_, changes))| belongs(*pixel, *changes));
        let mut lengths: Vec<i64> = own.map(|(_, (us, _))| *us).collect();
        lengths.sort_unstable();
        lengths
    };
    let whole_us = edge_us(&lengths(&|_, _| true))?;
    let agrees = |lengths: &[i64]| {
        edge_us(lengths).is_some_and(|us| (us / whole_us).ln().abs() <= SAME_EDGE)
    };
    for is_busy in [false, true] {
        let half = lengths(&|pixel, _| (counts[pixel as usize] > middle) == is_busy);
        // Pixels with equal counts are all in one half.
        if half.len() * 5 > all.len() && !agrees(&half) {
            return None;
        }
    }
    let kinds = [false, true].map(|changes| lengths(&|_, pair_changes| pair_changes == changes));
    kinds.iter().all(|kind| agrees(kind)).then_some(whole_us)
}

/// The sharpest edge of sorted lengths: the largest likelihood ratio of a density with a step at
/// the edge against a constant one, from half of the edge to 1.2 times it.
fn edge_us(lengths: &[i64]) -> Option<f64> {
    let below = |us: f64| lengths.partition_point(|length| (*length as f64) < us);
    let mut best = (0.0, None);
    let mut edge_us = EDGES_US.0;
    while edge_us < EDGES_US.1 {
        let (half, at, near, far) =
            (below(0.5 * edge_us), below(edge_us), below(1.2 * edge_us), below(1.44 * edge_us));
        let (under, above, beyond) = ((at - half) as f64, (near - at) as f64, (far - near) as f64);
        // Hardly anything below, many just above, and no dip behind: a mode of the intervals is no
        // edge.
        let is_edge = near - at >= MIN_ABOVE
            && at as f64 * 0.2 <= BELOW * above
            && under / 0.5 <= BELOW * above / 0.2
            && above / 0.2 >= 0.8 * beyond / 0.24;
        if is_edge {
            let whole = (under + above) / 0.7;
            let part =
                |n: f64, length: f64| if n > 0.0 { n * (n / length / whole).ln() } else { 0.0 };
            let ratio = part(under, 0.5) + part(above, 0.2);
            if ratio > best.0 {
                // The shortest interval itself, which the grid of edges is too coarse for.
                let first = lengths[below(0.97 * edge_us)];
                best = (ratio, Some(first as f64));
            }
        }
        edge_us *= 1.02;
    }
    best.1
}

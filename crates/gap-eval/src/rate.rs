//! Event rate of all pixels over time.

use evpose_core::EventStream;

use crate::relative_difference;

/// Time step of the cross-correlation.
const LAG_STEP_US: i64 = 200;
/// Maximum lag, in steps: 60 ms.
const MAX_STEPS: i64 = 300;
/// Half width, in steps, over which rates are smoothed before the cross-correlation.
const SMOOTH_STEPS: usize = 10;
/// Bin length in which rates are compared.
const RATE_STEP_US: i64 = 5_000;

/// Absolute lag between two recordings, milliseconds, at the maximum of their cross-correlation.
pub(crate) fn lag_ms(a: &EventStream, b: &EventStream) -> f64 {
    let (a, b) = binned(a, b, LAG_STEP_US);
    let (a, b) = (smoothed(&a), smoothed(&b));
    let overlap = |lag: i64| -> f64 {
        let from = |rates: &'_ [f64], step: i64| rates.len().min(step.max(0) as usize);
        a[from(&a, -lag)..].iter().zip(&b[from(&b, lag)..]).map(|(a, b)| a * b).sum()
    };
    // From 0 outwards: of equal overlaps, the smaller lag wins.
    let mut best = (overlap(0), 0i64);
    for steps in 1..=MAX_STEPS {
        for lag in [-steps, steps] {
            let value = overlap(lag);
            if value > best.0 {
                best = (value, lag);
            }
        }
    }
    (best.1 * LAG_STEP_US).abs() as f64 * 1e-3
}

/// Relative difference of the counts in bins of 5 ms.
pub(crate) fn distance(a: &EventStream, b: &EventStream) -> f64 {
    let (a, b) = binned(a, b, RATE_STEP_US);
    relative_difference(&a, &b)
}

/// Counts of both recordings in common bins, from the first event of the two to the last.
fn binned(a: &EventStream, b: &EventStream, step_us: i64) -> (Vec<f64>, Vec<f64>) {
    let step = |events: &EventStream, i: usize| events.t().get(i).map(|t| t.0.div_euclid(step_us));
    let first = step(a, 0).into_iter().chain(step(b, 0)).min().unwrap_or(0);
    let ends = [a, b].map(|events| step(events, events.len().wrapping_sub(1)));
    let last = ends.into_iter().flatten().max().unwrap_or(first);
    let count = |events: &EventStream| {
        let mut counts = vec![0.0; (last - first + 1) as usize];
        for t in events.t() {
            counts[(t.0.div_euclid(step_us) - first) as usize] += 1.0;
        }
        counts
    };
    (count(a), count(b))
}

/// Moving average, minus the mean of all.
pub(crate) fn smoothed(counts: &[f64]) -> Vec<f64> {
    let mean = counts.iter().sum::<f64>() / counts.len() as f64;
    let around = |k: usize| {
        let part =
            &counts[k.saturating_sub(SMOOTH_STEPS)..(k + SMOOTH_STEPS + 1).min(counts.len())];
        part.iter().sum::<f64>() / part.len() as f64 - mean
    };
    (0..counts.len()).map(around).collect()
}

//! Features of a patch of events: counts, alternation of polarity, intervals, order of readout, and
//! positions in the patch.

use std::f64::consts::TAU;

use evpose_core::stats::quantile::nearest_index;

/// Side of a patch, pixels.
pub(super) const SIDE_PX: usize = 32;
/// Length of a patch, microseconds.
pub(super) const LENGTH_US: i64 = 20_000;
/// Number of features.
pub(super) const COUNT: usize = 43;
pub(super) type Features = [f64; COUNT];

/// Periods of clocks and readouts whose phase locking is measured, microseconds.
const PERIODS_US: [i64; 4] = [10, 50, 100, 1_000];
/// Upper limits of the intervals that are counted, microseconds.
const SHORT_US: [i64; 2] = [500, 2_000];
/// Lengths of the time bins of rates, microseconds.
const BINS_US: [i64; 2] = [1_000, 5_000];
/// Side of the blocks whose dispersion is measured, pixels.
const CROWD_PX: usize = 4;

#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Local {
    /// Time since the start of the patch.
    pub(super) t_us: i64,
    pub(super) stamp_us: i64,
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) is_on: bool,
}

/// Computes the features of a patch, whose events are in order of time.
pub(super) fn patch_features(events: &[Local]) -> Features {
    let mut features = Vec::with_capacity(COUNT);
    let pixels = Pixels::from_events(events);
    features.extend(pixels.counts(events.len()));
    features.extend(pairs_of_pixels(events));
    features.extend(order(events));
    features.extend(PERIODS_US.map(|period_us| coherence(events, period_us)));
    features.extend(times(events));
    features.extend(pixels.places());
    features.extend(spread(events));
    assert_eq!(features.len(), COUNT);
    std::array::from_fn(|i| features.get(i).copied().unwrap_or(0.0))
}

fn share(part: usize, all: usize) -> f64 {
    part as f64 / all.max(1) as f64
}

/// Events of each pixel: OFF and ON.
struct Pixels {
    counts: Vec<[u32; 2]>,
}

impl Pixels {
    fn from_events(events: &[Local]) -> Self {
        let mut counts = vec![[0; 2]; SIDE_PX * SIDE_PX];
        for event in events {
            counts[event.y * SIDE_PX + event.x][usize::from(event.is_on)] += 1;
        }
        Self { counts }
    }

    /// Event counts and their distribution over pixels: nine features.
    fn counts(&self, events: usize) -> [f64; 9] {
        // Logarithms of counts: patches differ by orders of magnitude, and the classifier is
        // linear.
        let on = self.counts.iter().map(|count| count[1] as usize).sum::<usize>();
        let off = events - on;
        let sums = || self.counts.iter().map(|[off, on]| off + on).filter(|sum| *sum > 0);
        let active = sums().count();
        let both = self.counts.iter().filter(|[off, on]| *off > 0 && *on > 0).count();
        let max = sums().max().unwrap_or(0);
        [
            (on as f64).ln_1p(),
            (off as f64).ln_1p(),
            ((on as f64 + 0.5) / (off as f64 + 0.5)).ln(),
            (active as f64).ln_1p(),
            share(events, active),
            f64::from(max).ln_1p(),
            share(sums().filter(|sum| *sum >= 2).count(), active),
            share(sums().filter(|sum| *sum >= 4).count(), active),
            share(both, active),
        ]
    }

    /// Dispersion over rows, columns and blocks, and active pixels without an active neighbour:
    /// four features.
    fn places(&self) -> [f64; 4] {
        let blocks = SIDE_PX / CROWD_PX;
        let dispersion_over = |bins: usize, bin: &dyn Fn(usize, usize) -> usize| {
            let mut sums = vec![0.0; bins];
            for (p, [off, on]) in self.counts.iter().enumerate() {
                sums[bin(p % SIDE_PX, p / SIDE_PX)] += f64::from(off + on);
            }
            dispersion(&sums)
        };
        let is_active = |x: usize, y: usize| self.counts[y * SIDE_PX + x] != [0, 0];
        let (mut active, mut alone) = (0, 0);
        for (x, y) in (0..SIDE_PX * SIDE_PX).map(|p| (p % SIDE_PX, p / SIDE_PX)) {
            if is_active(x, y) {
                let columns = x.saturating_sub(1)..=(x + 1).min(SIDE_PX - 1);
                let rows = || y.saturating_sub(1)..=(y + 1).min(SIDE_PX - 1);
                let around =
                    columns.map(|x| rows().filter(|y| is_active(x, *y)).count()).sum::<usize>();
                active += 1;
                // The pixel itself is one of those around it.
                alone += usize::from(around == 1);
            }
        }
        [
            dispersion_over(SIDE_PX, &|_, y| y),
            dispersion_over(SIDE_PX, &|x, _| x),
            dispersion_over(blocks * blocks, &|x, y| y / CROWD_PX * blocks + x / CROWD_PX),
            share(alone, active),
        ]
    }
}

/// Logarithm of variance over mean (the Fano factor), shrunk for small counts.
fn dispersion(counts: &[f64]) -> f64 {
    let n = counts.len() as f64;
    let mean = counts.iter().sum::<f64>() / n;
    let variance = counts.iter().map(|count| (count - mean).powi(2)).sum::<f64>() / n;
    ((variance + 0.05) / (mean + 0.05)).ln()
}

/// Three quantiles of `log10(1 + interval)`; the length of a patch where there is no interval.
fn quantiles(intervals_us: &mut [i64]) -> [f64; 3] {
    intervals_us.sort_unstable();
    [0.1, 0.5, 0.9].map(|share| {
        let interval = intervals_us.get(nearest_index(intervals_us.len(), share)).copied();
        (1.0 + interval.unwrap_or(LENGTH_US) as f64).log10()
    })
}

/// Successive events of one pixel: intervals, polarities, alternation; ten features.
fn pairs_of_pixels(events: &[Local]) -> [f64; 10] {
    let mut last: Vec<Option<(i64, bool)>> = vec![None; SIDE_PX * SIDE_PX];
    let mut intervals = Vec::new();
    let mut kinds = [0; 4];
    for event in events {
        let now = (event.t_us, event.is_on);
        if let Some((t_us, was_on)) = last[event.y * SIDE_PX + event.x].replace(now) {
            intervals.push(event.t_us - t_us);
            kinds[2 * usize::from(was_on) + usize::from(event.is_on)] += 1;
        }
    }
    let short = SHORT_US.map(|limit| intervals.iter().filter(|us| **us < limit).count());
    let [low, middle, high] = quantiles(&mut intervals);
    let all = events.len();
    // Of all events, not of pairs: how often pixels repeat themselves shows as well.
    let [off_off, off_on, on_off, on_on] = kinds.map(|kind| share(kind, all));
    let alternation = share(kinds[1] + kinds[2], intervals.len());
    let [shortest, short] = short.map(|count| share(count, all));
    [low, middle, high, shortest, short, off_off, off_on, on_off, on_on, alternation]
}

/// Successive events of the patch: distances in time and place; eight features.
fn order(events: &[Local]) -> [f64; 8] {
    let pairs = || events.windows(2).map(|pair| (&pair[0], &pair[1]));
    let mut intervals: Vec<i64> = pairs().map(|(a, b)| b.t_us - a.t_us).collect();
    let [low, middle, high] = quantiles(&mut intervals);
    let share_of = |is: &dyn Fn(&Local, &Local) -> bool| {
        share(pairs().filter(|(a, b)| is(a, b)).count(), intervals.len())
    };
    [
        low,
        middle,
        high,
        share_of(&|a, b| a.t_us == b.t_us),
        share_of(&|a, b| a.y == b.y),
        share_of(&|a, b| a.x == b.x),
        share_of(&|a, b| a.x.abs_diff(b.x) <= 1 && a.y.abs_diff(b.y) <= 1),
        share_of(&|a, b| a.is_on == b.is_on),
    ]
}

/// Phase locking of time stamps to a period: zero on average for uniform phases, one for one phase.
fn coherence(events: &[Local], period_us: i64) -> f64 {
    let n = events.len() as f64;
    let (mut re, mut im) = (0.0, 0.0);
    for event in events {
        let phase = event.stamp_us.rem_euclid(period_us) as f64 / period_us as f64 * TAU;
        re += phase.cos();
        im += phase.sin();
    }
    // Less what random phases have on average, so that its mean does not depend on the count.
    if n > 1.0 { ((re * re + im * im) / n - 1.0) / (n - 1.0) } else { 0.0 }
}

/// Distribution of events over the patch's time: five features.
fn times(events: &[Local]) -> [f64; 5] {
    let counts = |bin_us: i64| {
        let mut counts = vec![0.0; (LENGTH_US / bin_us) as usize];
        for event in events {
            counts[(event.t_us / bin_us) as usize] += 1.0;
        }
        counts
    };
    let [fine, coarse] = BINS_US.map(counts);
    let quarter = |i: usize| coarse[i] / events.len().max(1) as f64;
    // The fourth quarter is what the others leave of one.
    [quarter(0), quarter(1), quarter(2), dispersion(&fine), dispersion(&coarse)]
}

/// Standard deviations in x and y, pixels, and the correlation of polarity with time: three
/// features.
fn spread(events: &[Local]) -> [f64; 3] {
    let n = events.len().max(1) as f64;
    let moments = |value: &dyn Fn(&Local) -> f64| {
        let mean = events.iter().map(value).sum::<f64>() / n;
        let variance = events.iter().map(|event| (value(event) - mean).powi(2)).sum::<f64>() / n;
        (mean, variance.sqrt())
    };
    let on = |event: &Local| f64::from(u8::from(event.is_on));
    let t = |event: &Local| event.t_us as f64;
    let (x, y) = (moments(&|event| event.x as f64), moments(&|event| event.y as f64));
    let ((on_mean, on_sd), (t_mean, t_sd)) = (moments(&on), moments(&t));
    let product: f64 = events.iter().map(|e| (on(e) - on_mean) * (t(e) - t_mean)).sum::<f64>() / n;
    // Events of one polarity, or of one time, have no correlation.
    let correlation = if on_sd * t_sd > 1e-9 { product / (on_sd * t_sd) } else { 0.0 };
    [x.1, y.1, correlation]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(t_us: i64, x: usize, y: usize, is_on: bool) -> Local {
        Local { t_us, stamp_us: t_us, x, y, is_on }
    }

    #[test]
    fn a_patch_without_events_has_finite_features() {
        let one = patch_features(&[event(3, 0, 0, true)]);
        assert!(patch_features(&[]).iter().chain(&one).all(|x| x.is_finite()));
    }

    #[test]
    fn pairs_of_a_pixel_are_counted_by_polarity() {
        let events = [event(0, 1, 1, true), event(10, 2, 1, true), event(999, 1, 1, false)];
        let [low, .., off_on, on_off, _, alternation] = pairs_of_pixels(&events);
        assert!((low - 3.0).abs() < 1e-12);
        assert_eq!((off_on, on_off, alternation), (0.0, 1.0 / 3.0, 1.0));
    }

    #[test]
    fn stamps_of_one_phase_are_coherent_and_others_are_not() {
        let fixed: Vec<_> = (0..40).map(|i| event(100 * i + 7, 0, 0, true)).collect();
        assert!((coherence(&fixed, 100) - 1.0).abs() < 1e-9);
        let even: Vec<_> = (0..40).map(|i| event(105 * i, 0, 0, true)).collect();
        assert!(coherence(&even, 100).abs() < 0.03);
    }
}

//! Phase locking of time stamps to a clock, and of the clock to rows or columns.
//!
//! # Model
//! A readout that scans row `y` of `H` at `t = k T + T y / H` makes `exp(2 pi i (t / T - y / H))`
//! the same for all events. The mean over events is a Fourier transform of events with weights
//! `exp(-+2 pi i y / H)`, which gives all periods `T` and both directions at once. Power is summed
//! over blocks of a third of a second, so that a clock may drift. Subtracted are the power at
//! neighbouring frequencies, so that motion, which has no spectral lines, does not show, and the
//! expected maximum by chance.

use std::f64::consts::TAU;

use evpose_core::EventStream;

use crate::fourier::{self, Fourier};
use crate::probe::MAX_BINS;
use crate::{EventFeatures, View};

/// Length of a bin; the shortest measurable period is two bins.
const BIN_US: i64 = 10;
const BLOCK_US: i64 = BIN_US * MAX_BINS as i64;
/// Maximum number of blocks, spread evenly over the window.
const MAX_BLOCKS: i64 = 5;
/// Neighbouring frequencies on either side, and those of them that a line leaks into.
const AROUND: usize = 16;
const TOUCHED: usize = 2;
/// Periods from 20 us to 20 ms, a decade each.
pub(super) const BANDS: usize = 3;
/// Coordinates that the clock may be locked to.
pub(super) const AXES: [&str; 3] = ["no coordinate", "the column", "the row"];

/// Frequencies of a band, in cycles per block.
fn band(index: usize) -> std::ops::Range<usize> {
    let longest_us = 20.0 * 10_f64.powi(index as i32 + 1);
    let cycles = |period_us: f64| (BLOCK_US as f64 / period_us) as usize;
    let highest = cycles(0.1 * longest_us).min(MAX_BINS / 2 - 1);
    cycles(longest_us).max(AROUND)..highest
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    /// Microseconds.
    pub(super) t_us: i64,
    pub(super) x: u16,
    pub(super) y: u16,
}

impl Spot {
    pub(super) fn from_view(view: &View<'_>) -> Vec<Self> {
        let width = u32::from(view.size().width);
        let spot = |event: &EventFeatures| {
            let (x, y) = ((event.pixel % width) as u16, (event.pixel / width) as u16);
            Self { t_us: event.t_us, x, y }
        };
        view.events().iter().map(spot).collect()
    }
}

/// Resultant lengths, axis by axis and band by band; one where all events are locked.
pub(super) fn resultants(view: &View<'_>, spots: &[Spot]) -> [f64; AXES.len() * BANDS] {
    let size = view.size();
    // A scan reads line i at phase i / n: turned back by it, its events have one phase.
    let phases = |n: u16| -> Vec<(f32, f32)> {
        let angles = (0..n).map(|i| -TAU * f64::from(i) / f64::from(n));
        angles.map(|a| (a.cos() as f32, a.sin() as f32)).collect()
    };
    let (columns, rows) = (phases(size.width), phases(size.height));
    let mut signals = [(); AXES.len()].map(|()| Fourier::zeros(MAX_BINS));
    let mut powers = [(); AXES.len()].map(|()| vec![0.0_f32; MAX_BINS]);
    // Sum over blocks of the square of the number of events.
    let mut pairs = 0.0_f64;
    for start_us in block_starts(view) {
        let from = spots.partition_point(|spot| spot.t_us < start_us);
        let to = spots.partition_point(|spot| spot.t_us < start_us + BLOCK_US);
        let events = &spots[from..to];
        if events.is_empty() {
            continue;
        }
        pairs += (events.len() as f64).powi(2);
        signals.iter_mut().for_each(Fourier::clear);
        let [alone, by_column, by_row] = &mut signals;
        for event in events {
            let bin = ((event.t_us - start_us) / BIN_US) as usize;
            alone.re[bin] += 1.0;
            let (re, im) = columns[usize::from(event.x)];
            by_column.re[bin] += re;
            by_column.im[bin] += im;
            let (re, im) = rows[usize::from(event.y)];
            by_row.re[bin] += re;
            by_row.im[bin] += im;
        }
        for (signal, power) in signals.iter_mut().zip(&mut powers) {
            signal.transform();
            for (power, (re, im)) in power.iter_mut().zip(signal.re.iter().zip(&signal.im)) {
                *power += re * re + im * im;
            }
        }
    }
    let mut lengths = [0.0; AXES.len() * BANDS];
    if pairs == 0.0 {
        return lengths;
    }
    let chance = pairs.sqrt();
    for (axis, power) in powers.iter().enumerate() {
        // Without lines there is no direction.
        for backward in [false, true].into_iter().take(if axis == 0 { 1 } else { 2 }) {
            let excess = excess(power, backward);
            for b in 0..BANDS {
                let band = band(b);
                // By chance, the largest of n excesses is about ln n standard deviations.
                let highest = chance * (band.len() as f64).ln();
                let best = excess[band].iter().fold(0.0, |best: f64, e| best.max(*e));
                let square = ((best - highest) / pairs).clamp(0.0, 1.0);
                let length = &mut lengths[axis * BANDS + b];
                *length = square.sqrt().max(*length);
            }
        }
    }
    lengths
}

/// A scanned readout, as the time stamps show it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scan {
    /// Period of the scan, microseconds.
    pub(crate) period_us: f64,
    /// Whether it scans rows rather than columns.
    pub(crate) is_by_row: bool,
    /// Whether it scans from the last line to the first.
    pub(crate) is_backward: bool,
    /// Resultant length of time stamps; one where all are locked.
    pub(crate) locked: f64,
}

/// The readout that a recording shows most of, if events are enough to say.
pub(crate) fn scan_of(events: &EventStream) -> Option<Scan> {
    let size = events.sensor();
    let from = events.t().partition_point(|t| t.0 < 0);
    let mut spots: Vec<Spot> =
        events.iter().skip(from).map(|e| Spot { t_us: e.t.0, x: e.x, y: e.y }).collect();
    // A block at least, which the transform needs.
    let count = MAX_SPOTS.max(spots.partition_point(|spot| spot.t_us < BLOCK_US));
    spots.truncate(count.min(spots.partition_point(|spot| spot.t_us < MAX_LENGTH_US)));
    let length_us = spots.last()?.t_us as f64;
    let mut best: Option<Scan> = None;
    for is_by_row in [true, false] {
        let lines = if is_by_row { size.height } else { size.width };
        let phase = |spot: &Spot| -> f64 {
            f64::from(if is_by_row { spot.y } else { spot.x }) / f64::from(lines)
        };
        let mut signal = Fourier::zeros(MAX_BINS);
        for spot in spots.iter().take_while(|spot| spot.t_us < BLOCK_US) {
            let bin = (spot.t_us / BIN_US) as usize;
            let (sin, cos) = (-TAU * phase(spot)).sin_cos();
            signal.re[bin] += cos as f32;
            signal.im[bin] += sin as f32;
        }
        signal.transform();
        let power: Vec<f32> =
            signal.re.iter().zip(&signal.im).map(|(re, im)| re * re + im * im).collect();
        for is_backward in [false, true] {
            // The transform turns against time.
            let excess = excess(&power, !is_backward);
            let bands = band(BANDS - 1).start..band(0).end;
            let most = bands.clone().map(|k| excess[k]).fold(0.0, f64::max);
            // The lowest that is nearly the strongest: higher ones are its multiples.
            let coarse = bands.clone().find(|k| {
                excess[*k] > AS_LOCKED * most && excess[*k] >= excess[k + 1].max(excess[k - 1])
            });
            let Some(coarse) = coarse else { continue };
            // Turns per microsecond, from coarse steps to what a turn over the recording shows.
            let mut turns = (coarse as f64 + 0.5) / BLOCK_US as f64;
            let resultant = |turns: f64| -> f64 {
                let (x, y) = spots.iter().fold((0.0, 0.0), |(x, y), spot| {
                    let line = if is_backward { -phase(spot) } else { phase(spot) };
                    let (sin, cos) = (TAU * (spot.t_us as f64 * turns - line)).sin_cos();
                    (x + cos, y + sin)
                });
                (x * x + y * y).sqrt() / spots.len() as f64
            };
            let mut locked = resultant(turns);
            for (reach, step) in [(1.2 / BLOCK_US as f64, 0.2), (0.3 / length_us, 0.02)] {
                let step = step / length_us;
                let around = (reach / step).ceil() as i32;
                let middle = turns;
                for i in -around..=around {
                    let tried = middle + step * f64::from(i);
                    let found = resultant(tried);
                    if found > locked {
                        (turns, locked) = (tried, found);
                    }
                }
            }
            let half = 0.5 / f64::from(lines);
            let off = |turns: f64, spot: &Spot| {
                let line = if is_backward { -phase(spot) } else { phase(spot) };
                let off = spot.t_us as f64 * turns - line - half;
                off - off.round()
            };
            // Twice, since phases wrap elsewhere after the first correction.
            for _ in 0..2 {
                turns += drift(spots.iter().map(|spot| (spot.t_us as f64, off(turns, spot))));
            }
            let found =
                Scan { period_us: 1.0 / turns, is_by_row, is_backward, locked: resultant(turns) };
            let is_better = |best: Scan| {
                // Stamps of lines that are visited at whole counts fit shorter periods as well.
                let share =
                    if found.period_us > best.period_us { AS_LOCKED } else { 1.0 / AS_LOCKED };
                found.locked > share * best.locked
            };
            if best.is_none_or(is_better) {
                best = Some(found);
            }
        }
    }
    best
}

/// Correction of a clock's frequency, turns per microsecond, from the phases of events (in turns,
/// at times in microseconds): the slope of a line through those near zero.
fn drift(phases: impl Iterator<Item = (f64, f64)>) -> f64 {
    // Phases half a turn away may have wrapped, which would tilt the line.
    let near = phases.filter(|(_, turns)| turns.abs() < NEAR_TURNS);
    let sums = near.fold([0.0; 5], |[n, t, p, tt, tp], (at, turns)| {
        [n + 1.0, t + at, p + turns, tt + at * at, tp + at * turns]
    });
    let [n, t, p, tt, tp] = sums;
    let spread = n * tt - t * t;
    if spread > 0.0 { (t * p - n * tp) / spread } else { 0.0 }
}

/// A longer period is preferred from this fraction of the best one's locking on.
const AS_LOCKED: f64 = 0.8;
/// Largest phase, turns, that belongs to a clock.
const NEAR_TURNS: f64 = 0.08;

/// Events, and time in microseconds, that the period is estimated from: the steps of the search get
/// finer, and so more, the longer it is.
const MAX_SPOTS: usize = 40_000;
const MAX_LENGTH_US: i64 = 4_000_000;

fn block_starts(view: &View<'_>) -> impl Iterator<Item = i64> {
    let (start_us, length_us) = (view.window.start.0, view.window.length().0);
    let blocks = (length_us / BLOCK_US).clamp(1, MAX_BLOCKS);
    let room_us = (length_us - BLOCK_US).max(0);
    (0..blocks).map(move |b| start_us + room_us * b / (blocks - 1).max(1))
}

/// Excess of the power at two adjacent frequencies, between which a line may lie, over the mean
/// power around them.
fn excess(power: &[f32], backward: bool) -> Vec<f64> {
    let half = power.len() / 2;
    let at = |k: usize| {
        let k = if backward { power.len() - k } else { k };
        f64::from(power[fourier::bit_reversed(k, power.len())])
    };
    let mut sums = Vec::with_capacity(half + 1);
    sums.push(0.0);
    // The zero frequency is the mean rate, not a line.
    let ordered: Vec<f64> = (0..half).map(|k| if k == 0 { 0.0 } else { at(k) }).collect();
    // Running sums, so that each mean is a difference.
    for power in &ordered {
        sums.push(sums[sums.len() - 1] + power);
    }
    let between = |from: usize, to: usize| sums[to.min(half)] - sums[from.min(half)];
    let mean = |k: usize| {
        // The line itself leaks into the nearest frequencies, which are left out.
        let (near, far) = (k.saturating_sub(TOUCHED), k.saturating_sub(AROUND));
        let after = (k + 2 + TOUCHED, k + 2 + AROUND);
        let count = near - far + after.1.min(half) - after.0.min(half);
        (between(far, near) + between(after.0, after.1)) / count.max(1) as f64
    };
    let next = |k: usize| ordered.get(k + 1).copied().unwrap_or(0.0);
    (0..half).map(|k| ordered[k] + next(k) - 2.0 * mean(k)).collect()
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, EventStream, Micros};

    use super::*;
    use crate::probe::testing;

    /// Stamps of a clock that visits rows or columns in turn, forward or backward.
    fn scanned(period_us: f64, visits_rows: bool, backward: bool) -> EventStream {
        testing::changed(|event| {
            let (line, lines) = if visits_rows { (event.y, 72.0) } else { (event.x, 96.0) };
            let phase = f64::from(line) / lines;
            let phase = if backward { 1.0 - phase } else { phase };
            let visit = (event.t.0 as f64 / period_us - phase).ceil();
            Some(Event { t: Micros(((visit + phase) * period_us) as i64), ..event })
        })
    }

    fn locking(events: &EventStream) -> [f64; AXES.len() * BANDS] {
        let view = View::new(testing::reference_scene(), events, testing::whole());
        resultants(&view, &Spot::from_view(&view))
    }

    #[test]
    fn a_scan_is_found_with_its_axis_and_its_decade() {
        for (period_us, band) in [(130.0, 0), (1_037.0, 1), (7_310.0, 2)] {
            for (visits_rows, axis) in [(true, 2), (false, 1)] {
                for backward in [false, true] {
                    let locking = locking(&scanned(period_us, visits_rows, backward));
                    // Other decades have the clock of single lines and harmonics.
                    for other in 0..AXES.len() {
                        let strength = locking[other * BANDS + band];
                        let right = if other == axis { strength > 0.8 } else { strength < 0.6 };
                        assert!(right, "{period_us} us, {backward}: {other} {strength}");
                    }
                }
            }
        }
    }

    #[test]
    fn period_axis_and_direction_of_a_scan_are_estimated_from_the_stamps() {
        for period_us in [130.0, 960.0, 7_310.0] {
            for visits_rows in [true, false] {
                for backward in [false, true] {
                    let scan = scan_of(&scanned(period_us, visits_rows, backward)).unwrap();
                    assert!((scan.period_us / period_us - 1.0).abs() < 1e-4, "{scan:?}");
                    assert_eq!((scan.is_by_row, scan.is_backward), (visits_rows, backward));
                    assert!(scan.locked > 0.9, "{scan:?}");
                }
            }
        }
        assert!(scan_of(testing::events()).unwrap().locked < 0.2);
        assert!(scan_of(&EventStream::empty(testing::events().sensor())).is_none());
    }

    #[test]
    fn events_without_a_clock_show_none() {
        for strength in locking(&testing::stream(testing::noise(20_000, 2))) {
            assert!(strength < 0.02, "{strength}");
        }
    }
}

//! How strongly stamps are locked to a clock, and the clock to a row or a column.
//!
//! # Model
//! A readout that visits row `y` of `H` at `t = k T + T y / H` makes `exp(2 pi i (t / T - y / H))`
//! the same for all events. Its mean over events is a Fourier transform of events that weigh
//! `exp(-+2 pi i y / H)`, which gives all periods `T` and both directions at once. Power is summed
//! over blocks of a third of a second, so that a clock may drift; from it goes that of
//! neighbouring frequencies, so that motion, which has no lines, does not show, and what chance
//! makes of the highest of many.

use std::f64::consts::TAU;

use crate::probe::fourier::{self, Fourier, MAX_LENGTH};
use crate::{Sight, View};

/// Shorter periods than two bins cannot be told.
const BIN_US: i64 = 10;
const BLOCK_US: i64 = BIN_US * MAX_LENGTH as i64;
/// Blocks are spread evenly where there would be more.
const MAX_BLOCKS: i64 = 5;
/// Neighbours on either side, and those of them that a line touches itself.
const AROUND: usize = 16;
const TOUCHED: usize = 2;
/// Periods from 20 us to 20 ms, a decade each.
pub(super) const BANDS: usize = 3;
/// What the clock may be locked to.
pub(super) const AXES: [&str; 3] = ["no coordinate", "the column", "the row"];

/// Frequencies of a band, in cycles per block.
fn band(index: usize) -> std::ops::Range<usize> {
    let longest_us = 20.0 * 10_f64.powi(index as i32 + 1);
    let cycles = |period_us: f64| (BLOCK_US as f64 / period_us) as usize;
    let highest = cycles(0.1 * longest_us).min(MAX_LENGTH / 2 - 1);
    cycles(longest_us).max(AROUND)..highest
}

/// When and where an event was.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    /// Microseconds.
    pub(super) t_us: i64,
    /// Column.
    pub(super) x: u16,
    /// Row.
    pub(super) y: u16,
}

impl Spot {
    /// Those of all events of a view.
    pub(super) fn of(view: &View<'_>) -> Vec<Self> {
        let width = u32::from(view.size().width);
        let spot = |event: &Sight| {
            let (x, y) = ((event.pixel % width) as u16, (event.pixel / width) as u16);
            Self { t_us: event.t_us, x, y }
        };
        view.events().iter().map(spot).collect()
    }
}

/// Resultant lengths, axis by axis and band by band: one where all events are locked.
pub(super) fn resultants(view: &View<'_>, spots: &[Spot]) -> [f64; AXES.len() * BANDS] {
    let size = view.size();
    let phases = |n: u16| -> Vec<(f32, f32)> {
        let angles = (0..n).map(|i| -TAU * f64::from(i) / f64::from(n));
        angles.map(|a| (a.cos() as f32, a.sin() as f32)).collect()
    };
    let (columns, rows) = (phases(size.width), phases(size.height));
    let mut signals = [(); AXES.len()].map(|()| Fourier::zeros(MAX_LENGTH));
    let mut powers = [(); AXES.len()].map(|()| vec![0.0_f32; MAX_LENGTH]);
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
    let mut found = [0.0; AXES.len() * BANDS];
    if pairs == 0.0 {
        return found;
    }
    let chance = pairs.sqrt();
    for (axis, power) in powers.iter().enumerate() {
        for backward in [false, true].into_iter().take(if axis == 0 { 1 } else { 2 }) {
            let excess = excess(power, backward);
            for b in 0..BANDS {
                let band = band(b);
                let highest = chance * (band.len() as f64).ln();
                let best = excess[band].iter().fold(0.0, |best: f64, e| best.max(*e));
                let square = ((best - highest) / pairs).clamp(0.0, 1.0);
                found[axis * BANDS + b] = square.sqrt().max(found[axis * BANDS + b]);
            }
        }
    }
    found
}

fn block_starts(view: &View<'_>) -> impl Iterator<Item = i64> {
    let (start_us, length_us) = (view.window.start.0, view.window.length().0);
    let blocks = (length_us / BLOCK_US).clamp(1, MAX_BLOCKS);
    let room_us = (length_us - BLOCK_US).max(0);
    (0..blocks).map(move |b| start_us + room_us * b / (blocks - 1).max(1))
}

/// Power at two neighbouring frequencies, between which a line may lie, above that around them.
fn excess(power: &[f32], backward: bool) -> Vec<f64> {
    let half = power.len() / 2;
    let at = |k: usize| {
        let k = if backward { power.len() - k } else { k };
        f64::from(power[fourier::place(k, power.len())])
    };
    let mut sums = Vec::with_capacity(half + 1);
    sums.push(0.0);
    // The mean is no line.
    let ordered: Vec<f64> = (0..half).map(|k| if k == 0 { 0.0 } else { at(k) }).collect();
    for power in &ordered {
        sums.push(sums[sums.len() - 1] + power);
    }
    let between = |from: usize, to: usize| sums[to.min(half)] - sums[from.min(half)];
    let mean = |k: usize| {
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

    fn found(events: &EventStream) -> [f64; AXES.len() * BANDS] {
        let view = View::new(testing::stage(), events, testing::whole());
        resultants(&view, &Spot::of(&view))
    }

    #[test]
    fn a_scan_is_found_with_its_axis_and_its_decade() {
        for (period_us, band) in [(130.0, 0), (1_037.0, 1), (7_310.0, 2)] {
            for (visits_rows, axis) in [(true, 2), (false, 1)] {
                for backward in [false, true] {
                    let found = found(&scanned(period_us, visits_rows, backward));
                    // Other decades have the clock of single lines and harmonics.
                    for other in 0..AXES.len() {
                        let strength = found[other * BANDS + band];
                        let right = if other == axis { strength > 0.8 } else { strength < 0.6 };
                        assert!(right, "{period_us} us, {backward}: {other} {strength}");
                    }
                }
            }
        }
    }

    #[test]
    fn events_that_no_clock_holds_show_none() {
        for strength in found(&testing::stream(testing::noise(20_000, 2))) {
            assert!(strength < 0.02, "{strength}");
        }
    }
}

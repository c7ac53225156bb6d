//! Clocks: time stamps that are multiples of a period, and scans of rows or columns.
//!
//! # Method
//! `A(f, k) = sum over events of exp(2 pi i (k y / rows - f t))` is large at `f = 1/T` and `k = 0`
//! for a clock of period `T`, and at `k = 1` for a scan of the rows (`k = -1` from the last row to
//! the first), because the phase of its clock goes once around over the rows. Powers are summed
//! over stretches of 65 ms, and compared with neighbouring frequencies: the spectrum of motion is
//! smooth.

use std::f64::consts::{PI, TAU};

use super::train::{Mark, Train};
use crate::fourier::Fourier;

/// Minimum events of a spectral line.
const MIN_LINE_EVENTS: usize = 50;
/// Time step of the transform; the shortest period is 4 us.
const STEP_US: i64 = 2;
const STEPS: usize = 1 << 15;
const STRETCH_US: i64 = STEP_US * STEPS as i64;
const MAX_STRETCHES: i64 = 16;
/// Minimum turns of a period in a stretch.
const MIN_TURNS: usize = 3;
/// Number of neighbouring frequencies that a power is compared with.
const NEIGHBOURS: usize = 32;
/// Fraction of the strongest line's contrast from which a line is strong.
const AS_STRONG: f64 = 0.3;
/// Number of strong lines of an axis that are tried, and of slow ones among the strong.
const MAX_LINES: usize = 8;
/// Fraction of the largest resultant length from which a slower line is preferred.
const AS_LOCKED: f64 = 0.8;
/// Steps within a turn per stretch at which a line is tried.
const NEAR_STEPS: i32 = 8;
/// Minimum resultant length of a clock.
const MIN_LOCKING: f64 = 0.4;
/// Minimum ratio of the locking with the phase of the row or column to that without.
const MIN_GAIN: f64 = 1.3;
/// Minimum fraction of stamps that are multiples of a clock's period.
const MIN_MULTIPLES: f64 = 0.98;
/// Maximum period of a clock in whole microseconds.
const MAX_COUNT_US: i64 = 100_000;

/// Coordinate that the phase of a clock depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    /// None: one clock for all pixels.
    None,
    /// A clock for each row.
    Rows,
    /// A clock for each column.
    Columns,
}

impl Axis {
    pub(super) const ALL: [Self; 3] = [Self::None, Self::Rows, Self::Columns];

    fn phase(self, train: &Train, pixel: u32) -> f64 {
        let (width, height) = (u32::from(train.size.width), u32::from(train.size.height));
        match self {
            Self::None => 0.0,
            Self::Rows => f64::from(pixel / width) / f64::from(height),
            Self::Columns => f64::from(pixel % width) / f64::from(width),
        }
    }
}

#[derive(Debug, Clone)]
pub(super) struct SpectralLines {
    /// Power of the strongest relative to neighbouring frequencies.
    pub(super) contrast: f64,
    /// Frequencies of the strong ones in turns per stretch, negative for a scan from the last line
    /// to the first; the slowest first.
    turns: Vec<f64>,
}

/// The spectral lines of the three axes; none with fewer than fifty events.
pub(super) fn lines(train: &Train) -> [Option<SpectralLines>; 3] {
    Axis::ALL.map(|axis| lines_of(train, axis))
}

fn lines_of(train: &Train, axis: Axis) -> Option<SpectralLines> {
    let (start, end) = train.span_us();
    let stretches = ((end - start) / STRETCH_US).clamp(1, MAX_STRETCHES);
    let spare = (end - start - stretches * STRETCH_US).max(0);
    let mut power = vec![0.0; STEPS];
    let mut n = 0usize;
    let mut values = Fourier::zeros(STEPS);
    for stretch in 0..stretches {
        // Spread evenly over the recording.
        let from = start + stretch * STRETCH_US + spare * stretch / (stretches - 1).max(1);
        let marks = within(&train.marks, from, from + STRETCH_US);
        n += marks.len();
        values.clear();
        for mark in marks {
            let (sin, cos) = (TAU * axis.phase(train, mark.pixel)).sin_cos();
            let step = ((mark.t_us - from) / STEP_US) as usize;
            values.re[step] += cos as f32;
            values.im[step] += sin as f32;
        }
        values.transform();
        for (f, power) in power.iter_mut().enumerate() {
            let [re, im] = values.at(f).map(f64::from);
            *power += re * re + im * im;
        }
    }
    if n < MIN_LINE_EVENTS {
        return None;
    }
    // Without an axis the signal is real, and its spectrum symmetric.
    let end = if axis == Axis::None { STEPS / 2 } else { STEPS - MIN_TURNS };
    let mut sorted = [0.0; NEIGHBOURS];
    for block in power.chunks_exact_mut(NEIGHBOURS) {
        sorted.copy_from_slice(block);
        let (_, median, _) = sorted.select_nth_unstable_by(NEIGHBOURS / 2, f64::total_cmp);
        let background = median.max(n as f64);
        block.iter_mut().for_each(|power| *power /= background);
    }
    let contrast = power[MIN_TURNS..end].iter().copied().fold(0.0, f64::max);
    let turns = |f: usize| if f < STEPS / 2 { f as f64 } else { f as f64 - STEPS as f64 };
    // A line between two frequencies is in both.
    let is_peak = |f: &usize| power[*f] >= power[*f - 1].max(power[*f + 1]);
    let strong = (MIN_TURNS..end).filter(|f| power[*f] >= AS_STRONG * contrast).filter(is_peak);
    let mut strong: Vec<usize> = strong.collect();
    // The clock itself is the strongest or the slowest of them.
    strong.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
    let mut chosen: Vec<usize> = strong.iter().copied().take(MAX_LINES).collect();
    strong.sort_by(|a, b| turns(*a).abs().total_cmp(&turns(*b).abs()));
    chosen.extend(strong.into_iter().take(MAX_LINES));
    let mut turns: Vec<f64> = chosen.into_iter().map(turns).collect();
    turns.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    turns.dedup();
    (!turns.is_empty()).then_some(SpectralLines { contrast, turns })
}

fn within(marks: &[Mark], from: i64, to: i64) -> &[Mark] {
    let begin = marks.partition_point(|mark| mark.t_us < from);
    let end = marks.partition_point(|mark| mark.t_us < to);
    &marks[begin..end]
}

/// A scanned readout of rows or columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scan {
    pub(super) axis: Axis,
    pub(super) period_us: f64,
    pub(super) is_backward: bool,
}

/// Finds the scan that all events are locked to, if there is one.
pub(super) fn scan(train: &Train) -> Option<Scan> {
    let lines = lines(train);
    // Motion and lamps have strong lines as well, but hardly lock events.
    let mut near = Vec::new();
    for (axis, lines) in [(Axis::Rows, &lines[1]), (Axis::Columns, &lines[2])] {
        for turns in lines.iter().flat_map(|lines| &lines.turns) {
            near.push((axis, *turns, locked_in_first_stretch(train, axis, *turns)));
        }
    }
    let most = near.iter().map(|(_, _, locking)| *locking).fold(0.0, f64::max);
    near.retain(|(_, _, locking)| *locking >= AS_LOCKED * most);
    // Harmonics and aliases lock as much: the slowest line is the clock.
    let (axis, turns, _) = near.into_iter().min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let (frequency, locking) = refined(train, axis, turns);
    // A common clock of all pixels locks rows as well: the phase over the rows has to add
    // something.
    let plain = locked(train, Axis::None, frequency);
    (locking >= MIN_LOCKING && locking >= MIN_GAIN * plain).then(|| Scan {
        axis,
        period_us: 1.0 / frequency.abs(),
        is_backward: frequency < 0.0,
    })
}

/// Finds the period of the clock of all time stamps, microseconds.
pub(super) fn count_us(train: &Train) -> Option<f64> {
    if let Some(us) = whole_count_us(train) {
        return Some(us as f64);
    }
    let turns = *lines(train)[0].as_ref()?.turns.first()?;
    let (frequency, _) = refined(train, Axis::None, turns);
    // Stamps of a clock deviate from it only by the rounding to whole microseconds.
    let is_clock = (1..=2).all(|turns| {
        let frequency = f64::from(turns) * frequency;
        let rounded = (PI * frequency).sin() / (PI * frequency);
        locked(train, Axis::None, frequency) >= MIN_MULTIPLES * rounded
    });
    is_clock.then(|| 1.0 / frequency)
}

/// The longest period in whole microseconds that divides nearly all stamps, up to an offset.
fn whole_count_us(train: &Train) -> Option<i64> {
    if train.marks.len() < MIN_LINE_EVENTS {
        return None;
    }
    let mut gaps: Vec<i64> =
        train.marks.windows(2).map(|pair| pair[1].t_us - pair[0].t_us).collect();
    gaps.retain(|gap| *gap > 0);
    gaps.sort_unstable();
    let common = gaps.chunk_by(|a, b| a == b).max_by_key(|chunk| chunk.len())?[0];
    // The most frequent interval is a multiple of the period. A few events exclude most candidates.
    let few = &train.marks[..train.marks.len().min(200)];
    let divisors = (2..=common.min(MAX_COUNT_US)).rev().filter(|count| common % count == 0);
    let mut possible = divisors.filter(|count| multiples(few, *count) >= 0.9);
    possible.find(|count| multiples(&train.marks, *count) >= MIN_MULTIPLES)
}

/// Fraction of stamps with the most frequent remainder.
fn multiples(marks: &[Mark], count_us: i64) -> f64 {
    let mut rests: Vec<i64> = marks.iter().map(|mark| mark.t_us.rem_euclid(count_us)).collect();
    rests.sort_unstable();
    let largest = rests.chunk_by(|a, b| a == b).map(<[i64]>::len).max().unwrap_or(0);
    largest as f64 / marks.len() as f64
}

/// Resultant length of all events at a frequency in turns per microsecond; one if all have one
/// phase.
fn locked(train: &Train, axis: Axis, frequency: f64) -> f64 {
    locking(train, axis, &train.marks, frequency)
}

fn locking(train: &Train, axis: Axis, marks: &[Mark], frequency: f64) -> f64 {
    let start = train.span_us().0;
    let (mut re, mut im) = (0.0, 0.0);
    for mark in marks {
        // From the first event on: large stamps times a frequency would lose the digits of the
        // phase.
        let turns = axis.phase(train, mark.pixel) - frequency * (mark.t_us - start) as f64;
        let (sin, cos) = (TAU * turns.fract()).sin_cos();
        re += cos;
        im += sin;
    }
    f64::hypot(re, im) / marks.len().max(1) as f64
}

/// Resultant length of the events of the first stretch at the best frequency near `turns` per
/// stretch.
fn locked_in_first_stretch(train: &Train, axis: Axis, turns: f64) -> f64 {
    let (start, end) = train.span_us();
    let marks = within(&train.marks, start, end.min(start + STRETCH_US));
    let near = (-NEAR_STEPS..=NEAR_STEPS).map(|k| turns + f64::from(k) / f64::from(NEAR_STEPS));
    near.map(|turns| locking(train, axis, marks, turns / STRETCH_US as f64)).fold(0.0, f64::max)
}

/// Refines a frequency near `turns` per stretch on longer and longer parts of the recording: the
/// frequency of the largest resultant length, turns per microsecond, and that length.
fn refined(train: &Train, axis: Axis, turns: f64) -> (f64, f64) {
    let (start, end) = train.span_us();
    let mut length = STRETCH_US.min(end - start);
    let mut frequency = turns / STRETCH_US as f64;
    let mut reach = 1.5 / STRETCH_US as f64;
    loop {
        // A long part resolves finer frequencies, but only near one that is known: the grid is
        // refined by four each time, instead of laid over all frequencies of the whole recording.
        let marks = within(&train.marks, start, start + length);
        let step = 0.1 / length as f64;
        let steps = (reach / step).ceil() as i64;
        let candidates = (-steps..=steps).map(|k| frequency + k as f64 * step);
        let scored = candidates.map(|f| (f, locking(train, axis, marks, f)));
        let best = scored.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((frequency, 0.0));
        frequency = best.0;
        if length == end - start {
            return best;
        }
        reach = 3.0 * step;
        length = (4 * length).min(end - start);
    }
}

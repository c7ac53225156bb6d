//! Clocks: stamps that are multiples of a period, and rows or columns that are visited in turn.
//!
//! # Method
//! `A(f, k) = sum over events of exp(2 pi i (k y / rows - f t))`. A clock of period `T` makes it
//! large at `f = 1/T` and `k = 0`; a scan of the rows at `k = 1` or, from the last row to the
//! first, at `k = -1`, since the phase of its clock goes once around over the rows. Powers are
//! summed over stretches of 65 ms, and compared with their neighbours: what light does is smooth
//! over frequency.

use std::f64::consts::{PI, TAU};

use super::fourier::{Complex, Fourier};
use super::train::{Mark, Train};

/// Step of the transform: periods from 4 us.
const STEP_US: i64 = 2;
/// Steps of one stretch.
const STEPS: usize = 1 << 15;
/// Length of one stretch.
const STRETCH_US: i64 = STEP_US * STEPS as i64;
/// Stretches looked at, at most.
const MOST_STRETCHES: i64 = 16;
/// The longest period is this part of a stretch.
const LEAST_TURNS: usize = 3;
/// Neighbours that a power is compared with.
const NEIGHBOURS: usize = 32;
/// Part of the strongest line's contrast that a slower one needs to be taken instead.
const AS_STRONG: f64 = 0.3;
/// Mean length of the sum of unit vectors from which on a clock is one.
const LEAST_LOCKING: f64 = 0.4;
/// How much better events must be locked with the phase of their line than without.
const LEAST_GAIN: f64 = 1.3;
/// Part of the stamps that are multiples of a clock's period.
const LEAST_MULTIPLES: f64 = 0.98;
/// The longest count of a clock.
const LONGEST_COUNT_US: i64 = 100_000;

/// What goes with the phase of a clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    /// Nothing: one clock for all pixels.
    None,
    /// The row.
    Rows,
    /// The column.
    Columns,
}

impl Axis {
    pub(super) const ALL: [Self; 3] = [Self::None, Self::Rows, Self::Columns];

    /// The phase of a pixel in turns, less than one.
    fn phase(self, train: &Train, pixel: u32) -> f64 {
        let (width, height) = (u32::from(train.size.width), u32::from(train.size.height));
        match self {
            Self::None => 0.0,
            Self::Rows => f64::from(pixel / width) / f64::from(height),
            Self::Columns => f64::from(pixel % width) / f64::from(width),
        }
    }
}

/// The strongest line: its power over that of its neighbours, and its frequency in turns of a
/// stretch, negative for a scan from the last line to the first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) contrast: f64,
    turns: f64,
}

/// The strongest lines of the three axes.
pub(super) fn lines(train: &Train) -> [Option<Line>; 3] {
    let fourier = Fourier::new(STEPS);
    Axis::ALL.map(|axis| line(train, axis, &fourier))
}

fn line(train: &Train, axis: Axis, fourier: &Fourier) -> Option<Line> {
    let (start, end) = train.span_us();
    let stretches = ((end - start) / STRETCH_US).clamp(1, MOST_STRETCHES);
    let spare = (end - start - stretches * STRETCH_US).max(0);
    let mut power = vec![0.0; STEPS];
    let mut n = 0usize;
    let mut values = vec![Complex::default(); STEPS];
    for stretch in 0..stretches {
        // Spread evenly over the recording.
        let from = start + stretch * STRETCH_US + spare * stretch / (stretches - 1).max(1);
        let marks = within(&train.marks, from, from + STRETCH_US);
        n += marks.len();
        values.fill(Complex::default());
        for mark in marks {
            let (sin, cos) = (TAU * axis.phase(train, mark.pixel)).sin_cos();
            let value = &mut values[((mark.t_us - from) / STEP_US) as usize];
            value.re += cos as f32;
            value.im += sin as f32;
        }
        fourier.transform(&mut values);
        power.iter_mut().zip(&values).for_each(|(power, value)| *power += value.power());
    }
    if n < 50 {
        return None;
    }
    // Without an axis the other half is a mirror image.
    let end = if axis == Axis::None { STEPS / 2 } else { STEPS - LEAST_TURNS };
    let mut sorted = [0.0; NEIGHBOURS];
    for block in power.chunks_exact_mut(NEIGHBOURS) {
        sorted.copy_from_slice(block);
        let (_, median, _) = sorted.select_nth_unstable_by(NEIGHBOURS / 2, f64::total_cmp);
        let background = median.max(n as f64);
        block.iter_mut().for_each(|power| *power /= background);
    }
    let contrast = power[LEAST_TURNS..end].iter().copied().fold(0.0, f64::max);
    let turns = |f: usize| if f < STEPS / 2 { f as f64 } else { f as f64 - STEPS as f64 };
    // Harmonics, and turns of a whole line more, are as strong: the slowest is the clock.
    let strong = (LEAST_TURNS..end).filter(|f| power[*f] >= AS_STRONG * contrast);
    let slowest = strong.map(turns).min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    Some(Line { contrast, turns: slowest })
}

fn within(marks: &[Mark], from: i64, to: i64) -> &[Mark] {
    let begin = marks.partition_point(|mark| mark.t_us < from);
    let end = marks.partition_point(|mark| mark.t_us < to);
    &marks[begin..end]
}

/// A readout that visits rows or columns in turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scan {
    pub(super) axis: Axis,
    pub(super) period_us: f64,
    pub(super) is_backward: bool,
}

/// The scan that all events are locked to, if there is one.
pub(super) fn scan(train: &Train) -> Option<Scan> {
    let lines = lines(train);
    let (axis, line) = [(Axis::Rows, lines[1]?), (Axis::Columns, lines[2]?)]
        .into_iter()
        .max_by(|a, b| a.1.contrast.total_cmp(&b.1.contrast))?;
    let (frequency, locking) = refined(train, axis, line.turns);
    let plain = locked(train, Axis::None, frequency);
    (locking >= LEAST_LOCKING && locking >= LEAST_GAIN * plain).then(|| Scan {
        axis,
        period_us: 1.0 / frequency.abs(),
        is_backward: frequency < 0.0,
    })
}

/// The period of the clock that stamps all events, in microseconds.
pub(super) fn count_us(train: &Train) -> Option<f64> {
    if let Some(us) = whole_count_us(train) {
        return Some(us as f64);
    }
    let line = lines(train)[0]?;
    let (frequency, _) = refined(train, Axis::None, line.turns);
    // Stamps of a clock are off by no more than the rounding to whole microseconds.
    let is_clock = (1..=2).all(|turns| {
        let frequency = f64::from(turns) * frequency;
        let rounded = (PI * frequency).sin() / (PI * frequency);
        locked(train, Axis::None, frequency) >= LEAST_MULTIPLES * rounded
    });
    is_clock.then(|| 1.0 / frequency)
}

/// The longest whole count of which nearly all stamps are multiples, but for an offset.
fn whole_count_us(train: &Train) -> Option<i64> {
    if train.marks.len() < 50 {
        return None;
    }
    let mut gaps: Vec<i64> =
        train.marks.windows(2).map(|pair| pair[1].t_us - pair[0].t_us).collect();
    gaps.retain(|gap| *gap > 0);
    gaps.sort_unstable();
    let most = gaps.chunk_by(|a, b| a == b).max_by_key(|chunk| chunk.len())?[0];
    // The most frequent gap is a multiple of the count. A few events tell most that are not.
    let few = &train.marks[..train.marks.len().min(200)];
    let divisors = (2..=most.min(LONGEST_COUNT_US)).rev().filter(|count| most % count == 0);
    let mut possible = divisors.filter(|count| multiples(few, *count) >= 0.9);
    possible.find(|count| multiples(&train.marks, *count) >= LEAST_MULTIPLES)
}

/// Part of the stamps with the most frequent rest.
fn multiples(marks: &[Mark], count_us: i64) -> f64 {
    let mut rests: Vec<i64> = marks.iter().map(|mark| mark.t_us.rem_euclid(count_us)).collect();
    rests.sort_unstable();
    let largest = rests.chunk_by(|a, b| a == b).map(<[i64]>::len).max().unwrap_or(0);
    largest as f64 / marks.len() as f64
}

/// How well events are locked to a frequency in turns a microsecond: one if all have one phase.
fn locked(train: &Train, axis: Axis, frequency: f64) -> f64 {
    locking(train, axis, &train.marks, frequency)
}

fn locking(train: &Train, axis: Axis, marks: &[Mark], frequency: f64) -> f64 {
    let start = train.span_us().0;
    let (mut re, mut im) = (0.0, 0.0);
    for mark in marks {
        let turns = axis.phase(train, mark.pixel) - frequency * (mark.t_us - start) as f64;
        let (sin, cos) = (TAU * turns.fract()).sin_cos();
        re += cos;
        im += sin;
    }
    f64::hypot(re, im) / marks.len().max(1) as f64
}

/// The frequency near `turns` of a stretch to which events are locked best, in turns a
/// microsecond, and how well they are: over longer and longer parts of the recording, each of
/// which tells it more exactly.
fn refined(train: &Train, axis: Axis, turns: f64) -> (f64, f64) {
    let (start, end) = train.span_us();
    let mut length = STRETCH_US.min(end - start);
    let mut frequency = turns / STRETCH_US as f64;
    let mut reach = 1.5 / STRETCH_US as f64;
    loop {
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

//! The usual lines, read many bytes at a time.
//!
//! One window of bytes holds a line. The ends of all its fields are located at once, and digits
//! become integers eight at a time, so that nothing is decided digit by digit. Whatever is unusual
//! about a line (a sign, a comment, an exponent, two spaces) makes it none of these: it is left to
//! [`super::line`], which gives the same for every line that is read here.

use evpose_core::{Micros, Polarity};
use evpose_cpu::vectorize;

use super::line::{Known, TIME_LAST, USUAL};
use crate::{Columns, TimeUnit};

/// Bytes in which the fields of a line end.
const WINDOW: usize = 32;
/// Bytes that may be touched from the beginning of a line: the last field may begin behind the
/// window, and integers are taken 16 bytes at a time.
const REACH: usize = WINDOW + 16;
/// Lines that are gathered before they are appended.
const BATCH: usize = 128;

/// Shape of the lines of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    /// `3811 96 133 0`
    Microseconds,
    /// `0.003811 96 133 0`
    Seconds,
    /// `96,133,0,3811`
    TimeLast,
}

/// Bytes and lines that were read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Progress {
    pub(super) bytes: usize,
    pub(super) lines: u64,
}

/// Appends the events of usual lines at the beginning of `bytes`, as far as these go.
pub(super) fn read(bytes: &[u8], known: &Known, columns: &mut Columns) -> Progress {
    match (known.order, known.unit) {
        (Some(USUAL), Some(TimeUnit::Microseconds)) => run(bytes, Shape::Microseconds, columns),
        (Some(USUAL), Some(TimeUnit::Seconds)) => run(bytes, Shape::Seconds, columns),
        (Some(TIME_LAST), Some(TimeUnit::Microseconds)) => run(bytes, Shape::TimeLast, columns),
        // Other orders of columns are left to the slower parser.
        _ => Progress::default(),
    }
}

/// As [`read`], compiled for each shape, and for processors that shift by any register.
#[inline(always)]
fn run(bytes: &[u8], shape: Shape, columns: &mut Columns) -> Progress {
    vectorize(
        #[inline(always)]
        || run_lines(bytes, shape, columns),
    )
}

#[inline(always)]
fn run_lines(bytes: &[u8], shape: Shape, columns: &mut Columns) -> Progress {
    let mut progress = Progress::default();
    loop {
        let mut t = [Micros(0); BATCH];
        let (mut x, mut y) = ([0; BATCH], [0; BATCH]);
        let mut polarity = [Polarity::Off; BATCH];
        let mut count = 0;
        while count < BATCH
            && let Some(here) = bytes[progress.bytes..].first_chunk::<REACH>()
            && let Some(line) = line(here, shape)
        {
            t[count] = Micros(line.t);
            (x[count], y[count]) = (line.x, line.y);
            polarity[count] = Polarity::from_on(line.is_on);
            progress.bytes += line.length;
            count += 1;
        }
        // Each column checks its capacity once per batch, not per event.
        columns.t.extend_from_slice(&t[..count]);
        columns.x.extend_from_slice(&x[..count]);
        columns.y.extend_from_slice(&y[..count]);
        columns.polarity.extend_from_slice(&polarity[..count]);
        progress.lines += count as u64;
        if count < BATCH {
            return progress;
        }
    }
}

struct Line {
    t: i64,
    x: u16,
    y: u16,
    is_on: bool,
    /// Bytes, with what ends it.
    length: usize,
}

/// Reads a usual line.
#[inline(always)]
fn line(here: &[u8; REACH], shape: Shape) -> Option<Line> {
    // A bit for each byte that is no digit: fields end there.
    let mut ends = non_digits(here);
    let mut end = || {
        let place = ends.trailing_zeros() as usize;
        ends &= ends.wrapping_sub(1);
        place
    };
    // Times in seconds have one more end, at the point.
    let dot = if shape == Shape::Seconds { end() } else { 0 };
    let ends = [end(), end(), end(), end()];
    let begins = [0, ends[0] + 1, ends[1] + 1, ends[2] + 1];
    let order = if shape == Shape::TimeLast { TIME_LAST } else { USUAL };
    let [t, x, y, p] = order.places;

    let length = |field: usize| ends[field].wrapping_sub(begins[field]);
    let is_on = here[begins[p]].wrapping_sub(b'0');
    // `&` instead of `&&`: one branch for all conditions, which nearly every line takes the same
    // way.
    let is_usual = (length(x).wrapping_sub(1) < 4)
        & (length(y).wrapping_sub(1) < 4)
        & (length(p) == 1)
        & (is_on < 2)
        & is_separator(here[ends[0]])
        & is_separator(here[ends[1]])
        & is_separator(here[ends[2]]);
    let (last, behind) = (here[ends[3]], here[ends[3] + 1]);
    let has_return = (last == b'\r') & (behind == b'\n');
    if !is_usual || !(last == b'\n' || has_return) {
        return None;
    }
    let t = match shape {
        Shape::Seconds => seconds(here, dot, ends[0])?,
        // `sixteen` loads sixteen bytes, so that longer numerals go the slow way.
        _ if length(t).wrapping_sub(1) < 16 => digits(sixteen(here, begins[t]), length(t)) as i64,
        _ => return None,
    };
    let [x, y] = [x, y].map(|field| few_digits(here, begins[field], length(field)));
    Some(Line { t, x, y, is_on: is_on == 1, length: ends[3] + 1 + usize::from(has_return) })
}

/// Whether fields may be separated by this byte: a space, a tab, a comma or a semicolon.
#[inline(always)]
fn is_separator(byte: u8) -> bool {
    const SEPARATORS: u64 = 1 << b' ' | 1 << b'\t' | 1 << b',' | 1 << b';';
    (byte < 64) & (SEPARATORS >> (byte & 63) & 1 == 1)
}

/// A bit for each byte in the window that is no digit, the first byte in the lowest bit.
#[inline(always)]
fn non_digits(here: &[u8; REACH]) -> u32 {
    let eights = here.as_chunks::<8>().0;
    let mut bits = 0;
    for (k, eight) in eights[..WINDOW / 8].iter().enumerate() {
        // Digits become 0 to 9, which the sum below leaves without their highest bit.
        let value = u64::from_le_bytes(*eight) ^ 0x3030_3030_3030_3030;
        let sum = (value & 0x7f7f_7f7f_7f7f_7f7f) + 0x7676_7676_7676_7676;
        let highest = ((sum | value) & 0x8080_8080_8080_8080) >> 7;
        // The product gathers one bit of each byte in the highest byte.
        bits |= (highest.wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * k);
    }
    bits as u32
}

/// Seconds with one to nine decimals, to the microsecond that [`Micros::from_seconds`] gives.
///
/// That rounds twice: a number of `v` microseconds to a double, and its product with a million. The
/// result is off by less than `v` / 2^52, so that it is the nearest microsecond, too, wherever the
/// nearest half of a microsecond is further away. The rest is left to it.
#[inline(always)]
fn seconds(here: &[u8; REACH], dot: usize, end: usize) -> Option<i64> {
    let decimals = end.wrapping_sub(dot + 1);
    let is_usual =
        (here[dot] == b'.') & (dot.wrapping_sub(1) < 10) & (decimals.wrapping_sub(1) < 9);
    if !is_usual {
        return None;
    }
    let whole = digits(sixteen(here, 0), dot);
    // The first eight decimals, zeros behind those there are; then the ninth.
    let eight = sixteen(here, dot + 1) as u64 & (u64::MAX >> (64 - 8 * decimals.min(8)));
    let ninth = if decimals == 9 { u64::from(here[dot + 9] - b'0') } else { 0 };
    let nanoseconds = 10 * eight_digits(eight) + ninth;
    let from_half = (nanoseconds % 1000).abs_diff(500);
    // In nanoseconds: 2^22 s / 2^52 is less than 1, and 2^31 s / 2^52 less than 480.
    let is_clear = if whole < 1 << 22 { from_half > 0 } else { from_half > 480 };
    let rounded = (nanoseconds + 500) / 1000;
    (is_clear && whole < 1 << 31).then_some((1_000_000 * whole + rounded) as i64)
}

/// The 16 bytes from `begin` on.
#[inline(always)]
fn sixteen(here: &[u8; REACH], begin: usize) -> u128 {
    let bytes = here[begin..].first_chunk().copied();
    u128::from_le_bytes(bytes.unwrap_or_default())
}

/// The number that the first `length` of 16 bytes are the digits of.
#[inline(always)]
fn digits(bytes: u128, length: usize) -> u64 {
    // What comes behind is shifted out, and zeros come before.
    let aligned = bytes << (128 - 8 * length);
    100_000_000 * eight_digits(aligned as u64) + eight_digits((aligned >> 64) as u64)
}

/// The number of eight digits, the first in the lowest byte. Zero bytes are zeros.
#[inline(always)]
fn eight_digits(bytes: u64) -> u64 {
    let ones = bytes & 0x0f0f_0f0f_0f0f_0f0f;
    let tens = (ones.wrapping_mul(10 << 8 | 1) >> 8) & 0x00ff_00ff_00ff_00ff;
    let hundreds = (tens.wrapping_mul(100 << 16 | 1) >> 16) & 0x0000_ffff_0000_ffff;
    hundreds.wrapping_mul(10_000 << 32 | 1) >> 32
}

/// The number that `length` digits, one to four, are from `begin` on.
#[inline(always)]
fn few_digits(here: &[u8; REACH], begin: usize, length: usize) -> u16 {
    let bytes = here[begin..].first_chunk().copied();
    let aligned = u32::from_le_bytes(bytes.unwrap_or_default()) << (32 - 8 * length);
    let ones = aligned & 0x0f0f_0f0f;
    let tens = (ones.wrapping_mul(10 << 8 | 1) >> 8) & 0x00ff_00ff;
    (tens.wrapping_mul(100 << 16 | 1) >> 16) as u16
}

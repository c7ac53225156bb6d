//! Maxima and means of windows.

use std::ops::Range;

use super::conv::Output;
use super::image::{Image, Input};
use super::thread_pool::ThreadPool;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Windows of which the largest value counts; what lies outside of the image does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MaxPool {
    /// Rows and columns of a window.
    pub window: usize,
    /// Pixels between windows.
    pub stride: usize,
    /// Pixels by which the first window begins outside; less than the window.
    pub padding: usize,
}

impl MaxPool {
    /// Rows or columns of the output for so many of the input.
    pub fn output(&self, pixels: usize) -> usize {
        let room = (pixels + 2 * self.padding).checked_sub(self.window);
        room.map_or(0, |room| room / self.stride + 1)
    }

    /// The rows and the columns of every window on an image of so many.
    ///
    /// # Panics
    /// If a window lies outside altogether.
    pub(super) fn windows(&self, size: [usize; 2]) -> [Vec<Range<usize>>; 2] {
        assert!(self.padding < self.window && self.stride > 0, "windows that see the image");
        size.map(|side| (0..self.output(side)).map(|k| self.window_of(k, side)).collect())
    }

    /// What window `k` sees of so many rows or columns.
    pub(super) fn window_of(&self, k: usize, side: usize) -> Range<usize> {
        let from = (k * self.stride).saturating_sub(self.padding);
        from..(k * self.stride + self.window - self.padding).min(side)
    }

    /// Writes the maxima of `input` to `output`.
    ///
    /// # Panics
    /// If the output has another size, or a window lies outside altogether.
    pub fn run(&self, thread_pool: &ThreadPool, level: Level, input: &Image, output: &mut Image) {
        let [rows, columns] = self.windows([input.height(), input.width()]);
        let size = [rows.len(), columns.len()];
        assert_eq!([output.height(), output.width()], size, "size of the output");
        pooled(thread_pool, level, input, [&rows, &columns], Of::Maxima, output);
    }
}

/// Writes the maxima of so many rows of windows from row 0 of `out` on, of all blocks of channels.
///
/// # Safety
/// Windows are readable, the rows writable, and the level is one of this processor's.
pub(super) unsafe fn maxima(
    level: Level,
    input: Input,
    [rows, columns]: [&[Range<usize>]; 2],
    out: Output,
    blocks: usize,
) {
    let work = Windows { input, rows, columns, of: Of::Maxima, out, units: 0..blocks * rows.len() };
    // SAFETY: the caller's.
    unsafe { level.run(&work) };
}

/// Writes the means of windows that cover `input` evenly to `output`, as many as that has pixels.
///
/// # Panics
/// If the output has other channels, or either has no pixels.
pub fn mean_pool(thread_pool: &ThreadPool, level: Level, input: &Image, output: &mut Image) {
    let windows = |parts: usize, of: usize| -> Vec<Range<usize>> {
        (0..parts).map(|k| k * of / parts..((k + 1) * of).div_ceil(parts)).collect()
    };
    let rows = windows(output.height(), input.height());
    let columns = windows(output.width(), input.width());
    pooled(thread_pool, level, input, [&rows, &columns], Of::Means, output);
}

/// What is taken of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    Maxima,
    Means,
}

fn pooled(
    thread_pool: &ThreadPool,
    level: Level,
    input: &Image,
    [rows, columns]: [&[Range<usize>]; 2],
    of: Of,
    output: &mut Image,
) {
    assert_eq!(input.channels(), output.channels(), "channels");
    assert!(rows.iter().chain(columns).all(|window| !window.is_empty()), "windows with pixels");
    let units = output.blocks() * rows.len();
    let out = Output::of(output);
    thread_pool.run(&|part| {
        let input = Input::of(input);
        let work = Windows { input, rows, columns, of, out, units: part.chunk(units) };
        // SAFETY: windows are inside the input, outputs of the parts are disjoint, and the level is
        // one of this processor's.
        unsafe { level.run(&work) };
    });
}

/// Some rows of windows, block after block.
struct Windows<'a> {
    input: Input,
    rows: &'a [Range<usize>],
    columns: &'a [Range<usize>],
    of: Of,
    out: Output,
    units: Range<usize>,
}

impl Kernel for Windows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let row_pitch = self.input.row_pitch;
        for unit in self.units.clone() {
            let (block, row) = (unit / self.rows.len(), unit % self.rows.len());
            let rows = &self.rows[row];
            let from = self.input.tap(block, rows.start, 0, 0);
            if self.of == Of::Maxima && self.overlap_by_one() {
                // SAFETY: the caller's.
                unsafe { self.overlapping::<V>(from, rows.len(), self.out.pixel(block, row, 0)) };
                continue;
            }
            for (x, columns) in self.columns.iter().enumerate() {
                // SAFETY: the caller's.
                unsafe {
                    let from = from.add(columns.start * LANES);
                    let mut value =
                        if self.of == Of::Means { V::splat(0.0) } else { V::load(from) };
                    for y in 0..rows.len() {
                        for x in 0..columns.len() {
                            let pixel = V::load(from.add(y * row_pitch + x * LANES));
                            value = match self.of {
                                Of::Maxima => value.max(pixel),
                                Of::Means => value.add(pixel),
                            };
                        }
                    }
                    if self.of == Of::Means {
                        let pixels = (rows.len() * columns.len()) as f32;
                        value = value.mul(V::splat(1.0 / pixels));
                    }
                    value.store(self.out.pixel(block, row, x));
                }
            }
        }
    }
}

impl Windows<'_> {
    /// Whether every window begins at the last column of the one before it, and has at most two
    /// more.
    fn overlap_by_one(&self) -> bool {
        let is_next =
            |pair: &[Range<usize>]| pair[0].end == pair[1].start + 1 && pair[1].len() <= 3;
        self.columns.windows(2).all(is_next)
            && self.columns.first().is_some_and(|columns| columns.len() <= 3)
    }

    /// Maxima of a row of such windows: columns that two of them share are looked through once.
    ///
    /// # Safety
    /// That of [`Kernel::run`]; the first column of the `rows` is at `from`, the output at `to`.
    #[inline(always)]
    unsafe fn overlapping<V: Lanes>(&self, from: *const f32, rows: usize, to: *mut f32) {
        let row_pitch = self.input.row_pitch;
        // SAFETY: the caller's.
        unsafe {
            let column = |x: usize| {
                let from = from.add(x * LANES);
                match rows {
                    3 => {
                        let last = V::load(from.add(2 * row_pitch));
                        V::load(from).max(V::load(from.add(row_pitch))).max(last)
                    }
                    rows => (1..rows)
                        .fold(V::load(from), |most, y| most.max(V::load(from.add(y * row_pitch)))),
                }
            };
            let mut shared = column(self.columns[0].start);
            for (x, columns) in self.columns.iter().enumerate() {
                let mut last = shared;
                for x in columns.start + 1..columns.end {
                    shared = shared.max(last);
                    last = column(x);
                }
                shared.max(last).store(to.add(x * LANES));
                shared = last;
            }
        }
    }
}

//! Max-pooling and adaptive average pooling.

use std::ops::Range;

use super::ThreadPool;
use super::image::Image;
use super::views::{F32Dst, F32Src};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Max-pooling with square windows. Padding is excluded from the maximum, as in PyTorch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MaxPool {
    /// Height and width of a window.
    pub window: usize,
    /// Stride.
    pub stride: usize,
    /// Padding on each side; less than the window.
    pub padding: usize,
}

impl MaxPool {
    /// Height (or width) of the output for an input of `pixels` rows (or columns).
    pub fn output(&self, pixels: usize) -> usize {
        let room = (pixels + 2 * self.padding).checked_sub(self.window);
        room.map_or(0, |room| room / self.stride + 1)
    }

    /// Rows and columns of every window on an image of `size`: height and width.
    ///
    /// # Panics
    /// If a window lies wholly in the padding.
    pub(super) fn windows(&self, size: [usize; 2]) -> [Vec<Range<usize>>; 2] {
        assert!(self.padding < self.window && self.stride > 0, "windows that overlap the image");
        size.map(|side| (0..self.output(side)).map(|k| self.window_of(k, side)).collect())
    }

    /// Rows (or columns) of the image, which has `side`, in window `k`.
    pub(super) fn window_of(&self, k: usize, side: usize) -> Range<usize> {
        let from = (k * self.stride).saturating_sub(self.padding);
        from..(k * self.stride + self.window - self.padding).min(side)
    }

    /// Writes the pooled `input` to `output`.
    ///
    /// # Panics
    /// If the output has another size, or a window lies wholly in the padding.
    pub fn run(&self, thread_pool: &ThreadPool, level: Level, input: &Image, output: &mut Image) {
        let [rows, columns] = self.windows([input.height(), input.width()]);
        let size = [rows.len(), columns.len()];
        assert_eq!([output.height(), output.width()], size, "size of the output");
        pool(thread_pool, level, input, [&rows, &columns], Reduction::Max, output);
    }
}

/// Max-pools `blocks` channel blocks over the given rows of windows, from row 0 of `dst` on.
///
/// # Safety
/// Windows are readable, the rows writable, and the level is one of this processor's.
pub(super) unsafe fn max_pool_rows(
    level: Level,
    input: F32Src,
    [rows, columns]: [&[Range<usize>]; 2],
    dst: F32Dst,
    blocks: usize,
) {
    let units = 0..blocks * rows.len();
    let kernel = PoolRows { input, rows, columns, reduction: Reduction::Max, dst, units };
    // SAFETY: the caller's.
    unsafe { level.run(&kernel) };
}

/// Adaptive average pooling: each pixel of `output` is the mean of its window, and the windows
/// cover `input` evenly (PyTorch's `adaptive_avg_pool2d`). With an output of one pixel, global
/// average pooling.
///
/// # Panics
/// If the output has other channels, or either has no pixels.
pub fn adaptive_avg_pool(
    thread_pool: &ThreadPool,
    level: Level,
    input: &Image,
    output: &mut Image,
) {
    let windows = |outputs: usize, inputs: usize| -> Vec<Range<usize>> {
        (0..outputs).map(|k| k * inputs / outputs..((k + 1) * inputs).div_ceil(outputs)).collect()
    };
    let rows = windows(output.height(), input.height());
    let columns = windows(output.width(), input.width());
    pool(thread_pool, level, input, [&rows, &columns], Reduction::Mean, output);
}

/// Reduction over a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reduction {
    Max,
    Mean,
}

fn pool(
    thread_pool: &ThreadPool,
    level: Level,
    input: &Image,
    [rows, columns]: [&[Range<usize>]; 2],
    reduction: Reduction,
    output: &mut Image,
) {
    assert_eq!(input.channels(), output.channels(), "channels");
    assert!(rows.iter().chain(columns).all(|window| !window.is_empty()), "windows with pixels");
    let units = output.blocks() * rows.len();
    let dst = output.dst();
    thread_pool.run(&|part| {
        let input = input.src();
        let kernel = PoolRows { input, rows, columns, reduction, dst, units: part.chunk(units) };
        // SAFETY: windows are inside the input, outputs of the parts are disjoint, and the level is
        // one of this processor's.
        unsafe { level.run(&kernel) };
    });
}

/// Kernel over a range of rows of windows, counted over all channel blocks.
struct PoolRows<'a> {
    input: F32Src,
    rows: &'a [Range<usize>],
    columns: &'a [Range<usize>],
    reduction: Reduction,
    dst: F32Dst,
    units: Range<usize>,
}

impl Kernel for PoolRows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let row_pitch = self.input.row_pitch;
        for unit in self.units.clone() {
            let (block, row) = (unit / self.rows.len(), unit % self.rows.len());
            let rows = &self.rows[row];
            let from = self.input.tap(block, rows.start, 0, 0);
            if self.reduction == Reduction::Max && self.overlap_by_one() {
                // SAFETY: the caller's.
                unsafe { self.overlapping::<V>(from, rows.len(), self.dst.pixel(block, row, 0)) };
                continue;
            }
            for (x, columns) in self.columns.iter().enumerate() {
                // SAFETY: the caller's.
                unsafe {
                    let from = from.add(columns.start * LANES);
                    let mut value = if self.reduction == Reduction::Mean {
                        V::splat(0.0)
                    } else {
                        V::load(from)
                    };
                    for y in 0..rows.len() {
                        for x in 0..columns.len() {
                            let pixel = V::load(from.add(y * row_pitch + x * LANES));
                            value = match self.reduction {
                                Reduction::Max => value.max(pixel),
                                Reduction::Mean => value.add(pixel),
                            };
                        }
                    }
                    if self.reduction == Reduction::Mean {
                        let pixels = (rows.len() * columns.len()) as f32;
                        value = value.mul(V::splat(1.0 / pixels));
                    }
                    value.store(self.dst.pixel(block, row, x));
                }
            }
        }
    }
}

impl PoolRows<'_> {
    /// Whether every window starts at the last column of the one before it and has at most three
    /// columns, as windows of 3 with stride 2 do.
    fn overlap_by_one(&self) -> bool {
        let is_next =
            |pair: &[Range<usize>]| pair[0].end == pair[1].start + 1 && pair[1].len() <= 3;
        self.columns.windows(2).all(is_next)
            && self.columns.first().is_some_and(|columns| columns.len() <= 3)
    }

    /// Max-pools a row of such windows; the maximum of a column that two of them share is computed
    /// once.
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
                    // The usual window, without a loop.
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
                // The next window begins with this column.
                shared = last;
            }
        }
    }
}

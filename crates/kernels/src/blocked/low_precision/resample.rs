//! Max-pooling and bilinear upsampling within one element type.
//!
//! Both commute with the affine map of quantisation, so input and output share its parameters.

use std::ops::Range;

use super::image::{LowPrecisionImage, LowPrecisionType};
use crate::blocked::ThreadPool;
use crate::blocked::pool::MaxPool;
use crate::blocked::upsample::{FAR_WEIGHT, NEAR_WEIGHT, far_index};
use crate::simd::dots::{Bf16, DotProduct, ReducedPrecision};
use crate::simd::{LANES, Lanes, Level, ReducedDispatch as _, ReducedKernel};

/// Writes the max-pooled `input` to `output`.
///
/// # Panics
/// If the output has another size or element type, or a window lies wholly in the padding.
pub fn max_pool_low_precision(
    thread_pool: &ThreadPool,
    level: Level,
    pool: MaxPool,
    input: &LowPrecisionImage,
    output: &mut LowPrecisionImage,
) {
    let [channels, height, width] = input.size();
    let [rows, columns] = pool.windows([height, width]);
    assert_eq!(output.size(), [channels, rows.len(), columns.len()], "size of the output");
    resample(
        thread_pool,
        level,
        input,
        output,
        ResampleOp::MaxPool { rows: &rows, columns: &columns },
    );
}

/// Writes `input` to `output`, which has twice as many rows and columns, as
/// [`upsample`](crate::blocked::upsample) does.
///
/// # Panics
/// If the output has another size or element type.
pub fn upsample_low_precision(
    thread_pool: &ThreadPool,
    level: Level,
    input: &LowPrecisionImage,
    output: &mut LowPrecisionImage,
) {
    let [channels, height, width] = input.size();
    assert_eq!(output.size(), [channels, 2 * height, 2 * width], "size of the output");
    resample(thread_pool, level, input, output, ResampleOp::Upsample);
}

/// Operator of a resampling kernel.
#[derive(Clone, Copy)]
enum ResampleOp<'a> {
    MaxPool { rows: &'a [Range<usize>], columns: &'a [Range<usize>] },
    Upsample,
}

fn resample(
    thread_pool: &ThreadPool,
    level: Level,
    input: &LowPrecisionImage,
    output: &mut LowPrecisionImage,
    op: ResampleOp<'_>,
) {
    assert_eq!(input.element_type(), output.element_type(), "images of one element type");
    let [channels, rows_per_block, _] = output.size();
    let (row_pitch, block_pitch) = (output.row_pitch() * LANES, output.block_pitch() * LANES);
    let to = DstPixels(output.first_mut());
    let rows = channels.div_ceil(LANES) * rows_per_block;
    thread_pool.run(&|part| {
        let kernel = ResampleRows {
            input,
            op,
            to,
            row_pitch,
            block_pitch,
            rows_per_block,
            rows: part.chunk(rows),
        };
        // SAFETY: sizes were compared, windows are inside the input, rows of the parts are
        // disjoint, and the level is one of this processor's.
        unsafe {
            match input.element_type() {
                LowPrecisionType::Bf16 => Bf16::run(level, &kernel),
                LowPrecisionType::Uint8(_) => u8::run(level, &kernel),
            }
        }
    });
}

/// Pointer to the first pixel of an output.
#[derive(Clone, Copy)]
struct DstPixels(*mut u8);

// SAFETY: each part of a parallel region writes its own pixels through it.
unsafe impl Send for DstPixels {}
// SAFETY: as above.
unsafe impl Sync for DstPixels {}

/// Kernel over a range of output rows, counted over all channel blocks.
struct ResampleRows<'a> {
    input: &'a LowPrecisionImage,
    op: ResampleOp<'a>,
    to: DstPixels,
    /// Distances from row to row and from channel block to channel block of the output, in elements.
    row_pitch: usize,
    block_pitch: usize,
    rows_per_block: usize,
    rows: Range<usize>,
}

impl<S: ReducedPrecision> ReducedKernel<S> for ResampleRows<'_> {
    #[inline(always)]
    unsafe fn run<D: DotProduct<Element = S>>(&self) {
        for row in self.rows.clone() {
            let (block, y) = (row / self.rows_per_block, row % self.rows_per_block);
            let at = block * self.block_pitch + y * self.row_pitch;
            let to = self.to.0.cast::<S>().wrapping_add(at);
            // SAFETY: the caller's.
            unsafe {
                match self.op {
                    ResampleOp::MaxPool { rows, columns } => {
                        self.max_pool_row::<S, D::Lanes>(block, &rows[y], columns, to);
                    }
                    ResampleOp::Upsample => self.upsample_row::<S, D::Lanes>(block, y, to),
                }
            }
        }
    }
}

impl ResampleRows<'_> {
    /// Max-pools a row.
    ///
    /// # Safety
    /// That of [`ReducedKernel::run`]; windows are inside the input, and `to` is a row of the
    /// output.
    #[inline(always)]
    unsafe fn max_pool_row<S: ReducedPrecision, V: Lanes>(
        &self,
        block: usize,
        rows: &Range<usize>,
        columns: &[Range<usize>],
        to: *mut S,
    ) {
        let row_pitch = self.input.row_pitch() * LANES;
        let from: *const S = self.input.tap(block, rows.start, 0, 0);
        for (x, columns) in columns.iter().enumerate() {
            // SAFETY: the caller's.
            unsafe {
                let from = from.add(columns.start * LANES);
                // From a pixel of the window, since padding must not win.
                let mut value: V = S::load(from);
                for y in 0..rows.len() {
                    for x in 0..columns.len() {
                        value = value.max(S::load(from.add(y * row_pitch + x * LANES)));
                    }
                }
                S::store(value, to.add(x * LANES));
            }
        }
    }

    /// Upsamples to a row, as [`upsample`](crate::blocked::upsample) does.
    ///
    /// # Safety
    /// That of [`ReducedKernel::run`]; `to` is row `y` of the output.
    #[inline(always)]
    unsafe fn upsample_row<S: ReducedPrecision, V: Lanes>(
        &self,
        block: usize,
        y: usize,
        to: *mut S,
    ) {
        let [_, height, width] = self.input.size();
        let near: *const S = self.input.tap(block, y / 2, 0, 0);
        let far: *const S = self.input.tap(block, far_index(y, height), 0, 0);
        // SAFETY: the caller's; columns are those of the input.
        unsafe {
            let [of_near, of_far] = [V::splat(NEAR_WEIGHT), V::splat(FAR_WEIGHT)];
            // A column of both rows is mixed once and contributes to four outputs.
            let column = |x: usize| {
                let most = S::load::<V>(near.add(x * LANES)).mul(of_near);
                S::load::<V>(far.add(x * LANES)).mul_add(of_far, most)
            };
            let mut here = column(0);
            let mut before = here;
            for x in 0..width {
                // Behind the border the last column goes on.
                let after = column((x + 1).min(width - 1));
                let most = here.mul(of_near);
                S::store(before.mul_add(of_far, most), to.add(2 * x * LANES));
                S::store(after.mul_add(of_far, most), to.add((2 * x + 1) * LANES));
                (before, here) = (here, after);
            }
        }
    }
}

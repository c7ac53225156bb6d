//! Maxima of windows, and twice as many rows and columns, of images of fewer bits. Output and input
//! are kept alike, so that neither depends on what numbers stand for.

use std::ops::Range;

use super::image::{Packed, Storage};
use crate::blocked::pool::MaxPool;
use crate::blocked::thread_pool::ThreadPool;
use crate::blocked::upsample::{FAR, NEAR, farther};
use crate::simd::dots::{Bf16, Dots, Stored};
use crate::simd::{LANES, Lanes, Level, Packed as _, PackedKernel};

/// Writes the maxima of windows of `input` to `output`.
///
/// # Panics
/// If the output has another size or is kept otherwise, or a window lies outside altogether.
pub fn max_pool_packed(
    thread_pool: &ThreadPool,
    level: Level,
    pool: MaxPool,
    input: &Packed,
    output: &mut Packed,
) {
    let [channels, height, width] = input.size();
    let [rows, columns] = pool.windows([height, width]);
    assert_eq!(output.size(), [channels, rows.len(), columns.len()], "size of the output");
    run(thread_pool, level, input, output, Of::Maxima { rows: &rows, columns: &columns });
}

/// Writes `input` to `output`, which has twice as many rows and columns, as
/// [`upsample`](crate::blocked::upsample) does.
///
/// # Panics
/// If the output has another size or is kept otherwise.
pub fn upsample_packed(
    thread_pool: &ThreadPool,
    level: Level,
    input: &Packed,
    output: &mut Packed,
) {
    let [channels, height, width] = input.size();
    assert_eq!(output.size(), [channels, 2 * height, 2 * width], "size of the output");
    run(thread_pool, level, input, output, Of::Between);
}

/// What becomes of an image.
#[derive(Clone, Copy)]
enum Of<'a> {
    Maxima { rows: &'a [Range<usize>], columns: &'a [Range<usize>] },
    Between,
}

fn run(thread_pool: &ThreadPool, level: Level, input: &Packed, output: &mut Packed, of: Of<'_>) {
    assert_eq!(input.storage(), output.storage(), "images that are kept alike");
    let [channels, rows, _] = output.size();
    let (row_pitch, block_pitch) = (output.row_pitch() * LANES, output.block_pitch() * LANES);
    let to = Pixels(output.first_mut());
    let units = channels.div_ceil(LANES) * rows;
    thread_pool.run(&|part| {
        let work = Rows { input, of, to, row_pitch, block_pitch, rows, units: part.chunk(units) };
        // SAFETY: sizes were compared, windows are inside the input, rows of the parts are
        // disjoint, and the level is one of this processor's.
        unsafe {
            match input.storage() {
                Storage::Bf16 => Bf16::run(level, &work),
                Storage::Byte(_) => u8::run(level, &work),
            }
        }
    });
}

/// The first pixel of an output.
#[derive(Clone, Copy)]
struct Pixels(*mut u8);

// SAFETY: each part of a parallel region writes its own pixels through it.
unsafe impl Send for Pixels {}
// SAFETY: as above.
unsafe impl Sync for Pixels {}

/// Some rows of the output, block after block.
struct Rows<'a> {
    input: &'a Packed,
    of: Of<'a>,
    to: Pixels,
    /// Numbers from a row of the output to the next, and from a block to the next.
    row_pitch: usize,
    block_pitch: usize,
    /// Of a block.
    rows: usize,
    units: Range<usize>,
}

impl<S: Stored> PackedKernel<S> for Rows<'_> {
    #[inline(always)]
    unsafe fn run<D: Dots<Stored = S>>(&self) {
        for unit in self.units.clone() {
            let (block, y) = (unit / self.rows, unit % self.rows);
            let at = block * self.block_pitch + y * self.row_pitch;
            let to = self.to.0.cast::<S>().wrapping_add(at);
            // SAFETY: the caller's.
            unsafe {
                match self.of {
                    Of::Maxima { rows, columns } => {
                        self.maxima::<S, D::Lanes>(block, &rows[y], columns, to);
                    }
                    Of::Between => self.between::<S, D::Lanes>(block, y, to),
                }
            }
        }
    }
}

impl Rows<'_> {
    /// # Safety
    /// That of [`PackedKernel::run`]; windows are inside the input, and `to` is a row of the
    /// output.
    #[inline(always)]
    unsafe fn maxima<S: Stored, V: Lanes>(
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

    /// # Safety
    /// That of [`PackedKernel::run`]; `to` is row `y` of the output.
    #[inline(always)]
    unsafe fn between<S: Stored, V: Lanes>(&self, block: usize, y: usize, to: *mut S) {
        let [_, height, width] = self.input.size();
        let near: *const S = self.input.tap(block, y / 2, 0, 0);
        let far: *const S = self.input.tap(block, farther(y, height), 0, 0);
        // SAFETY: the caller's; columns are those of the input.
        unsafe {
            let [of_near, of_far] = [V::splat(NEAR), V::splat(FAR)];
            let column = |x: usize| {
                let most = S::load::<V>(near.add(x * LANES)).mul(of_near);
                S::load::<V>(far.add(x * LANES)).mul_add(of_far, most)
            };
            let mut here = column(0);
            let mut before = here;
            for x in 0..width {
                let after = column((x + 1).min(width - 1));
                let most = here.mul(of_near);
                S::store(before.mul_add(of_far, most), to.add(2 * x * LANES));
                S::store(after.mul_add(of_far, most), to.add((2 * x + 1) * LANES));
                (before, here) = (here, after);
            }
        }
    }
}

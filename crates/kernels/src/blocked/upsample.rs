//! Twice as many rows and columns.

use std::ops::Range;

use super::conv::Output;
use super::image::Image;
use super::thread_pool::ThreadPool;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// What the nearer and the farther pixel count.
pub(super) const NEAR: f32 = 0.75;
pub(super) const FAR: f32 = 0.25;

/// Writes `input` to `output`, which has twice as many rows and columns.
///
/// # Model
/// Bilinear, pixels being squares about their centres: row `y` of the output lies at `(y + 0.5) / 2
/// - 0.5` of the input, a quarter of a pixel from the row `y / 2`, on the side of the one above for
/// even `y` and of the one below for odd. Beyond the outermost centres the values stay. So do
/// columns.
///
/// # Panics
/// If the output has another size.
pub fn upsample(thread_pool: &ThreadPool, level: Level, input: &Image, output: &mut Image) {
    assert_eq!(input.channels(), output.channels(), "channels");
    let size = [input.height(), input.width()].map(|side| 2 * side);
    assert_eq!([output.height(), output.width()], size, "size of the output");
    let rows = output.height();
    let units = output.blocks() * rows;
    let out = Output::of(output);
    thread_pool.run(&|part| {
        let work = Rows { input, out, rows, units: part.chunk(units) };
        // SAFETY: sizes were compared above, rows of the parts are disjoint, and the level is one
        // of this processor's.
        unsafe { level.run(&work) };
    });
}

/// The row or column that comes after `pixel / 2` in nearness to `pixel` of the output, of `count`.
pub(super) fn farther(pixel: usize, count: usize) -> usize {
    if pixel % 2 == 1 { (pixel / 2 + 1).min(count - 1) } else { (pixel / 2).saturating_sub(1) }
}

/// Some rows of the output, block after block.
struct Rows<'a> {
    input: &'a Image,
    out: Output,
    /// Of a block.
    rows: usize,
    units: Range<usize>,
}

impl Kernel for Rows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let (height, width) = (self.input.height(), self.input.width());
        for unit in self.units.clone() {
            let (block, y) = (unit / self.rows, unit % self.rows);
            let near = self.input.tap(block, y / 2, 0, 0);
            let far = self.input.tap(block, farther(y, height), 0, 0);
            // SAFETY: the caller's; columns are those of the input.
            unsafe {
                let to = self.out.pixel(block, y, 0);
                let column = |x: usize| between::<V>(near.add(x * LANES), far.add(x * LANES));
                let mut here = column(0);
                let mut before = here;
                for x in 0..width {
                    let after = column((x + 1).min(width - 1));
                    let most = here.mul(V::splat(NEAR));
                    let left = before.mul_add(V::splat(FAR), most);
                    let right = after.mul_add(V::splat(FAR), most);
                    left.store(to.add(2 * x * LANES));
                    right.store(to.add((2 * x + 1) * LANES));
                    (before, here) = (here, after);
                }
            }
        }
    }
}

/// What lies between two rows.
///
/// # Safety
/// That of [`Lanes`].
#[inline(always)]
unsafe fn between<V: Lanes>(near: *const f32, far: *const f32) -> V {
    // SAFETY: the caller's.
    unsafe {
        let most = V::load(near).mul(V::splat(NEAR));
        V::load(far).mul_add(V::splat(FAR), most)
    }
}

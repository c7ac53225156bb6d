//! Bilinear upsampling by 2.

use std::ops::Range;

use super::ThreadPool;
use super::image::Image;
use super::views::F32Dst;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Bilinear weight of the nearer row or column.
pub(super) const NEAR_WEIGHT: f32 = 0.75;
/// Bilinear weight of the farther row or column.
pub(super) const FAR_WEIGHT: f32 = 0.25;

/// Writes `input`, upsampled bilinearly to twice its height and width, to `output`.
///
/// # Model
/// PyTorch's `interpolate(mode="bilinear", align_corners=False)`, ONNX's `half_pixel`: output row
/// `y` has its centre at `(y + 0.5) / 2 - 0.5` of the input, a quarter of a pixel from row `y / 2`,
/// towards the row above for even `y` and the row below for odd. Edges are replicated. Columns
/// likewise.
///
/// # Panics
/// If the output has another size.
pub fn upsample(thread_pool: &ThreadPool, level: Level, input: &Image, output: &mut Image) {
    assert_eq!(input.channels(), output.channels(), "channels");
    let size = [input.height(), input.width()].map(|side| 2 * side);
    assert_eq!([output.height(), output.width()], size, "size of the output");
    let rows_per_block = output.height();
    let rows = output.blocks() * rows_per_block;
    let dst = output.dst();
    thread_pool.run(&|part| {
        let kernel = UpsampleRows { input, dst, rows_per_block, rows: part.chunk(rows) };
        // SAFETY: sizes were compared above, rows of the parts are disjoint, and the level is one
        // of this processor's.
        unsafe { level.run(&kernel) };
    });
}

/// Index of the farther of the two input rows (or columns) that output row `pixel` interpolates;
/// the nearer is `pixel / 2`. The input has `count` rows.
pub(super) fn far_index(pixel: usize, count: usize) -> usize {
    if pixel % 2 == 1 { (pixel / 2 + 1).min(count - 1) } else { (pixel / 2).saturating_sub(1) }
}

/// Kernel over a range of output rows, counted over all channel blocks.
struct UpsampleRows<'a> {
    input: &'a Image,
    dst: F32Dst,
    rows_per_block: usize,
    rows: Range<usize>,
}

impl Kernel for UpsampleRows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let (height, width) = (self.input.height(), self.input.width());
        for row in self.rows.clone() {
            let (block, y) = (row / self.rows_per_block, row % self.rows_per_block);
            // An output row lies between two input rows, a quarter from the near one.
            let near = self.input.tap(block, y / 2, 0, 0);
            let far = self.input.tap(block, far_index(y, height), 0, 0);
            // SAFETY: the caller's; columns are those of the input.
            unsafe {
                let to = self.dst.pixel(block, y, 0);
                let column = |x: usize| interpolated::<V>(near.add(x * LANES), far.add(x * LANES));
                // Each input column contributes to four output columns: the last three are kept.
                let mut here = column(0);
                let mut before = here;
                for x in 0..width {
                    let after = column((x + 1).min(width - 1));
                    let most = here.mul(V::splat(NEAR_WEIGHT));
                    let left = before.mul_add(V::splat(FAR_WEIGHT), most);
                    let right = after.mul_add(V::splat(FAR_WEIGHT), most);
                    left.store(to.add(2 * x * LANES));
                    right.store(to.add((2 * x + 1) * LANES));
                    (before, here) = (here, after);
                }
            }
        }
    }
}

/// Interpolates between two rows at one column.
///
/// # Safety
/// That of [`Lanes`].
#[inline(always)]
unsafe fn interpolated<V: Lanes>(near: *const f32, far: *const f32) -> V {
    // SAFETY: the caller's.
    unsafe {
        let most = V::load(near).mul(V::splat(NEAR_WEIGHT));
        V::load(far).mul_add(V::splat(FAR_WEIGHT), most)
    }
}

//! Sums of images of any element types, and conversions between element types.

use std::ops::Range;

use super::view::{DstView, SrcView, TensorView, TensorViewMut};
use crate::blocked::ThreadPool;
use crate::blocked::tile::{Activation, activated};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Writes `activation(a + b)` to `output`, computed in f32; without `b`, `activation(a)`. Images
/// may have different element types: without `b` and activation this is a conversion.
///
/// # Panics
/// If sizes differ.
pub fn add_mixed_precision(
    thread_pool: &ThreadPool,
    level: Level,
    a: TensorView<'_>,
    b: Option<TensorView<'_>>,
    activation: Activation,
    mut output: TensorViewMut<'_>,
) {
    let size = output.size();
    assert_eq!(a.size(), size, "images of one size");
    assert!(b.is_none_or(|b| b.size() == size), "images of one size");
    let [channels, rows_per_block, width] = size;
    // One list of the rows of all blocks, so that few channels are shared evenly, too.
    let rows = channels.div_ceil(LANES) * rows_per_block;
    let (a, b, dst) = (a.src(), b.map(|b| b.src()), output.dst());
    thread_pool.run(&|part| {
        let rows = part.chunk(rows);
        let kernel = AddRows { a, b, activation, dst, rows_per_block, width, rows };
        // SAFETY: images are of one size, rows of the parts are disjoint, and the level is one of
        // this processor's.
        unsafe { level.run(&kernel) };
    });
}

/// Kernel over a range of rows, counted over all channel blocks.
struct AddRows {
    a: SrcView,
    b: Option<SrcView>,
    activation: Activation,
    dst: DstView,
    rows_per_block: usize,
    width: usize,
    rows: Range<usize>,
}

impl Kernel for AddRows {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        for row in self.rows.clone() {
            let (block, y) = (row / self.rows_per_block, row % self.rows_per_block);
            let (a, to) = (self.a.row_offset(block, y), self.dst.row_offset(block, y));
            let b = self.b.map(|b| (b, b.row_offset(block, y)));
            for x in (0..self.width).map(|x| x * LANES) {
                // SAFETY: the caller's.
                unsafe {
                    let mut sum: V = self.a.load(a + x);
                    if let Some((b, at)) = b {
                        sum = sum.add(b.load(at + x));
                    }
                    self.dst.store(activated(sum, self.activation), to + x);
                }
            }
        }
    }
}

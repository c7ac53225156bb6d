//! Layout conversions between nchw and nChw16c (oneDNN's reorders).

use std::ops::Range;

use super::view::{DstView, TensorViewMut};
use crate::blocked::ThreadPool;
use crate::blocked::image::Image;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Writes `scale * values + shift` of `values`, `[channels][height][width]`, to an image of any
/// element type; `affine` is `[scale, shift]`.
///
/// # Panics
/// If `values` has another length.
pub fn reorder_from_nchw(
    thread_pool: &ThreadPool,
    level: Level,
    values: &[f32],
    affine: [f32; 2],
    mut output: TensorViewMut<'_>,
) {
    let size = output.size();
    let [channels, rows_per_block, _] = size;
    assert_eq!(values.len(), size.iter().product(), "values of this size");
    let rows = channels.div_ceil(LANES) * rows_per_block;
    let dst = output.dst();
    thread_pool.run(&|part| {
        let kernel = ReorderRows { values, affine, size, dst, rows: part.chunk(rows) };
        // SAFETY: sizes were compared, rows of the parts are disjoint, and the level is one of this
        // processor's.
        unsafe { level.run(&kernel) };
    });
}

/// Copies an image to `values`, `[channels][height][width]`.
///
/// # Panics
/// If `values` has another length.
pub fn reorder_to_nchw(thread_pool: &ThreadPool, image: &Image, values: &mut [f32]) {
    let (channels, pixels) = (image.channels(), image.height() * image.width());
    assert_eq!(values.len(), channels * pixels, "values of this size");
    let dst = NchwDst(values.as_mut_ptr());
    thread_pool.run(&|part| {
        for channel in part.chunk(channels) {
            // SAFETY: channels of the parts are disjoint and inside.
            let channel_values = unsafe { dst.values(channel * pixels, pixels) };
            image.copy_channel_to(channel, channel_values);
        }
    });
}

/// Destination of an image in nchw.
struct NchwDst(*mut f32);

// SAFETY: each part of a parallel region writes its own channels.
unsafe impl Sync for NchwDst {}

impl NchwDst {
    /// `count` values from `first` on.
    ///
    /// # Safety
    /// They are inside, and nobody else has a reference to them.
    #[allow(clippy::mut_from_ref, reason = "parts write channels of their own")]
    unsafe fn values(&self, first: usize, count: usize) -> &mut [f32] {
        // SAFETY: the caller's.
        unsafe { std::slice::from_raw_parts_mut(self.0.add(first), count) }
    }
}

/// Kernel that reorders a range of rows to nChw16c, counted over all channel blocks.
struct ReorderRows<'a> {
    values: &'a [f32],
    /// Scale and shift.
    affine: [f32; 2],
    /// Channels, height and width.
    size: [usize; 3],
    dst: DstView,
    rows: Range<usize>,
}

impl Kernel for ReorderRows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let [channels, height, width] = self.size;
        let [scale, shift] = self.affine;
        for unit in self.rows.clone() {
            let (block, y) = (unit / height, unit % height);
            let channels_of_block = LANES.min(channels - block * LANES);
            let row = |lane: usize| {
                let channel = block * LANES + lane;
                &self.values[(channel * height + y) * width..][..width]
            };
            let to = self.dst.row_offset(block, y);
            // Only the channels that exist: the padding of the last block stays zero.
            for lane in 0..channels_of_block {
                for (first, values) in row(lane).chunks(LANES).enumerate() {
                    // SAFETY: the caller's.
                    unsafe {
                        // A whole load would read beyond the row.
                        let value = if values.len() == LANES {
                            V::load(values.as_ptr())
                        } else {
                            let mut last = [0.0; LANES];
                            last[..values.len()].copy_from_slice(values);
                            V::load(last.as_ptr())
                        };
                        let value = value.mul_add(V::splat(scale), V::splat(shift));
                        let at = to + first * LANES * LANES + lane;
                        self.dst.scatter(value, at, values.len());
                    }
                }
            }
        }
    }
}

//! Images in the plain layout nchw, as networks get them.
//!
//! In nChw16c an image of two channels takes eight times the memory, seven eighths of it padding.

use std::ops::Range;

use super::ThreadPool;
use super::views::{F32Dst, F32Src};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// An f32 image `[channels][height][width]` (nchw, batch 1) with a zero border around every
/// channel.
#[derive(Debug, Clone)]
pub struct NchwImage {
    size: [usize; 3],
    border: usize,
    values: Vec<f32>,
}

impl NchwImage {
    /// A zero image of `size`: channels, height and width.
    pub fn zeros(size: [usize; 3], border: usize) -> Self {
        let mut image = Self { size, border, values: Vec::new() };
        // A vector load at the last pixel reads up to LANES - 1 values past it.
        image.values = vec![0.0; size[0] * image.channel_pitch() + LANES];
        image
    }

    /// Channels, height and width.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Zero pixels on each side.
    pub fn border(&self) -> usize {
        self.border
    }

    /// Memory of the image in bytes, its border included.
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    /// Fills the image with `scale * values + shift` of `values`, `[channels][height][width]`.
    ///
    /// # Panics
    /// If `values` has another length.
    pub fn copy_from(
        &mut self,
        thread_pool: &ThreadPool,
        level: Level,
        values: &[f32],
        affine: [f32; 2],
    ) {
        let [channels, height, _] = self.size;
        assert_eq!(values.len(), self.size.iter().product(), "planes of this size");
        let (row_pitch, block_pitch) = (self.row_pitch(), self.channel_pitch());
        let first = self.row_start(0, 0);
        let pixels = self.values[first..].as_mut_ptr();
        let dst = F32Dst { pixels, row_pitch, block_pitch, width: self.size[2] };
        thread_pool.run(&|part| {
            let rows = part.chunk(channels * height);
            let kernel = CopyRows { values, affine, height, dst, rows };
            // SAFETY: sizes were compared, rows of the parts are disjoint, and the level is one of
            // this processor's.
            unsafe { level.run(&kernel) };
        });
    }

    /// Minimum and maximum of the values.
    pub fn min_max(&self) -> [f32; 2] {
        let [channels, height, width] = self.size;
        let rows = (0..channels * height).map(|row| self.row_start(row / height, row % height));
        let values = rows.flat_map(|first| &self.values[first..first + width]);
        values.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], value| {
            [low.min(*value), high.max(*value)]
        })
    }

    /// Source view.
    pub(super) fn src(&self) -> F32Src {
        F32Src {
            pixels: self.values[self.row_start(0, 0)..].as_ptr(),
            row_pitch: self.row_pitch(),
            block_pitch: self.channel_pitch(),
            is_nchw: true,
        }
    }

    /// All values, the border included.
    #[inline]
    pub(super) fn values(&self) -> &[f32] {
        &self.values
    }

    /// Values from a row to the next.
    #[inline]
    pub(super) fn row_pitch(&self) -> usize {
        self.size[2] + 2 * self.border
    }

    /// Values from a channel to the next.
    #[inline]
    fn channel_pitch(&self) -> usize {
        (self.size[1] + 2 * self.border) * self.row_pitch()
    }

    /// Index of the first pixel of a row.
    #[inline]
    pub(super) fn row_start(&self, channel: usize, y: usize) -> usize {
        channel * self.channel_pitch() + (y + self.border) * self.row_pitch() + self.border
    }
}

/// Kernel that copies a range of rows, counted over all channels.
struct CopyRows<'a> {
    values: &'a [f32],
    /// Scale and shift.
    affine: [f32; 2],
    height: usize,
    dst: F32Dst,
    rows: Range<usize>,
}

impl Kernel for CopyRows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let width = self.dst.width;
        for unit in self.rows.clone() {
            let at =
                unit / self.height * self.dst.block_pitch + unit % self.height * self.dst.row_pitch;
            let row = &self.values[unit * width..][..width];
            // SAFETY: the caller's; the row is inside both.
            unsafe {
                let [scale, shift] = self.affine.map(|value| V::splat(value));
                for (first, values) in row.chunks(LANES).enumerate() {
                    let to = self.dst.pixels.add(at + first * LANES);
                    if values.len() == LANES {
                        V::load(values.as_ptr()).mul_add(scale, shift).store(to);
                    } else {
                        // A whole store would overwrite the border.
                        let mut last = [0.0; LANES];
                        last[..values.len()].copy_from_slice(values);
                        let last = V::load(last.as_ptr()).mul_add(scale, shift).to_array();
                        to.copy_from(last.as_ptr(), values.len());
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minimum_and_maximum_are_those_of_the_values() {
        let mut image = NchwImage::zeros([2, 3, 5], 1);
        let values: Vec<f32> = (1..=30).map(|value| value as f32).collect();
        image.copy_from(&ThreadPool::new(1), Level::best(), &values, [1.0, 0.0]);
        assert_eq!(image.min_max(), [1.0, 30.0]);
    }
}

//! What the world brings, channel by channel, as an image in blocks of channels, and back.

use std::ops::Range;

use super::held::{HeldMut, To};
use crate::blocked::image::Image;
use crate::blocked::thread_pool::ThreadPool;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Writes `factor * planes + offset` of `[channels][height][width]` to an image.
///
/// # Panics
/// If there are more or fewer values.
pub fn read_planes(
    thread_pool: &ThreadPool,
    level: Level,
    planes: &[f32],
    by: [f32; 2],
    mut output: HeldMut<'_>,
) {
    let size = output.size();
    let [channels, rows, _] = size;
    assert_eq!(planes.len(), size.iter().product(), "planes of this size");
    let units = channels.div_ceil(LANES) * rows;
    let to = output.to();
    thread_pool.run(&|part| {
        let work = Rows { planes, by, size, to, units: part.chunk(units) };
        // SAFETY: sizes were compared, rows of the parts are disjoint, and the level is one of this
        // processor's.
        unsafe { level.run(&work) };
    });
}

/// Writes an image as `[channels][height][width]`, the way back.
///
/// # Panics
/// If there is room for more or fewer values.
pub fn write_planes(thread_pool: &ThreadPool, image: &Image, planes: &mut [f32]) {
    let (channels, pixels) = (image.channels(), image.height() * image.width());
    assert_eq!(planes.len(), channels * pixels, "planes of this size");
    let to = Planes(planes.as_mut_ptr());
    thread_pool.run(&|part| {
        for channel in part.chunk(channels) {
            // SAFETY: planes of the parts are disjoint, and there are so many.
            let plane = unsafe { to.plane(channel * pixels, pixels) };
            image.write_plane(channel, plane);
        }
    });
}

/// Planes that are written.
struct Planes(*mut f32);

// SAFETY: each part of a parallel region writes its own.
unsafe impl Sync for Planes {}

impl Planes {
    /// # Safety
    /// So many values are there, and nobody else has them.
    #[allow(clippy::mut_from_ref, reason = "parts write planes of their own")]
    unsafe fn plane(&self, first: usize, values: usize) -> &mut [f32] {
        // SAFETY: the caller's.
        unsafe { std::slice::from_raw_parts_mut(self.0.add(first), values) }
    }
}

/// Some rows, block after block.
struct Rows<'a> {
    planes: &'a [f32],
    by: [f32; 2],
    size: [usize; 3],
    to: To,
    units: Range<usize>,
}

impl Kernel for Rows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let [channels, height, width] = self.size;
        let [factor, offset] = self.by;
        for unit in self.units.clone() {
            let (block, y) = (unit / height, unit % height);
            let of_block = LANES.min(channels - block * LANES);
            let row = |lane: usize| {
                let channel = block * LANES + lane;
                &self.planes[(channel * height + y) * width..][..width]
            };
            let to = self.to.at(block, y);
            for lane in 0..of_block {
                for (first, values) in row(lane).chunks(LANES).enumerate() {
                    // SAFETY: the caller's.
                    unsafe {
                        let value = if values.len() == LANES {
                            V::load(values.as_ptr())
                        } else {
                            let mut last = [0.0; LANES];
                            last[..values.len()].copy_from_slice(values);
                            V::load(last.as_ptr())
                        };
                        let value = value.mul_add(V::splat(factor), V::splat(offset));
                        let at = to + first * LANES * LANES + lane;
                        self.to.scatter(value, at, values.len());
                    }
                }
            }
        }
    }
}

//! Convolution by dot products of vector registers.

use std::ops::Range;

use super::ConvExec;
use crate::blocked::Part;
use crate::blocked::conv_shape::ConvShape;
use crate::blocked::image::Line;
use crate::simd::dots::{DotProduct, ReducedPrecision, weight_vector_bytes};
use crate::simd::{LANES, Lanes, ReducedKernel};

/// Largest number of pixels of a tile of stride 2: the inputs of a wider one lie too far apart.
const MAX_STRIDE_2_TILE: usize = 8;
/// Weights of a cache line, in bytes.
const CACHE_LINE_BYTES: usize = size_of::<Line>();

/// Kernel for some rows of one group of `B` channel blocks. A type per combination, so that each is
/// compiled on its own: in one function with all of them, LLVM spills half of the accumulators.
pub(super) struct GroupKernel<'a, const B: usize, const STRIDE: usize> {
    pub(super) exec: &'a ConvExec<'a>,
    pub(super) block: usize,
    pub(super) rows: Range<usize>,
    /// Packed weights of the group.
    pub(super) weights: *const u8,
    /// Their size in bytes.
    pub(super) bytes: usize,
    /// Cache lines of the next group's weights to prefetch.
    pub(super) prefetch_lines: usize,
}

impl<S: ReducedPrecision, const B: usize, const STRIDE: usize> ReducedKernel<S>
    for GroupKernel<'_, B, STRIDE>
{
    #[inline(always)]
    unsafe fn run<D: DotProduct<Element = S>>(&self) {
        let [_, _, width] = self.exec.size;
        let tile = D::TILE[B - 1];
        let max_tile = if STRIDE == 2 { tile.min(MAX_STRIDE_2_TILE) } else { tile };
        // As in f32: tiles of a row of nearly the same width.
        let tile_width = width.div_ceil(width.div_ceil(max_tile));
        let (tiles_per_row, mut index) = (width.div_ceil(tile_width), 0);
        for y in self.rows.clone() {
            for x in (0..width).step_by(tile_width) {
                let count = tiles_per_row * self.rows.len();
                let prefetch = Part { index, count }.chunk(self.prefetch_lines);
                index += 1;
                let first =
                    self.weights.wrapping_add(self.bytes + prefetch.start * CACHE_LINE_BYTES);
                let (position, prefetch) = ([self.block, y, x], (first, prefetch.len()));
                macro_rules! match_pixels {
                    ($($n:literal)*) => {
                        match tile_width.min(width - x) {
                            // SAFETY: the caller's. Tiles that exceed the registers are not
                            // compiled.
                            $($n if $n <= D::TILE[B - 1] => unsafe {
                                self.tile::<D, $n>(position, self.weights, prefetch);
                            },)*
                            pixels => unreachable!("{pixels} pixels in a tile"),
                        }
                    };
                }
                // Widths are constants of the compiled tiles: sums then stay in registers.
                match_pixels!(1 2 3 4 5 6 7 8 9 10 11 12);
            }
        }
    }
}

impl<const B: usize, const STRIDE: usize> GroupKernel<'_, B, STRIDE> {
    /// Computes `N` neighbouring output pixels of `B` channel blocks.
    ///
    /// # Safety
    /// That of [`ReducedKernel::run`]; the pixels are inside the output.
    #[inline(always)]
    unsafe fn tile<D: DotProduct, const N: usize>(
        &self,
        [block, y, x]: [usize; 3],
        mut weights: *const u8,
        (prefetch, prefetch_lines): (*const u8, usize),
    ) {
        let ConvExec { conv, input, .. } = self.exec;
        let ConvShape { channels_in, kernel: [kernel, _], .. } = conv.shape;
        let (row_pitch, line) =
            (input.row_pitch() * LANES, weight_vector_bytes::<D::Element>(D::DEPTH));
        let mut fetched = 0;
        // SAFETY: the caller's; the windows of these pixels are inside the input and its border.
        unsafe {
            let mut sums = [[D::zero(); B]; N];
            for first in (0..channels_in).step_by(LANES) {
                // The last block of channels may need fewer steps.
                let steps = LANES.min(channels_in - first).div_ceil(D::DEPTH);
                let from: *const D::Element =
                    input.tap(first / LANES, y * STRIDE, x * STRIDE, kernel / 2);
                for ky in 0..kernel {
                    for kx in 0..kernel {
                        let from = from.add(ky * row_pitch + kx * LANES);
                        for step in 0..steps {
                            // A line at each step, spread over the arithmetic that hides it.
                            if fetched < prefetch_lines {
                                D::Lanes::prefetch(
                                    prefetch.wrapping_add(fetched * CACHE_LINE_BYTES).cast(),
                                );
                                fetched += 1;
                            }
                            let weight: [D::Weights; B] =
                                std::array::from_fn(|block| D::weights(weights.add(block * line)));
                            for (pixel, sums) in sums.iter_mut().enumerate() {
                                let value =
                                    D::values(from.add(pixel * STRIDE * LANES + step * D::DEPTH));
                                for (sum, weight) in sums.iter_mut().zip(weight) {
                                    *sum = D::add(*sum, value, weight);
                                }
                            }
                            weights = weights.add(B * line);
                        }
                    }
                }
            }
            #[allow(clippy::needless_range_loop, reason = "an index of blocks, in every pixel")]
            for k in 0..B {
                self.exec.store(block + k, [y, x], N, |pixel| D::to_f32(sums[pixel][k]));
            }
        }
    }
}

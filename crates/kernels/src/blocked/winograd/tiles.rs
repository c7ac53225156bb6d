//! Kernels over Winograd tiles: input transform, batched GEMM and output transform.

#![allow(clippy::needless_range_loop, reason = "columns become rows")]

use std::marker::PhantomData;
use std::ops::Range;

use super::WinogradExec;
use super::transform::{MAX_INPUTS, WinogradTransform};
use crate::blocked::Part;
use crate::blocked::blocks::block_groups;
use crate::blocked::conv::dispatch_tile;
use crate::blocked::tile::{AccumulatorInit, InputWindow, activated};
use crate::simd::{Kernel, LANES, Lanes};

/// A batch of tiles, with scratch for their transformed inputs and sums.
pub(super) struct Tiles<'a, R, C> {
    pub(super) exec: WinogradExec<'a>,
    /// Tiles per row of the image.
    pub(super) columns: usize,
    /// Index of the first tile of the batch in the image.
    pub(super) first: usize,
    /// Number of tiles.
    pub(super) count: usize,
    /// Transformed inputs `[point][block][tile][16]`, with a line of padding between points.
    pub(super) inputs: *mut f32,
    /// Sums `[point][block][tile][16]` of one group, with a line of padding between points.
    pub(super) sums: *mut f32,
    /// Scratch for weights that are transformed on the fly.
    pub(super) weight_scratch: *mut f32,
    /// Blocks of input channels.
    pub(super) blocks_in: usize,
    pub(super) transforms: PhantomData<(R, C)>,
}

/// Kernel: input transform of a range of channel blocks.
pub(super) struct InputTransform<'a, R, C>(&'a Tiles<'a, R, C>, Range<usize>);

/// Kernel: batched GEMM and output transform of a group of output channels, for a range of the
/// tiles.
pub(super) struct GroupKernel<'a, R, C>(&'a Tiles<'a, R, C>, usize, Range<usize>);

/// Lines from a point to the next in the scratch. One line more than needed, so that points do not
/// alias in the cache.
pub(super) fn pitch(blocks: usize, tiles: usize) -> usize {
    blocks * tiles + 1
}

impl<R: WinogradTransform, C: WinogradTransform> Tiles<'_, R, C> {
    pub(super) fn input_transform(&self, blocks: Range<usize>) -> InputTransform<'_, R, C> {
        InputTransform(self, blocks)
    }

    pub(super) fn group_kernel(&self, group: usize, tiles: Range<usize>) -> GroupKernel<'_, R, C> {
        GroupKernel(self, group, tiles)
    }

    /// Row and column of the first output of a tile.
    fn tile_origin(&self, tile: usize) -> [usize; 2] {
        let tile = self.first + tile;
        [tile / self.columns * R::OUT, tile % self.columns * C::OUT]
    }
}

impl<R: WinogradTransform, C: WinogradTransform> Kernel for InputTransform<'_, R, C> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let Self(tiles, blocks) = self;
        let pitch = pitch(tiles.blocks_in, tiles.count) * LANES;
        let input = tiles.exec.input;
        for block in blocks.clone() {
            for tile in 0..tiles.count {
                let [y, x] = tiles.tile_origin(tile);
                let from = input.tap(block, y, x, 1);
                let row_pitch = input.row_pitch() * LANES;
                // SAFETY: inputs of a tile are inside the image, its border and the overread.
                unsafe {
                    let to = tiles.inputs.add((block * tiles.count + tile) * LANES);
                    let zero = V::splat(0.0);
                    // Columns first, then rows: the transform is separable.
                    let mut columns = [[zero; MAX_INPUTS]; MAX_INPUTS];
                    for (x, column) in columns.iter_mut().enumerate().take(C::IN) {
                        let mut d = [zero; MAX_INPUTS];
                        for (y, d) in d.iter_mut().enumerate().take(R::IN) {
                            *d = V::load(from.add(y * row_pitch + x * LANES));
                        }
                        *column = R::input(d);
                    }
                    for y in 0..R::IN {
                        let row = C::input(std::array::from_fn(|x| columns[x][y]));
                        for (x, value) in row.iter().enumerate().take(C::IN) {
                            // The scales of `G` go to the inputs: its rows are whole numbers then.
                            let factor = V::splat(R::G_SCALES[y] * C::G_SCALES[x]);
                            value.mul(factor).store(to.add((y * C::IN + x) * pitch));
                        }
                    }
                }
            }
        }
    }
}

impl<R: WinogradTransform, C: WinogradTransform> Kernel for GroupKernel<'_, R, C> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let Self(tiles, group, _) = self;
        let shape = tiles.exec.conv.shape;
        let Some(blocks) =
            block_groups(shape.channels_out, tiles.exec.conv.blocks_per_group).nth(*group)
        else {
            return;
        };
        // SAFETY: the caller's.
        unsafe {
            // The output transform right after its GEMM, while the sums are in the cache.
            if blocks.len() == 2 {
                self.batched_gemm::<V, 2>();
                self.output_transform::<V>(blocks);
            } else {
                self.batched_gemm::<V, 1>();
                self.output_transform::<V>(blocks);
            }
        }
    }
}

impl<R: WinogradTransform, C: WinogradTransform> GroupKernel<'_, R, C> {
    /// For every point, multiplies the transformed inputs `[tile][channel]` by the transformed
    /// weights `[channel][B * 16]`: a batch of matrix products.
    ///
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn batched_gemm<V: Lanes, const B: usize>(&self) {
        let Self(tiles, group, range) = self;
        let weights = &tiles.exec.conv.weights;
        let channels_in = tiles.exec.conv.shape.channels_in;
        let count = range.len();
        let [from_pitch, to_pitch] =
            [pitch(tiles.blocks_in, tiles.count), pitch(B, count)].map(|lines| lines * LANES);
        let tile_width = count.div_ceil(count.div_ceil(V::TILE[B - 1]));
        let chunk = weights.blocks_per_chunk();
        for block_in in (0..tiles.blocks_in).step_by(chunk) {
            let blocks = block_in..tiles.blocks_in.min(block_in + chunk);
            let last_channels = LANES.min(channels_in - (blocks.end - 1) * LANES);
            let (blocks_in, block_pitch) = (blocks.len(), tiles.count * LANES);
            // As in the direct convolution: later chunks add to the sums before.
            let init = if block_in == 0 { AccumulatorInit::Zero } else { AccumulatorInit::Dst };
            let prefetch = weights.next_lines(*group, B, blocks.clone());
            // SAFETY: the caller's; the points of these tiles are in the scratch.
            unsafe {
                let all =
                    weights.transformed::<V, R, C, B>(*group, blocks.clone(), tiles.weight_scratch);
                let points = R::IN * C::IN;
                for point in 0..points {
                    let share = Part { index: point, count: points }.chunk(prefetch.len());
                    let prefetch = &prefetch[share];
                    let mut window = InputWindow {
                        blocks: blocks_in,
                        block_pitch,
                        last_channels,
                        kernel: [1; 2],
                        row_pitch: 0,
                        channel_pitch: 1,
                        prefetch: prefetch.as_ptr().cast(),
                        prefetch_lines: prefetch.len(),
                    };
                    let from = block_in * tiles.count + range.start;
                    let from = tiles.inputs.add(point * from_pitch + from * LANES);
                    let weights = all.first.add(point * all.pitch);
                    let to = tiles.sums.add(point * to_pitch);
                    for tile in (0..count).step_by(tile_width) {
                        let pixels = tile_width.min(count - tile);
                        let from = from.add(tile * LANES);
                        let to = (to.add(tile * LANES), count * LANES);
                        dispatch_tile::<V, B, 1, LANES>(
                            pixels, &window, from, weights, init, to, None,
                        );
                        // The first tile has requested all of the point's share.
                        window.prefetch_lines = 0;
                    }
                }
            }
        }
    }

    /// Transforms the sums to outputs and applies bias, residual and activation.
    ///
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn output_transform<V: Lanes>(&self, blocks: Range<usize>) {
        let Self(tiles, _, range) = self;
        let exec = &tiles.exec;
        let pitch = pitch(blocks.len(), range.len()) * LANES;
        let [height, width] = exec.size;
        for (k, block) in blocks.enumerate() {
            for (at, tile) in range.clone().enumerate() {
                let [y0, x0] = tiles.tile_origin(tile);
                // Tiles at the right and lower border reach beyond the output.
                let (rows, columns) = (R::OUT.min(height - y0), C::OUT.min(width - x0));
                let residual = exec
                    .residual
                    .map(|image| (image.tap(block, y0, x0, 0), image.row_pitch() * LANES));
                // SAFETY: pixels of the tile that are written are inside the output.
                unsafe {
                    let from = tiles.sums.add((k * range.len() + at) * LANES);
                    let bias = V::load(exec.conv.bias[block].0.as_ptr());
                    let mut halves = [[V::splat(0.0); 4]; MAX_INPUTS];
                    for (x, half) in halves.iter_mut().enumerate().take(C::IN) {
                        let mut m = [V::splat(0.0); MAX_INPUTS];
                        for (y, m) in m.iter_mut().enumerate().take(R::IN) {
                            *m = V::load(from.add((y * C::IN + x) * pitch));
                        }
                        *half = R::output(m);
                    }
                    for y in 0..rows {
                        let row = C::output(std::array::from_fn(|x| halves[x][y]));
                        let to = exec.dst.pixel(block, y0 + y, x0);
                        for (x, value) in row.iter().enumerate().take(columns) {
                            let mut sum = value.add(bias);
                            if let Some((residual, row_pitch)) = residual {
                                sum = sum.add(V::load(residual.add(y * row_pitch + x * LANES)));
                            }
                            activated(sum, exec.activation).store(to.add(x * LANES));
                        }
                    }
                }
            }
        }
    }
}

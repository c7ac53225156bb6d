//! The steps of tiles: inputs transformed; products at every place, transformed back.

#![allow(clippy::needless_range_loop, reason = "columns become rows")]

use std::marker::PhantomData;
use std::ops::Range;

use super::Job;
use crate::blocked::conv::some;
use crate::blocked::packing::groups;
use crate::blocked::scheme::{MOST, Scheme};
use crate::blocked::thread_pool::Part;
use crate::blocked::tile::{Start, Taps, activated};
use crate::simd::{Kernel, LANES, Lanes};

/// Some tiles, and the memory for what lies between their transforms.
pub(super) struct Tiles<'a, S> {
    pub(super) job: Job<'a>,
    /// Tiles of a row.
    pub(super) columns: usize,
    /// The first tile, and how many there are.
    pub(super) first: usize,
    pub(super) count: usize,
    /// `[place][block][tile][16]`, and a line between places.
    pub(super) inputs: *mut f32,
    /// `[place][block][tile][16]` of one group, and a line between places.
    pub(super) sums: *mut f32,
    /// Kernels that are transformed where they are used.
    pub(super) kernels: *mut f32,
    pub(super) blocks_in: usize,
    pub(super) scheme: PhantomData<S>,
}

/// Transforms the inputs of some blocks of channels.
pub(super) struct Taking<'a, S>(&'a Tiles<'a, S>, Range<usize>);

/// Makes the outputs of a group of channels, of some of the tiles.
pub(super) struct Making<'a, S>(&'a Tiles<'a, S>, usize, Range<usize>);

/// Lines from a place to the next: one more than there are, so that places do not fall on the same
/// lines of the cache.
pub(super) fn pitch(blocks: usize, tiles: usize) -> usize {
    blocks * tiles + 1
}

impl<S: Scheme> Tiles<'_, S> {
    pub(super) fn taking(&self, blocks: Range<usize>) -> Taking<'_, S> {
        Taking(self, blocks)
    }

    pub(super) fn making(&self, group: usize, tiles: Range<usize>) -> Making<'_, S> {
        Making(self, group, tiles)
    }

    /// Row and column of the first output of a tile.
    fn place(&self, tile: usize) -> [usize; 2] {
        let tile = self.first + tile;
        [tile / self.columns * S::OUT, tile % self.columns * S::OUT]
    }
}

impl<S: Scheme> Kernel for Taking<'_, S> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let Self(tiles, blocks) = self;
        let pitch = pitch(tiles.blocks_in, tiles.count) * LANES;
        let input = tiles.job.input;
        for block in blocks.clone() {
            for tile in 0..tiles.count {
                let [y, x] = tiles.place(tile);
                let from = input.tap(block, y, x, 1);
                let row_pitch = input.row_pitch() * LANES;
                // SAFETY: inputs of a tile are inside the image, its border and what lies beyond.
                unsafe {
                    let to = tiles.inputs.add((block * tiles.count + tile) * LANES);
                    let zero = V::splat(0.0);
                    let mut columns = [[zero; MOST]; MOST];
                    for (x, column) in columns.iter_mut().enumerate().take(S::IN) {
                        let mut d = [zero; MOST];
                        for (y, d) in d.iter_mut().enumerate().take(S::IN) {
                            *d = V::load(from.add(y * row_pitch + x * LANES));
                        }
                        *column = S::inputs(d);
                    }
                    for y in 0..S::IN {
                        let row = S::inputs(std::array::from_fn(|x| columns[x][y]));
                        for (x, value) in row.iter().enumerate().take(S::IN) {
                            let factor = V::splat(S::FACTORS[y] * S::FACTORS[x]);
                            value.mul(factor).store(to.add((y * S::IN + x) * pitch));
                        }
                    }
                }
            }
        }
    }
}

impl<S: Scheme> Kernel for Making<'_, S> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let Self(tiles, group, _) = self;
        let shape = tiles.job.of.shape;
        let Some(blocks) = groups(shape.channels_out, tiles.job.of.together).nth(*group) else {
            return;
        };
        // SAFETY: the caller's.
        unsafe {
            if blocks.len() == 2 {
                self.multiply::<V, 2>();
                self.give::<V>(blocks);
            } else {
                self.multiply::<V, 1>();
                self.give::<V>(blocks);
            }
        }
    }
}

impl<S: Scheme> Making<'_, S> {
    /// Adds up the products of every place.
    ///
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn multiply<V: Lanes, const B: usize>(&self) {
        let Self(tiles, group, range) = self;
        let kernels = &tiles.job.of.kernels;
        let channels_in = tiles.job.of.shape.channels_in;
        let count = range.len();
        let [from_pitch, to_pitch] =
            [pitch(tiles.blocks_in, tiles.count), pitch(B, count)].map(|lines| lines * LANES);
        let of_tile = count.div_ceil(count.div_ceil(V::TILE[B - 1]));
        let at_once = kernels.blocks_at_once();
        for block_in in (0..tiles.blocks_in).step_by(at_once) {
            let blocks = block_in..tiles.blocks_in.min(block_in + at_once);
            let last_channels = LANES.min(channels_in - (blocks.end - 1) * LANES);
            let (blocks_in, block_pitch) = (blocks.len(), tiles.count * LANES);
            let start = if block_in == 0 { Start::Zero } else { Start::Output };
            let ahead = kernels.next(*group, B, blocks.clone());
            // SAFETY: the caller's; the places of these tiles are in the scratch.
            unsafe {
                let all = kernels.places::<V, S, B>(*group, blocks.clone(), tiles.kernels);
                for place in 0..S::IN * S::IN {
                    let ahead =
                        &ahead[Part { index: place, count: S::IN * S::IN }.chunk(ahead.len())];
                    let mut taps = Taps {
                        blocks: blocks_in,
                        block_pitch,
                        last_channels,
                        kernel: 1,
                        row_pitch: 0,
                        channel_pitch: 1,
                        ahead: ahead.as_ptr().cast(),
                        ahead_lines: ahead.len(),
                    };
                    let from = block_in * tiles.count + range.start;
                    let from = tiles.inputs.add(place * from_pitch + from * LANES);
                    let weights = all.first.add(place * all.pitch);
                    let to = tiles.sums.add(place * to_pitch);
                    for tile in (0..count).step_by(of_tile) {
                        let pixels = of_tile.min(count - tile);
                        let from = from.add(tile * LANES);
                        let to = (to.add(tile * LANES), count * LANES);
                        some::<V, B, 1, LANES>(pixels, &taps, from, weights, start, to, None);
                        taps.ahead_lines = 0;
                    }
                }
            }
        }
    }

    /// Transforms the sums back.
    ///
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn give<V: Lanes>(&self, blocks: Range<usize>) {
        let Self(tiles, _, range) = self;
        let job = &tiles.job;
        let pitch = pitch(blocks.len(), range.len()) * LANES;
        let [height, width] = job.size;
        for (k, block) in blocks.enumerate() {
            for (at, tile) in range.clone().enumerate() {
                let [y0, x0] = tiles.place(tile);
                let (rows, columns) = (S::OUT.min(height - y0), S::OUT.min(width - x0));
                let residual = job
                    .residual
                    .map(|image| (image.tap(block, y0, x0, 0), image.row_pitch() * LANES));
                // SAFETY: pixels of the tile that are written are inside the output.
                unsafe {
                    let from = tiles.sums.add((k * range.len() + at) * LANES);
                    let bias = V::load(job.of.bias[block].0.as_ptr());
                    let mut halves = [[V::splat(0.0); 4]; MOST];
                    for (x, half) in halves.iter_mut().enumerate().take(S::IN) {
                        let mut m = [V::splat(0.0); MOST];
                        for (y, m) in m.iter_mut().enumerate().take(S::IN) {
                            *m = V::load(from.add((y * S::IN + x) * pitch));
                        }
                        *half = S::outputs(m);
                    }
                    for y in 0..rows {
                        let row = S::outputs(std::array::from_fn(|x| halves[x][y]));
                        let to = job.out.pixel(block, y0 + y, x0);
                        for (x, value) in row.iter().enumerate().take(columns) {
                            let mut sum = value.add(bias);
                            if let Some((residual, row_pitch)) = residual {
                                sum = sum.add(V::load(residual.add(y * row_pitch + x * LANES)));
                            }
                            activated(sum, job.activation).store(to.add(x * LANES));
                        }
                    }
                }
            }
        }
    }
}

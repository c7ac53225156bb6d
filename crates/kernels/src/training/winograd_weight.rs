//! Weights of 3x3 convolutions and their gradients in Winograd's transforms.
//!
//! # Model
//! With the transforms of [`WinogradTransform`], `y = Aᵀ ((G g Gᵀ) ⊙ (Bᵀ d B)) A`. Its gradient by the weights
//! is `Gᵀ (Σ (A dy Aᵀ) ⊙ (Bᵀ d B)) G`, summed over tiles before it is transformed back.

use rayon::prelude::*;

use super::blocks::Blocks;
use super::norm::NormalizedInput;
use super::outer::{OFFSETS, Pixels, outer};
use super::shape::Conv;
use super::weights::Weights;
use super::winograd::{Chosen, Tiles, take};
use crate::blocked::{Line, MAX_INPUTS, WinogradTransform, block_groups};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Bytes of transformed inputs and gradients at a time, of the second caches.
const HELD: usize = 4 << 20;

/// `G`, whole.
fn matrix<S: WinogradTransform>() -> [[f32; 3]; MAX_INPUTS] {
    std::array::from_fn(|row| S::G[row].map(|tap| tap * S::G_SCALES[row]))
}

impl Weights<'_> {
    /// The weights of every place: `[place][blocks together][channel][block][16]`.
    pub(super) fn transformed<S: WinogradTransform>(
        &self,
        together: usize,
        level: Level,
    ) -> Vec<Line> {
        let places = S::IN * S::IN;
        let [channels_out, channels_in] = self.channels();
        let of_place = channels_out.div_ceil(LANES) * channels_in;
        let mut lines = vec![Line::ZERO; places * of_place];
        let to = Places { first: lines.as_mut_ptr().cast(), pitch: of_place * LANES };
        let all = block_groups(channels_out, together).len();
        // A single kernel is too little work for a task.
        (0..all * channels_in).into_par_iter().with_min_len(16).for_each(|k| {
            let work = Kernels {
                of: self,
                together,
                group: k / channels_in,
                channel: k % channels_in,
                matrix: matrix::<S>(),
                inputs: S::IN,
                to: &to,
            };
            // SAFETY: each call writes the lines of its own channel and blocks.
            unsafe { level.run(&work) };
        });
        lines
    }
}

/// Lines of every place.
struct Places {
    first: *mut f32,
    /// From a place to the next.
    pitch: usize,
}

// SAFETY: lines that are written are of one channel and some blocks each.
unsafe impl Sync for Places {}

/// The kernels from a channel to some blocks.
struct Kernels<'a> {
    of: &'a Weights<'a>,
    together: usize,
    group: usize,
    channel: usize,
    matrix: [[f32; 3]; MAX_INPUTS],
    inputs: usize,
    to: &'a Places,
}

impl Kernel for Kernels<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let [channels_out, channels_in] = self.of.channels();
        let [out_pitch, in_pitch] = self.of.pitches();
        let first = self.group * self.together;
        let blocks = channels_out.div_ceil(LANES).min(first + self.together) - first;
        for block in 0..blocks {
            let first_out = (first + block) * LANES;
            let mut taps = [Line::ZERO; 9];
            for lane in 0..LANES.min(channels_out - first_out) {
                let at = (first_out + lane) * out_pitch + self.channel * in_pitch;
                for (k, value) in self.of.values[at..at + 9].iter().enumerate() {
                    // Who computes the input turns the kernel round.
                    taps[if self.of.is_transposed { 8 - k } else { k }].0[lane] = *value;
                }
            }
            // SAFETY: the line of this channel and block is in every place.
            unsafe {
                let line = (first * channels_in + self.channel * blocks + block) * LANES;
                let to = self.to.first.add(line);
                let product = |row: &[f32; 3], of: [V; 3]| {
                    let sum = V::splat(row[0]).mul(of[0]);
                    let sum = V::splat(row[1]).mul_add(of[1], sum);
                    V::splat(row[2]).mul_add(of[2], sum)
                };
                let g: [V; 9] = std::array::from_fn(|k| V::load(taps[k].0.as_ptr()));
                // Down and then across: the transform is separable.
                for (y, row) in self.matrix.iter().enumerate().take(self.inputs) {
                    let half: [V; 3] =
                        std::array::from_fn(|x| product(row, [g[x], g[3 + x], g[6 + x]]));
                    for (x, row) in self.matrix.iter().enumerate().take(self.inputs) {
                        let place = y * self.inputs + x;
                        product(row, half).store(to.add(place * self.to.pitch));
                    }
                }
            }
        }
    }
}

/// The gradient by the weight of a 3x3 convolution of stride 1.
pub(super) fn gradient(conv: &Conv, input: NormalizedInput<'_>, gradient: &[f32]) -> Vec<f32> {
    let places = Chosen::IN * Chosen::IN;
    let (shape, out) = (conv.input, conv.output());
    let together = conv.blocks_at_once();
    let all: Vec<_> = block_groups(out.channels, together).collect();
    let tiles = Tiles::new::<Chosen>(shape);
    // Sums of a place and some blocks: `[channel][block][16]`.
    let of_group = shape.blocks() * LANES * together;
    let mut sums = vec![Line::ZERO; places * all.len() * of_group];
    let of_tile = places * (shape.blocks() + out.blocks());
    let at_once =
        (HELD / size_of::<Line>() / of_tile.max(1)).max(OFFSETS).min(tiles.count().max(1));
    let mut held = vec![Line::ZERO; at_once * of_tile];
    // In parts, since inputs and gradients of all tiles would not fit in the cache.
    for first in (0..tiles.count()).step_by(at_once) {
        let range = first..tiles.count().min(first + at_once);
        let of_block = places * range.len();
        let lines = &mut held[..(shape.blocks() + out.blocks()) * of_block];
        lines.par_chunks_mut(of_block).enumerate().for_each(|(block, lines)| {
            let work = Transform {
                tiles,
                range: range.clone(),
                input,
                out,
                gradient,
                block,
                to: lines.as_mut_ptr().cast(),
            };
            // SAFETY: lines are of this block alone.
            unsafe { conv.level.run(&work) };
        });
        let lines = &*lines;
        sums.par_chunks_mut(of_group).enumerate().for_each(|(k, sums)| {
            let (place, group) = (k / all.len(), &all[k % all.len()]);
            let at = |block: usize| block * of_block + place * range.len();
            let work = Products {
                pixels: Pixels {
                    size: [range.len(), 1, 1],
                    from_pitch: [LANES, 0, 0],
                    gradient_pitch: [LANES, 0, 0],
                    block_pitch: of_block * LANES,
                },
                from: lines[at(0)..].as_ptr().cast(),
                gradient: lines[at(shape.blocks() + group.start)..].as_ptr().cast(),
                blocks: [shape.blocks(), group.len()],
                sums: sums.as_mut_ptr().cast(),
            };
            // SAFETY: both have as many tiles of this place; sums are of this place and group
            // alone.
            unsafe { conv.level.run(&work) };
        });
    }
    // Transformed back once, after all tiles are summed.
    let mut weight = vec![0.0; out.channels * shape.channels * 9];
    let of_channels = together * LANES * shape.channels * 9;
    weight.par_chunks_mut(of_channels.max(1)).enumerate().for_each(|(group, weight)| {
        let work = Back {
            sums: &sums[group * of_group..],
            place_pitch: all.len() * of_group,
            blocks: all[group].len(),
            channels_in: shape.channels,
            matrix: matrix::<Chosen>(),
            inputs: Chosen::IN,
            weight: weight.as_mut_ptr(),
            channels: weight.len() / (shape.channels * 9),
        };
        // SAFETY: weights are of this group alone.
        unsafe { conv.level.run(&work) };
    });
    weight
}

/// Tiles of a block of the input, or behind those of the gradient, transformed.
struct Transform<'a> {
    tiles: Tiles,
    range: std::ops::Range<usize>,
    input: NormalizedInput<'a>,
    out: Blocks,
    gradient: &'a [f32],
    block: usize,
    to: *mut f32,
}

impl Kernel for Transform<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let blocks_in = self.tiles.shape.blocks();
        // SAFETY: the caller's.
        unsafe {
            if self.block < blocks_in {
                let line = self.input.block_norm(self.block);
                let (from, line) = (self.input.values, line.as_ref());
                take::<V, Chosen>(&self.tiles, self.range.clone(), self.block, from, line, self.to);
            } else {
                self.spread::<V, Chosen>(self.block - blocks_in);
            }
        }
    }
}

impl Transform<'_> {
    /// `A dy Aᵀ`.
    ///
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn spread<V: Lanes, S: WinogradTransform>(&self, block: usize) {
        let Blocks { height, width, .. } = self.out;
        let pitch = self.range.len() * LANES;
        // SAFETY: pixels that are read are inside of the image; what is written has room.
        unsafe {
            for (k, tile) in self.range.clone().enumerate() {
                let [image, y0, x0] = self.tiles.place::<S>(tile);
                let at = image * self.out.image() + block * self.out.block();
                let from = self.gradient[at..].as_ptr().add((y0 * width + x0) * LANES);
                let to = self.to.add(k * LANES);
                let zero = V::splat(0.0);
                let mut columns = [[zero; MAX_INPUTS]; 4];
                // Beyond the border there is no gradient: it stays zero.
                let (rows, across) = (S::OUT.min(height - y0), S::OUT.min(width - x0));
                for (x, column) in columns.iter_mut().enumerate().take(across) {
                    let mut dy = [zero; 4];
                    for (y, dy) in dy.iter_mut().enumerate().take(rows) {
                        *dy = V::load(from.add((y * width + x) * LANES));
                    }
                    *column = S::output_transposed(dy);
                }
                for y in 0..S::IN {
                    let row = S::output_transposed(std::array::from_fn(|x| columns[x][y]));
                    for (x, value) in row.iter().enumerate().take(S::IN) {
                        value.store(to.add((y * S::IN + x) * pitch));
                    }
                }
            }
        }
    }
}

/// Products of a place, summed over tiles.
struct Products {
    pixels: Pixels,
    from: *const f32,
    gradient: *const f32,
    /// Of the input and of the gradient.
    blocks: [usize; 2],
    sums: *mut f32,
}

impl Kernel for Products {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let [blocks_in, blocks] = self.blocks;
        for first in (0..blocks_in * LANES).step_by(OFFSETS) {
            let (block, lane) = (first / LANES, first % LANES);
            let offsets: [usize; OFFSETS] = std::array::from_fn(|k| lane + k);
            // SAFETY: the caller's.
            unsafe {
                let from = self.from.add(block * self.pixels.block_pitch);
                let sums = self.sums.add(first * blocks * LANES);
                outer::<V>(&self.pixels, from, &offsets, self.gradient, blocks, sums);
            }
        }
    }
}

/// `Gᵀ m G` of some blocks of output channels.
struct Back<'a> {
    sums: &'a [Line],
    place_pitch: usize,
    blocks: usize,
    channels_in: usize,
    matrix: [[f32; 3]; MAX_INPUTS],
    inputs: usize,
    /// `[channel][channel of the input][9]`.
    weight: *mut f32,
    channels: usize,
}

impl Kernel for Back<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        for channel_in in 0..self.channels_in {
            for block in 0..self.blocks {
                let mut taps = [Line::ZERO; 9];
                // SAFETY: every place has sums of this channel and block.
                unsafe {
                    let mut halves = [[V::splat(0.0); 3]; MAX_INPUTS];
                    for (x, half) in halves.iter_mut().enumerate().take(self.inputs) {
                        for (y, row) in self.matrix.iter().enumerate().take(self.inputs) {
                            let place = (y * self.inputs + x) * self.place_pitch;
                            let line = &self.sums[place + channel_in * self.blocks + block];
                            let value = V::load(line.0.as_ptr());
                            for (half, weight) in half.iter_mut().zip(row) {
                                *half = V::splat(*weight).mul_add(value, *half);
                            }
                        }
                    }
                    for (k, tap) in taps.iter_mut().enumerate() {
                        let mut sum = V::splat(0.0);
                        for (half, row) in halves.iter().zip(&self.matrix).take(self.inputs) {
                            sum = V::splat(row[k % 3]).mul_add(half[k / 3], sum);
                        }
                        sum.store(tap.0.as_mut_ptr());
                    }
                }
                let channels = self.channels - block * LANES;
                for lane in 0..LANES.min(channels) {
                    let at = ((block * LANES + lane) * self.channels_in + channel_in) * 9;
                    for (k, tap) in taps.iter().enumerate() {
                        // SAFETY: there are as many weights as said.
                        unsafe { *self.weight.add(at + k) = tap.0[lane] };
                    }
                }
            }
        }
    }
}

//! The kernel of outputs: sums over taps and channels of a few pixels, all in registers.

use std::ops::Range;

use crate::blocked::{Line, block_groups};
use crate::simd::{Kernel, LANES, Lanes};

/// Bytes of weights that are used over and over again, of the nearest cache of 32 KiB.
const NEAREST: usize = 24 << 10;

/// Outputs `bias + Σ weight input` over the taps and channels of an input. Distances are in `f32`.
pub(super) struct Gather<'a> {
    /// Positions of the taps, relative to the first input of an output.
    pub(super) taps: &'a [usize],
    /// Channels of the input, and the distance between blocks of them.
    pub(super) channels: usize,
    pub(super) block_pitch: usize,
    /// Distances between the inputs of neighbouring columns, rows and images.
    pub(super) from_pitch: [usize; 3],
    /// `[group][block][tap][channel][block of the group][16]`.
    pub(super) weights: &'a [Line],
    /// One line for each block of outputs; zero where there is none.
    pub(super) bias: Option<&'a [Line]>,
    /// Channels of the output, blocks of them in a group, and the distance between blocks.
    pub(super) channels_out: usize,
    pub(super) blocks_at_once: usize,
    pub(super) block_pitch_out: usize,
    /// Columns, rows and images of the output, and the distances between them.
    pub(super) size: [usize; 3],
    pub(super) to_pitch: [usize; 3],
    /// The first input, and the first output.
    pub(super) from: *const f32,
    pub(super) to: *mut f32,
}

/// The part of a [`Gather`] that reads some blocks of input channels.
struct InputWindow<'a> {
    offsets: &'a [usize],
    blocks: Range<usize>,
    channels: usize,
    block_pitch: usize,
    pixel_pitch: usize,
}

/// Contract: inputs are readable from `from` and outputs writable from `to` as the fields say,
/// nobody else writes either, and there are as many weights.
impl Kernel for Gather<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        for (group, blocks) in block_groups(self.channels_out, self.blocks_at_once).enumerate() {
            let first = group * self.blocks_at_once * self.channels * self.taps.len();
            // SAFETY: the caller's.
            unsafe {
                match blocks.len() {
                    2 => self.group::<V, 2>(blocks.start, first),
                    _ => self.group::<V, 1>(blocks.start, first),
                }
            }
        }
    }
}

impl Gather<'_> {
    /// # Safety
    /// That of [`Kernel::run`]; weights of the group begin at line `first`.
    #[inline(always)]
    unsafe fn group<V: Lanes, const B: usize>(&self, block_out: usize, first: usize) {
        let blocks_in = self.channels.div_ceil(LANES);
        let of_block = self.taps.len() * LANES * B;
        // The weights of as many input blocks as the nearest cache holds.
        let at_once = (NEAREST / (of_block * size_of::<Line>()).max(1)).clamp(1, blocks_in);
        let [columns, rows, images] = self.size;
        let most = V::TILE[B - 1];
        for block_in in (0..blocks_in).step_by(at_once) {
            let taps = InputWindow {
                offsets: self.taps,
                blocks: block_in..blocks_in.min(block_in + at_once),
                channels: self.channels,
                block_pitch: self.block_pitch,
                pixel_pitch: self.from_pitch[0],
            };
            let weights = self.weights[first + block_in * of_block..].as_ptr().cast::<f32>();
            for (image, y) in (0..images).flat_map(|image| (0..rows).map(move |y| (image, y))) {
                let mut x = 0;
                while x < columns {
                    let pixels = (columns - x).min(most);
                    // SAFETY: these pixels are among the outputs, and so are their inputs.
                    unsafe {
                        let place =
                            |pitch: [usize; 3]| x * pitch[0] + y * pitch[1] + image * pitch[2];
                        let from = self.from.add(place(self.from_pitch));
                        let at = block_out * self.block_pitch_out + place(self.to_pitch);
                        let to = (self.to.add(at), [self.to_pitch[0], self.block_pitch_out]);
                        // The first blocks begin with the bias, later ones with the sums so far.
                        let init = match (block_in, self.bias) {
                            (0, Some(bias)) => {
                                AccumulatorInit::Bias(bias[block_out..].as_ptr().cast())
                            }
                            (0, None) => AccumulatorInit::Zero,
                            _ => AccumulatorInit::Output,
                        };
                        x += tile_up_to::<V, B>(pixels, &taps, from, weights, init, to);
                    }
                }
            }
        }
    }
}

/// Initial values of the accumulators of a tile.
#[derive(Clone, Copy)]
enum AccumulatorInit {
    Zero,
    /// The same channels for every pixel.
    Bias(*const f32),
    /// The present values of the output.
    Output,
}

/// Computes the largest tile of at most `pixels` pixels; returns its pixels.
///
/// # Safety
/// That of [`tile`].
#[inline(always)]
unsafe fn tile_up_to<V: Lanes, const B: usize>(
    pixels: usize,
    taps: &InputWindow<'_>,
    from: *const f32,
    weights: *const f32,
    init: AccumulatorInit,
    to: (*mut f32, [usize; 2]),
) -> usize {
    macro_rules! of {
        ($($n:literal)*) => {
            match pixels {
                // SAFETY: the caller's. Larger tiles than registers hold are not compiled.
                $($n.. if $n <= V::TILE[B - 1] => unsafe {
                    tile::<V, $n, B>(taps, from, weights, init, to);
                    $n
                },)*
                _ => unreachable!("{pixels} pixels in a tile"),
            }
        };
    }
    of!(12 8 6 4 3 2 1)
}

/// Adds to `N` outputs of `B` blocks of channels the products with the inputs of `taps`.
///
/// # Safety
/// The processor has the instructions of `V`. Readable are the taps of `N` pixels from `from` on,
/// their weights, and 16 values of the bias for each block; writable are `N` pixels of `B` blocks,
/// as far apart as said, from `to` on.
#[inline(always)]
unsafe fn tile<V: Lanes, const N: usize, const B: usize>(
    taps: &InputWindow<'_>,
    from: *const f32,
    mut weights: *const f32,
    init: AccumulatorInit,
    (to, [pixel_pitch, block_pitch]): (*mut f32, [usize; 2]),
) {
    // SAFETY: the caller's; every offset below is of a pixel, a weight or a sum that is named
    // there.
    unsafe {
        let mut sums = [[V::splat(0.0); B]; N];
        match init {
            AccumulatorInit::Zero => {}
            AccumulatorInit::Bias(bias) => {
                let bias: [V; B] = std::array::from_fn(|block| V::load(bias.add(block * LANES)));
                sums = [bias; N];
            }
            AccumulatorInit::Output => {
                for (pixel, sums) in sums.iter_mut().enumerate() {
                    for (block, sum) in sums.iter_mut().enumerate() {
                        *sum = V::load(to.add(block * block_pitch + pixel * pixel_pitch));
                    }
                }
            }
        }
        for block in taps.blocks.clone() {
            // Lanes without a channel would add zeros: they are left out.
            let channels = LANES.min(taps.channels - block * LANES);
            for offset in taps.offsets {
                let from = from.add(block * taps.block_pitch + offset);
                for channel in 0..channels {
                    let weight: [V; B] =
                        std::array::from_fn(|block| V::load(weights.add(block * LANES)));
                    for (pixel, sums) in sums.iter_mut().enumerate() {
                        let value = V::splat(*from.add(pixel * taps.pixel_pitch + channel));
                        for (sum, weight) in sums.iter_mut().zip(weight) {
                            *sum = value.mul_add(weight, *sum);
                        }
                    }
                    weights = weights.add(B * LANES);
                }
            }
        }
        for (pixel, sums) in sums.iter().enumerate() {
            for (block, sum) in sums.iter().enumerate() {
                sum.store(to.add(block * block_pitch + pixel * pixel_pitch));
            }
        }
    }
}

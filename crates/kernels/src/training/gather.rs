//! The kernel of outputs: sums over taps and channels of a few pixels, all in registers.

use std::ops::Range;

use crate::blocked::{Line, groups};
use crate::simd::{Kernel, LANES, Lanes};

/// Bytes of weights that are used over and over again, of the nearest cache of 32 KiB.
const NEAREST: usize = 24 << 10;

/// Outputs `bias + Σ weight input` over the taps and channels of an input. Distances are in `f32`.
pub(super) struct Gather<'a> {
    /// Where each tap of an output is, from where the output's inputs begin.
    pub(super) taps: &'a [usize],
    /// Channels of the input and, from a block of them to the next.
    pub(super) channels: usize,
    pub(super) block_pitch: usize,
    /// From the inputs of an output to those of the next column, row, image.
    pub(super) from_pitch: [usize; 3],
    /// `[blocks together][block][tap][channel][block together][16]`.
    pub(super) weights: &'a [Line],
    /// One for each block of outputs; none is zero.
    pub(super) bias: Option<&'a [Line]>,
    /// Channels of the output, blocks of them that are made together, from a block to the next.
    pub(super) channels_out: usize,
    pub(super) together: usize,
    pub(super) block_pitch_out: usize,
    /// Columns, rows and images of the output, and from each to the next.
    pub(super) size: [usize; 3],
    pub(super) to_pitch: [usize; 3],
    /// Where inputs begin, and outputs.
    pub(super) from: *const f32,
    pub(super) to: *mut f32,
}

/// A part of a [`Gather`]: some blocks of channels of the input.
struct Taps<'a> {
    offsets: &'a [usize],
    blocks: Range<usize>,
    channels: usize,
    block_pitch: usize,
    pixel_pitch: usize,
}

/// Whose contract is that readable from `from` and writable from `to` on is what the fields say, that
/// nobody else writes either, and that there are as many weights.
impl Kernel for Gather<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        for (group, blocks) in groups(self.channels_out, self.together).enumerate() {
            let first = group * self.together * self.channels * self.taps.len();
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
        let at_once = (NEAREST / (of_block * size_of::<Line>()).max(1)).clamp(1, blocks_in);
        let [columns, rows, images] = self.size;
        let most = V::TILE[B - 1];
        for block_in in (0..blocks_in).step_by(at_once) {
            let taps = Taps {
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
                        let start = match (block_in, self.bias) {
                            (0, Some(bias)) => Start::Bias(bias[block_out..].as_ptr().cast()),
                            (0, None) => Start::Zero,
                            _ => Start::Output,
                        };
                        x += some::<V, B>(pixels, &taps, from, weights, start, to);
                    }
                }
            }
        }
    }
}

/// Sums that a tile begins with.
#[derive(Clone, Copy)]
enum Start {
    Zero,
    /// These channels, for every pixel.
    Bias(*const f32),
    /// What stands where the tile is written.
    Output,
}

/// A tile of so many pixels or somewhat fewer: how many.
///
/// # Safety
/// That of [`tile`].
#[inline(always)]
unsafe fn some<V: Lanes, const B: usize>(
    pixels: usize,
    taps: &Taps<'_>,
    from: *const f32,
    weights: *const f32,
    start: Start,
    to: (*mut f32, [usize; 2]),
) -> usize {
    macro_rules! of {
        ($($n:literal)*) => {
            match pixels {
                // SAFETY: the caller's. Larger tiles than registers hold are not compiled.
                $($n.. if $n <= V::TILE[B - 1] => unsafe {
                    tile::<V, $n, B>(taps, from, weights, start, to);
                    $n
                },)*
                _ => unreachable!("{pixels} pixels in a tile"),
            }
        };
    }
    of!(12 8 6 4 3 2 1)
}

/// Adds what `N` outputs of `B` blocks of channels get from `taps`.
///
/// # Safety
/// The processor has the instructions of `V`. Readable are the taps of `N` pixels from `from` on, their
/// weights, and 16 values of the bias for each block; writable are `N` pixels of `B` blocks, as far
/// apart as said, from `to` on.
#[inline(always)]
unsafe fn tile<V: Lanes, const N: usize, const B: usize>(
    taps: &Taps<'_>,
    from: *const f32,
    mut weights: *const f32,
    start: Start,
    (to, [pixel_pitch, block_pitch]): (*mut f32, [usize; 2]),
) {
    // SAFETY: the caller's; every offset below is of a pixel, a weight or a sum that is named there.
    unsafe {
        let mut sums = [[V::splat(0.0); B]; N];
        match start {
            Start::Zero => {}
            Start::Bias(bias) => {
                let bias: [V; B] = std::array::from_fn(|block| V::load(bias.add(block * LANES)));
                sums = [bias; N];
            }
            Start::Output => {
                for (pixel, sums) in sums.iter_mut().enumerate() {
                    for (block, sum) in sums.iter_mut().enumerate() {
                        *sum = V::load(to.add(block * block_pitch + pixel * pixel_pitch));
                    }
                }
            }
        }
        for block in taps.blocks.clone() {
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

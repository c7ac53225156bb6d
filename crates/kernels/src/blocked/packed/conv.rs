//! Direct convolution of images of fewer bits.

use std::ops::Range;

use super::held::{From, Held, HeldMut, To};
use super::image::{Packed, Storage};
use super::weights::Bytes;
use crate::blocked::conv::ConvShape;
use crate::blocked::image::Line;
use crate::blocked::packing::{blocks_of, groups};
use crate::blocked::thread_pool::{Part, ThreadPool};
use crate::blocked::tile::{Activation, activated};
use crate::simd::dots::{Bf16, Dots, Stored, line_bytes};
use crate::simd::{LANES, Lanes, Level, Packed as _, PackedKernel};

/// Pixels of a tile of stride 2 at most: the inputs of more lie too far apart.
const TILE_OF_TWO: usize = 8;

/// A convolution whose weights are kept in fewer bits.
#[derive(Debug, Clone)]
pub struct PackedConv {
    shape: ConvShape,
    level: Level,
    input: Storage,
    /// Blocks of output channels that are made together, 2 or 1; a last odd one is alone.
    together: usize,
    /// `[blocks together][input block][ky][kx][channels at once][block][16][channel]`.
    weights: Vec<Line>,
    /// What whole sums are multiplied by, and what is added to them.
    factors: Vec<Line>,
    bias: Vec<Line>,
}

impl PackedConv {
    /// Lays `weight`, `[channels_out][channels_in][kernel][kernel]`, and `bias`, `[channels_out]`,
    /// out for images that are kept as `input`.
    ///
    /// # Panics
    /// If there are more or fewer, or the stride is not 1 or 2, or the kernel is even.
    pub fn new(
        shape: ConvShape,
        weight: &[f32],
        bias: &[f32],
        input: Storage,
        level: Level,
    ) -> Self {
        let ConvShape { channels_in, channels_out, kernel, stride } = shape;
        assert!(matches!(stride, 1 | 2) && kernel % 2 == 1, "a square kernel of stride 1 or 2");
        assert_eq!(weight.len(), channels_out * channels_in * kernel * kernel, "weights");
        assert_eq!(bias.len(), channels_out, "bias");
        let together = if level.holds_two() { 2 } else { 1 };
        let mut conv = Self {
            shape,
            level,
            input,
            together,
            weights: Vec::new(),
            factors: Vec::new(),
            bias: Vec::new(),
        };
        match input {
            Storage::Bf16 => {
                let weight: Vec<Bf16> = weight.iter().map(|value| Bf16::nearest(*value)).collect();
                conv.lay_out::<Bf16>(&weight, Bf16::per(level));
                conv.factors = blocks_of(&vec![1.0; channels_out]);
                conv.bias = blocks_of(bias);
            }
            Storage::Byte(scale) => {
                let bytes = Bytes::new(weight, bias, scale);
                conv.lay_out::<u8>(&bytes.weight, u8::per(level));
                (conv.factors, conv.bias) = (blocks_of(&bytes.factors), blocks_of(&bytes.offsets));
            }
        }
        conv
    }

    /// Its shape.
    pub fn shape(&self) -> ConvShape {
        self.shape
    }

    fn groups(&self) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
        groups(self.shape.channels_out, self.together)
    }

    fn lay_out<S: Stored>(&mut self, weight: &[S::Weight], per: usize) {
        let ConvShape { channels_in, channels_out, kernel, .. } = self.shape;
        let taps = kernel * kernel;
        let mut all: Vec<Option<S::Weight>> = Vec::new();
        for blocks in self.groups() {
            for first in (0..channels_in).step_by(LANES) {
                let channels = LANES.min(channels_in - first);
                for tap in 0..taps {
                    for at_once in (first..first + channels).step_by(per) {
                        for channel_out in blocks.start * LANES..blocks.end * LANES {
                            all.extend((at_once..at_once + per).map(|channel_in| {
                                let is_there =
                                    channel_out < channels_out && channel_in < channels_in;
                                let kernel = channel_out * channels_in + channel_in;
                                is_there.then(|| weight[kernel * taps + tap])
                            }));
                        }
                    }
                }
            }
        }
        let bytes = all.len() * size_of::<S::Weight>();
        self.weights = vec![Line::ZERO; bytes.div_ceil(size_of::<Line>())];
        let to: *mut S::Weight = self.weights.as_mut_ptr().cast();
        for (at, weight) in all.into_iter().enumerate() {
            if let Some(weight) = weight {
                // SAFETY: there is room for all; what is not there stays zero.
                unsafe { to.add(at).write(weight) };
            }
        }
    }

    /// Writes `activation(conv(input) + residual)` to `output`.
    ///
    /// # Panics
    /// If an image has another size, or the input is kept otherwise than the weights are made for
    /// or its border narrower than the padding.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: &Packed,
        residual: Option<Held<'_>>,
        activation: Activation,
        mut output: HeldMut<'_>,
    ) {
        let shape = self.shape;
        let [channels, height, width] = input.size();
        assert_eq!(channels, shape.channels_in, "channels of the input");
        assert_eq!(input.storage(), self.input, "an input that the weights are made for");
        assert!(input.border() >= shape.padding(), "a border as wide as the padding");
        let size = [shape.channels_out, shape.output(height), shape.output(width)];
        assert_eq!(output.size(), size, "size of the output");
        assert!(residual.is_none_or(|residual| residual.size() == size), "size of the residual");
        let residual = residual.map(|residual| residual.from());
        let job = Job { of: self, input, residual, activation, size, to: output.to() };
        match self.input {
            Storage::Bf16 => job.run::<Bf16>(thread_pool),
            Storage::Byte(_) => job.run::<u8>(thread_pool),
        }
    }
}

/// A convolution of an image.
struct Job<'a> {
    of: &'a PackedConv,
    input: &'a Packed,
    residual: Option<From>,
    activation: Activation,
    size: [usize; 3],
    to: To,
}

/// Some rows of a group of `B` blocks of channels. Each kind of group is compiled by itself: of one
/// function for all, compilers leave half in memory.
struct Rows<'a, const B: usize, const STRIDE: usize> {
    job: &'a Job<'a>,
    block: usize,
    rows: Range<usize>,
    /// Weights of the group, their bytes, and lines that are read after them.
    weights: *const u8,
    bytes: usize,
    ahead_lines: usize,
}

impl Job<'_> {
    fn run<S: crate::simd::Packed>(&self, thread_pool: &ThreadPool) {
        let (rows, groups) = (self.size[1], self.of.groups().len());
        thread_pool.run(&|part: Part| {
            // Every output belongs to one part.
            let (groups, rows) = if groups.is_multiple_of(part.count) {
                (part.chunk(groups), 0..rows)
            } else {
                (0..groups, part.chunk(rows))
            };
            self.groups::<S>(groups, &rows);
        });
    }

    /// Makes some rows of some groups.
    fn groups<S: crate::simd::Packed>(&self, groups: Range<usize>, rows: &Range<usize>) {
        let ConvShape { channels_in, kernel, stride, .. } = self.of.shape;
        let per = S::per(self.of.level);
        let steps = channels_in / LANES * (LANES / per) + (channels_in % LANES).div_ceil(per);
        let mut first = 0;
        for (group, blocks) in self.of.groups().enumerate() {
            let bytes = steps * kernel.pow(2) * blocks.len() * line_bytes::<S>(per);
            if groups.contains(&group) {
                let all = size_of_val(self.of.weights.as_slice());
                let weights = self.of.weights.as_ptr().cast::<u8>().wrapping_add(first);
                let ahead_lines = bytes.min(all - first - bytes) / size_of::<Line>();
                let (block, rows) = (blocks.start, rows.clone());
                macro_rules! run {
                    ($b:literal, $stride:literal) => {{
                        let work = Rows::<$b, $stride> {
                            job: self,
                            block,
                            rows,
                            weights,
                            bytes,
                            ahead_lines,
                        };
                        // SAFETY: sizes were compared, outputs of the parts are disjoint, and the
                        // level is one of this processor's.
                        unsafe { S::run(self.of.level, &work) }
                    }};
                }
                match (blocks.len(), stride) {
                    (1, 1) => run!(1, 1),
                    (1, _) => run!(1, 2),
                    (_, 1) => run!(2, 1),
                    _ => run!(2, 2),
                }
            }
            first += bytes;
        }
    }
}

impl<S: Stored, const B: usize, const STRIDE: usize> PackedKernel<S> for Rows<'_, B, STRIDE> {
    #[inline(always)]
    unsafe fn run<D: Dots<Stored = S>>(&self) {
        let [_, _, width] = self.job.size;
        let tile = D::TILE[B - 1];
        let most = if STRIDE == 2 { tile.min(TILE_OF_TWO) } else { tile };
        let of_tile = width.div_ceil(width.div_ceil(most));
        let (of_row, mut done) = (width.div_ceil(of_tile), 0);
        for y in self.rows.clone() {
            for x in (0..width).step_by(of_tile) {
                let of = of_row * self.rows.len();
                let ahead = Part { index: done, of }.chunk(self.ahead_lines);
                done += 1;
                let first = self.weights.wrapping_add(self.bytes + ahead.start * 64);
                let (place, ahead) = ([self.block, y, x], (first, ahead.len()));
                macro_rules! of {
                    ($($n:literal)*) => {
                        match of_tile.min(width - x) {
                            // SAFETY: the caller's. Larger tiles than registers hold are not
                            // compiled.
                            $($n if $n <= D::TILE[B - 1] => unsafe {
                                self.tile::<D, $n>(place, self.weights, ahead);
                            },)*
                            pixels => unreachable!("{pixels} pixels in a tile"),
                        }
                    };
                }
                of!(1 2 3 4 5 6 7 8 9 10 11 12);
            }
        }
    }
}

impl<const B: usize, const STRIDE: usize> Rows<'_, B, STRIDE> {
    /// Makes `N` neighbouring outputs of `B` blocks of channels.
    ///
    /// # Safety
    /// That of [`PackedKernel::run`]; they are inside the output.
    #[inline(always)]
    unsafe fn tile<D: Dots, const N: usize>(
        &self,
        [block, y, x]: [usize; 3],
        mut weights: *const u8,
        (ahead, ahead_lines): (*const u8, usize),
    ) {
        let Job { of, input, residual, activation, to, .. } = self.job;
        let ConvShape { channels_in, kernel, .. } = of.shape;
        let (row_pitch, line) = (input.row_pitch() * LANES, line_bytes::<D::Stored>(D::PER));
        let mut fetched = 0;
        // SAFETY: the caller's; taps of these pixels are inside the input and its border.
        unsafe {
            let mut sums = [[D::zero(); B]; N];
            for first in (0..channels_in).step_by(LANES) {
                let steps = LANES.min(channels_in - first).div_ceil(D::PER);
                let from: *const D::Stored =
                    input.tap(first / LANES, y * STRIDE, x * STRIDE, kernel / 2);
                for ky in 0..kernel {
                    for kx in 0..kernel {
                        let from = from.add(ky * row_pitch + kx * LANES);
                        for step in 0..steps {
                            if fetched < ahead_lines {
                                D::Lanes::fetch(ahead.wrapping_add(fetched * 64).cast());
                                fetched += 1;
                            }
                            let weight: [D::Weights; B] =
                                std::array::from_fn(|block| D::weights(weights.add(block * line)));
                            for (pixel, sums) in sums.iter_mut().enumerate() {
                                let value =
                                    D::values(from.add(pixel * STRIDE * LANES + step * D::PER));
                                for (sum, weight) in sums.iter_mut().zip(weight) {
                                    *sum = D::add(*sum, value, weight);
                                }
                            }
                            weights = weights.add(B * line);
                        }
                    }
                }
            }
            for k in 0..B {
                let factor = D::Lanes::load(of.factors[block + k].0.as_ptr());
                let bias = D::Lanes::load(of.bias[block + k].0.as_ptr());
                let at = to.at(block + k, y) + x * LANES;
                if let (Some(bytes), None) = (to.bytes(*activation), residual) {
                    // What most layers end in, without a question for every pixel.
                    let ends = bytes.after(factor, bias);
                    for (pixel, sums) in sums.iter().enumerate() {
                        bytes.store(D::whole(sums[k]), ends, at + pixel * LANES);
                    }
                    continue;
                }
                let residual = residual.map(|from| (from, from.at(block + k, y) + x * LANES));
                for (pixel, sums) in sums.iter().enumerate() {
                    let mut sum = D::whole(sums[k]).mul_add(factor, bias);
                    if let Some((from, at)) = residual {
                        sum = sum.add(from.load(at + pixel * LANES));
                    }
                    to.store(activated(sum, *activation), at + pixel * LANES);
                }
            }
        }
    }
}

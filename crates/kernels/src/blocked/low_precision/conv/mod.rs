//! Direct convolution of bf16 and quantised images.

use std::ops::Range;

use super::image::{LowPrecisionImage, LowPrecisionType};
use super::quantized_weights::QuantizedWeights;
use super::view::{DstView, SrcView, TensorView, TensorViewMut};
use crate::blocked::blocks::{block_groups, pad_to_blocks};
use crate::blocked::conv_shape::ConvShape;
use crate::blocked::image::Line;
use crate::blocked::lines::Lines;
use crate::blocked::thread_pool::{Part, ThreadPool};
use crate::blocked::tile::{Activation, activated};
use crate::simd::dots::{Bf16, DotProduct, ReducedPrecision, weight_vector_bytes};
use crate::simd::{LANES, Lanes, Level, ReducedDispatch as _, ReducedKernel};

/// Largest number of pixels of a tile of stride 2: the inputs of a wider one lie too far apart.
const MAX_STRIDE_2_TILE: usize = 8;
/// QuantizedWeights of a cache line.
const CACHE_LINE_BYTES: usize = size_of::<Line>();

/// A convolution with its weights packed in bf16 or int8.
#[derive(Debug, Clone)]
pub struct LowPrecisionConv {
    shape: ConvShape,
    level: Level,
    /// Element type of the input.
    input: LowPrecisionType,
    /// Blocks of output channels per group, which are computed at once: 2 or 1. An odd last block
    /// is a group of its own.
    blocks_per_group: usize,
    /// `[group][input block][ky][kx][channel step][block][16][channel]`; the innermost channels are
    /// those that one dot-product instruction adds up.
    weights: Lines,
    /// Scale and bias of the sums, per output channel.
    scales: Vec<Line>,
    bias: Vec<Line>,
}

impl LowPrecisionConv {
    /// Packs `weight`, `[channels_out][channels_in][kernel][kernel]`, and `bias`, `[channels_out]`,
    /// for inputs of type `input`.
    ///
    /// # Panics
    /// If either has another length, the stride is not 1 or 2, or the kernel is even.
    pub fn new(
        shape: ConvShape,
        weight: &[f32],
        bias: &[f32],
        input: LowPrecisionType,
        level: Level,
    ) -> Self {
        let ConvShape { channels_in, channels_out, stride, .. } = shape;
        let is_square = shape.square_side().is_some();
        assert!(matches!(stride, 1 | 2) && is_square, "a square kernel of stride 1 or 2");
        assert_eq!(weight.len(), channels_out * channels_in * shape.taps(), "weights");
        assert_eq!(bias.len(), channels_out, "bias");
        let blocks_per_group = if level.has_room_for_two_blocks() { 2 } else { 1 };
        let mut conv = Self {
            shape,
            level,
            input,
            blocks_per_group,
            weights: Lines::default(),
            scales: Vec::new(),
            bias: Vec::new(),
        };
        match input {
            LowPrecisionType::Bf16 => {
                let weight: Vec<Bf16> = weight.iter().map(|value| Bf16::nearest(*value)).collect();
                conv.pack::<Bf16>(&weight, Bf16::dot_depth(level));
                conv.scales = pad_to_blocks(&vec![1.0; channels_out]);
                conv.bias = pad_to_blocks(bias);
            }
            LowPrecisionType::Uint8(params) => {
                let quantized = QuantizedWeights::new(weight, bias, params);
                conv.pack::<u8>(&quantized.weight, u8::dot_depth(level));
                (conv.scales, conv.bias) =
                    (pad_to_blocks(&quantized.scales), pad_to_blocks(&quantized.bias));
            }
        }
        conv
    }

    /// Shape of the convolution.
    pub fn shape(&self) -> ConvShape {
        self.shape
    }

    fn block_groups(&self) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
        block_groups(self.shape.channels_out, self.blocks_per_group)
    }

    /// Packs the weights for dot products of `per` channels.
    fn pack<S: ReducedPrecision>(&mut self, weight: &[S::Weight], per: usize) {
        let ConvShape { channels_in, channels_out, .. } = self.shape;
        let taps = self.shape.taps();
        let mut all: Vec<Option<S::Weight>> = Vec::new();
        for blocks in self.block_groups() {
            for first in (0..channels_in).step_by(LANES) {
                let channels = LANES.min(channels_in - first);
                for tap in 0..taps {
                    for step in (first..first + channels).step_by(per) {
                        for channel_out in blocks.start * LANES..blocks.end * LANES {
                            all.extend((step..step + per).map(|channel_in| {
                                let exists = channel_out < channels_out && channel_in < channels_in;
                                let kernel = channel_out * channels_in + channel_in;
                                exists.then(|| weight[kernel * taps + tap])
                            }));
                        }
                    }
                }
            }
        }
        let bytes = all.len() * size_of::<S::Weight>();
        self.weights = Lines::zeros(bytes.div_ceil(size_of::<Line>()));
        let to: *mut S::Weight = self.weights.as_mut_ptr().cast();
        for (at, weight) in all.into_iter().enumerate() {
            if let Some(weight) = weight {
                // SAFETY: there is room for all; weights that do not exist stay zero.
                unsafe { to.add(at).write(weight) };
            }
        }
    }

    /// Writes `activation(conv(input) + residual)` to `output`.
    ///
    /// # Panics
    /// If an image has another size, the input has another element type than the weights were
    /// packed for, or its border is narrower than the padding.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: &LowPrecisionImage,
        residual: Option<TensorView<'_>>,
        activation: Activation,
        mut output: TensorViewMut<'_>,
    ) {
        let shape = self.shape;
        let [channels, height, width] = input.size();
        assert_eq!(channels, shape.channels_in, "channels of the input");
        assert_eq!(input.element_type(), self.input, "element type of the input");
        assert!(input.border() >= shape.border(), "a border as wide as the padding");
        let [rows, columns] = shape.output([height, width]);
        let size = [shape.channels_out, rows, columns];
        assert_eq!(output.size(), size, "size of the output");
        assert!(residual.is_none_or(|residual| residual.size() == size), "size of the residual");
        let residual = residual.map(|residual| residual.src());
        let exec = ConvExec { conv: self, input, residual, activation, size, to: output.dst() };
        match self.input {
            LowPrecisionType::Bf16 => exec.run::<Bf16>(thread_pool),
            LowPrecisionType::Uint8(_) => exec.run::<u8>(thread_pool),
        }
    }
}

/// Execution of a convolution on an image.
struct ConvExec<'a> {
    conv: &'a LowPrecisionConv,
    input: &'a LowPrecisionImage,
    residual: Option<SrcView>,
    activation: Activation,
    /// Channels, height and width of the output.
    size: [usize; 3],
    to: DstView,
}

/// Kernel for some rows of one group of `B` channel blocks. A type per combination, so that each is
/// compiled on its own: in one function with all of them, LLVM spills half of the accumulators.
struct GroupKernel<'a, const B: usize, const STRIDE: usize> {
    exec: &'a ConvExec<'a>,
    block: usize,
    rows: Range<usize>,
    /// Packed weights of the group.
    weights: *const u8,
    /// Their size in bytes.
    bytes: usize,
    /// Cache lines of the next group's weights to prefetch.
    prefetch_lines: usize,
}

impl ConvExec<'_> {
    fn run<S: crate::simd::ReducedDispatch>(&self, thread_pool: &ThreadPool) {
        let (rows, groups) = (self.size[1], self.conv.block_groups().len());
        thread_pool.run(&|part: Part| {
            // Split by channels if that balances, as each thread then reads only its own weights;
            // else by rows.
            let (groups, rows) = if groups.is_multiple_of(part.count) {
                (part.chunk(groups), 0..rows)
            } else {
                (0..groups, part.chunk(rows))
            };
            self.run_groups::<S>(groups, &rows);
        });
    }

    /// Runs the kernel of each group on some rows.
    fn run_groups<S: crate::simd::ReducedDispatch>(
        &self,
        groups: Range<usize>,
        rows: &Range<usize>,
    ) {
        let ConvShape { channels_in, stride, .. } = self.conv.shape;
        let per = S::dot_depth(self.conv.level);
        let steps = channels_in / LANES * (LANES / per) + (channels_in % LANES).div_ceil(per);
        let mut first = 0;
        for (group, blocks) in self.conv.block_groups().enumerate() {
            let bytes =
                steps * self.conv.shape.taps() * blocks.len() * weight_vector_bytes::<S>(per);
            if groups.contains(&group) {
                let all = size_of_val(&self.conv.weights[..]);
                let weights = self.conv.weights.as_ptr().cast::<u8>().wrapping_add(first);
                let prefetch_lines = bytes.min(all - first - bytes) / size_of::<Line>();
                let (block, rows) = (blocks.start, rows.clone());
                macro_rules! run {
                    ($b:literal, $stride:literal) => {{
                        let kernel = GroupKernel::<$b, $stride> {
                            exec: self,
                            block,
                            rows,
                            weights,
                            bytes,
                            prefetch_lines,
                        };
                        // SAFETY: sizes were compared, outputs of the parts are disjoint, and the
                        // level is one of this processor's.
                        unsafe { S::run(self.conv.level, &kernel) }
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

impl<S: ReducedPrecision, const B: usize, const STRIDE: usize> ReducedKernel<S>
    for GroupKernel<'_, B, STRIDE>
{
    #[inline(always)]
    unsafe fn run<D: DotProduct<Element = S>>(&self) {
        let [_, _, width] = self.exec.size;
        let tile = D::TILE[B - 1];
        let max_tile = if STRIDE == 2 { tile.min(MAX_STRIDE_2_TILE) } else { tile };
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
        let ConvExec { conv, input, residual, activation, to, .. } = self.exec;
        let ConvShape { channels_in, kernel: [kernel, _], .. } = conv.shape;
        let (row_pitch, line) =
            (input.row_pitch() * LANES, weight_vector_bytes::<D::Element>(D::DEPTH));
        let mut fetched = 0;
        // SAFETY: the caller's; the windows of these pixels are inside the input and its border.
        unsafe {
            let mut sums = [[D::zero(); B]; N];
            for first in (0..channels_in).step_by(LANES) {
                let steps = LANES.min(channels_in - first).div_ceil(D::DEPTH);
                let from: *const D::Element =
                    input.tap(first / LANES, y * STRIDE, x * STRIDE, kernel / 2);
                for ky in 0..kernel {
                    for kx in 0..kernel {
                        let from = from.add(ky * row_pitch + kx * LANES);
                        for step in 0..steps {
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
            for k in 0..B {
                let scale = D::Lanes::load(conv.scales[block + k].0.as_ptr());
                let bias = D::Lanes::load(conv.bias[block + k].0.as_ptr());
                let at = to.row_offset(block + k, y) + x * LANES;
                if let (Some(to), None) = (to.requantizing(*activation), residual) {
                    // The usual case, without a branch on the element type for every pixel.
                    let folded = to.fold(scale, bias);
                    for (pixel, sums) in sums.iter().enumerate() {
                        to.store(D::to_f32(sums[k]), folded, at + pixel * LANES);
                    }
                    continue;
                }
                let residual =
                    residual.map(|from| (from, from.row_offset(block + k, y) + x * LANES));
                for (pixel, sums) in sums.iter().enumerate() {
                    let mut sum = D::to_f32(sums[k]).mul_add(scale, bias);
                    if let Some((from, at)) = residual {
                        sum = sum.add(from.load(at + pixel * LANES));
                    }
                    to.store(activated(sum, *activation), at + pixel * LANES);
                }
            }
        }
    }
}

//! Direct convolution of bf16 and quantised images.
//!
//! Products are those of vector registers (`vectors`) or, on processors with AMX, of tiles
//! (`tiles`); weights are packed for the one that multiplies (`packing`).

mod arithmetic;
mod packing;
mod tiles;
mod vectors;

use std::ops::Range;

pub(super) use arithmetic::Arithmetic;

use super::image::{LowPrecisionImage, LowPrecisionType};
use super::quantized_weights::QuantizedWeights;
use super::view::{DstView, SrcView, TensorView, TensorViewMut};
use crate::blocked::blocks::{block_groups, pad_to_blocks, rows_by_group};
use crate::blocked::conv_shape::ConvShape;
use crate::blocked::image::Line;
use crate::blocked::tile::{Activation, activated};
use crate::blocked::{Part, ThreadPool};
use crate::simd::dots::{Bf16, weight_vector_bytes};
#[cfg(target_arch = "x86_64")]
use crate::simd::tiles::Amx;
#[cfg(test)]
use crate::simd::tiles::EmulatedTiles;
use crate::simd::tiles::{TileElement, TileUnit};
use crate::simd::{LANES, Lanes, Level, ReducedDispatch};
use packing::PackedWeights;
use tiles::TileKernel;
use vectors::GroupKernel;

/// A convolution with its weights packed in bf16 or int8.
#[derive(Debug, Clone)]
pub struct LowPrecisionConv {
    shape: ConvShape,
    level: Level,
    input: LowPrecisionType,
    /// Blocks of output channels per group, which are computed at once: 2 or 1. An odd last block
    /// is a group of its own.
    blocks_per_group: usize,
    arithmetic: Arithmetic,
    weights: PackedWeights,
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
        let arithmetic = match input {
            LowPrecisionType::Bf16 => Arithmetic::for_shape::<Bf16>(shape, level),
            LowPrecisionType::Uint8(_) => Arithmetic::for_shape::<u8>(shape, level),
        };
        Self::with_arithmetic(shape, weight, bias, input, level, arithmetic)
    }

    /// [`new`](Self::new), for a given unit of the processor.
    pub(super) fn with_arithmetic(
        shape: ConvShape,
        weight: &[f32],
        bias: &[f32],
        input: LowPrecisionType,
        level: Level,
        arithmetic: Arithmetic,
    ) -> Self {
        let ConvShape { channels_in, channels_out, stride, .. } = shape;
        let is_square = shape.square_side().is_some();
        assert!(matches!(stride, 1 | 2) && is_square, "a square kernel of stride 1 or 2");
        assert_eq!(weight.len(), channels_out * channels_in * shape.taps(), "weights");
        assert_eq!(bias.len(), channels_out, "bias");
        // Two blocks share each loaded pixel, where registers have room for their sums.
        let blocks_per_group = if level.has_room_for_two_blocks() { 2 } else { 1 };
        let groups = block_groups(channels_out, blocks_per_group);
        let (weights, scales, bias) = match input {
            LowPrecisionType::Bf16 => {
                let weight: Vec<Bf16> = weight.iter().map(|value| Bf16::nearest(*value)).collect();
                let depth = arithmetic.depth::<Bf16>(level);
                let weights = PackedWeights::new(shape, groups, arithmetic, depth, &weight);
                // Scales are of quantised weights alone.
                (weights, pad_to_blocks(&vec![1.0; channels_out]), pad_to_blocks(bias))
            }
            LowPrecisionType::Uint8(params) => {
                let quantized = QuantizedWeights::new(weight, bias, params);
                let depth = arithmetic.depth::<u8>(level);
                let weights =
                    PackedWeights::new(shape, groups, arithmetic, depth, &quantized.weight);
                (weights, pad_to_blocks(&quantized.scales), pad_to_blocks(&quantized.bias))
            }
        };
        Self { shape, level, input, blocks_per_group, arithmetic, weights, scales, bias }
    }

    /// Whether tiles of AMX multiply.
    pub fn uses_amx(&self) -> bool {
        self.arithmetic != Arithmetic::Vectors
    }

    /// Shape of the convolution.
    pub fn shape(&self) -> ConvShape {
        self.shape
    }

    fn block_groups(&self) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
        block_groups(self.shape.channels_out, self.blocks_per_group)
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

struct ConvExec<'a> {
    conv: &'a LowPrecisionConv,
    input: &'a LowPrecisionImage,
    residual: Option<SrcView>,
    activation: Activation,
    /// Channels, height and width of the output.
    size: [usize; 3],
    to: DstView,
}

impl ConvExec<'_> {
    fn run<S: ReducedDispatch + TileElement>(&self, thread_pool: &ThreadPool) {
        let (rows, groups) = (self.size[1], self.conv.block_groups().len());
        thread_pool.run(&|part: Part| {
            for (group, rows) in rows_by_group(part, groups, rows) {
                self.run_group::<S>(group, rows);
            }
        });
    }

    /// Runs the kernel of a group on some rows.
    fn run_group<S: ReducedDispatch + TileElement>(&self, group: usize, rows: Range<usize>) {
        let conv = self.conv;
        let block_bytes =
            conv.weights.steps * weight_vector_bytes::<S>(conv.arithmetic.depth::<S>(conv.level));
        let first_block = group * conv.blocks_per_group;
        let last_block = conv.shape.channels_out.div_ceil(LANES);
        let blocks = first_block..last_block.min(first_block + conv.blocks_per_group);
        let (first, bytes) = (block_bytes * first_block, block_bytes * blocks.len());
        let weights = conv.weights.lines.as_ptr().cast::<u8>().wrapping_add(first);
        match conv.arithmetic {
            Arithmetic::Vectors => {
                // Prefetching may go on into the next group's weights, not behind the last.
                let left = size_of_val(&conv.weights.lines[..]) - first - bytes;
                self.run_vectors::<S>(blocks, rows, weights, [bytes, left]);
            }
            #[cfg(target_arch = "x86_64")]
            Arithmetic::Amx => self.run_tiles::<S, Amx>(blocks, rows, weights),
            #[cfg(test)]
            Arithmetic::EmulatedAmx => self.run_tiles::<S, EmulatedTiles>(blocks, rows, weights),
        }
    }

    /// Runs the kernel of a group on vector registers. Its weights are `bytes` long, and `left`
    /// bytes of weights come after them.
    fn run_vectors<S: ReducedDispatch>(
        &self,
        blocks: Range<usize>,
        rows: Range<usize>,
        weights: *const u8,
        [bytes, left]: [usize; 2],
    ) {
        // No more than there are weights behind, and no more than a group has.
        let prefetch_lines = bytes.min(left) / size_of::<Line>();
        let block = blocks.start;
        // Literals, since blocks and strides are constants of the compiled kernels.
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
                // SAFETY: sizes were compared, outputs of the parts are disjoint, and the level is
                // one of this processor's.
                unsafe { S::run(self.conv.level, &kernel) }
            }};
        }
        match (blocks.len(), self.conv.shape.stride) {
            (1, 1) => run!(1, 1),
            (1, _) => run!(1, 2),
            (_, 1) => run!(2, 1),
            _ => run!(2, 2),
        }
    }

    /// Runs the kernel of a group on tiles.
    fn run_tiles<S: TileElement, U: TileUnit>(
        &self,
        blocks: Range<usize>,
        rows: Range<usize>,
        weights: *const u8,
    ) {
        let kernel = TileKernel::<S, U>::new(self, blocks, rows, weights);
        // SAFETY: sizes were compared, outputs of the parts are disjoint, and the level and the
        // unit are this processor's.
        unsafe { self.conv.level.run(&kernel) }
    }

    /// Stores the finished sums of `pixels` neighbouring pixels from row `y` and column `x` on, in
    /// a block of output channels: scale, bias, residual and activation.
    ///
    /// # Safety
    /// The pixels are inside the output, nobody else writes them, and the processor has the
    /// instructions of `V`.
    #[inline(always)]
    unsafe fn store<V: Lanes>(
        &self,
        block: usize,
        [y, x]: [usize; 2],
        pixels: usize,
        sum: impl Fn(usize) -> V,
    ) {
        let Self { conv, residual, activation, to, .. } = self;
        // SAFETY: the caller's.
        unsafe {
            let scale = V::load(conv.scales[block].0.as_ptr());
            let bias = V::load(conv.bias[block].0.as_ptr());
            let at = to.row_offset(block, y) + x * LANES;
            if let (Some(to), None) = (to.requantizing(*activation), residual) {
                // The usual case, without a branch on the element type for every pixel.
                let folded = to.fold(scale, bias);
                for pixel in 0..pixels {
                    to.store(sum(pixel), folded, at + pixel * LANES);
                }
                return;
            }
            let residual = residual.map(|from| (from, from.row_offset(block, y) + x * LANES));
            for pixel in 0..pixels {
                let mut sum = sum(pixel).mul_add(scale, bias);
                if let Some((from, at)) = residual {
                    sum = sum.add(from.load(at + pixel * LANES));
                }
                to.store(activated(sum, *activation), at + pixel * LANES);
            }
        }
    }
}

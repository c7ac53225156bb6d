//! Direct convolution in nChw16c.
//!
//! Outputs are computed in register tiles. Input channels are processed in chunks of blocks whose
//! weights stay in the L1 cache while all tiles of the image are updated; partial sums of a chunk
//! are stored in the output.

use std::ops::Range;

use super::blocks::{block_groups, pad_to_blocks, rows_by_group};
use super::conv_shape::ConvShape;
use super::image::{Image, Line};
use super::lines::Lines;
use super::nchw::NchwImage;
use super::pack::pack;
use super::tile::{AccumulatorInit, Activation, Epilogue, InputWindow, tile};
use super::views::{F32Dst, F32Src};
use super::{Part, ThreadPool};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Bytes of weights of a chunk of input channels: they stay in an L1 cache of 32 KiB beside the
/// inputs.
const L1_WEIGHT_BYTES: usize = 24 << 10;
/// Largest number of pixels of a tile of stride 2: the inputs of a wider one lie too far apart.
const MAX_STRIDE_2_TILE: usize = 8;

/// A convolution with its weights packed.
#[derive(Debug, Clone)]
pub struct Conv {
    shape: ConvShape,
    level: Level,
    /// Blocks of output channels per group, which are computed at once: 2 or 1. An odd last block
    /// is a group of its own.
    blocks_per_group: usize,
    /// `[group][input block][ky][kx][channel][block][16]`.
    weights: Lines,
    bias: Vec<Line>,
}

impl Conv {
    /// Packs `weight`, `[channels_out][channels_in][rows][columns]` of the kernel, and `bias`, `[channels_out]`.
    ///
    /// # Panics
    /// If either has another length, or the stride is not 1 or 2.
    pub fn new(shape: ConvShape, weight: &[f32], bias: &[f32], level: Level) -> Self {
        let ConvShape { channels_in, channels_out, stride, .. } = shape;
        let taps = shape.taps();
        assert!(matches!(stride, 1 | 2), "a stride of 1 or 2");
        assert_eq!(weight.len(), channels_out * channels_in * taps, "weights");
        assert_eq!(bias.len(), channels_out, "bias");
        let blocks_per_group = if level.has_room_for_two_blocks() { 2 } else { 1 };
        let bias = pad_to_blocks(bias);
        // `[input block][ky][kx][channel]`, the last block with as many channels as there are.
        let position = |channel_in: usize, tap: usize| {
            let first = channel_in / LANES * LANES;
            let channels = LANES.min(channels_in - first);
            first * taps + tap * channels + (channel_in - first)
        };
        let weights = pack(weight, [channels_out, channels_in, taps], blocks_per_group, position);
        Self { shape, level, blocks_per_group, weights, bias }
    }

    /// Shape of the convolution.
    pub fn shape(&self) -> ConvShape {
        self.shape
    }

    /// [`run`](Self::run) on an image in nchw of at most 16 channels, without a residual.
    ///
    /// # Panics
    /// As [`run`](Self::run), and if the input has more than 16 channels.
    pub fn run_nchw(
        &self,
        thread_pool: &ThreadPool,
        input: &NchwImage,
        activation: Activation,
        output: &mut Image,
    ) {
        let [channels, height, width] = input.size();
        assert!(channels == self.shape.channels_in && channels <= LANES, "channels of the input");
        assert_eq!(output.channels(), self.shape.channels_out, "channels of the output");
        assert!(input.border() >= self.shape.border(), "a border as wide as the padding");
        let size = self.shape.output([height, width]);
        assert_eq!([output.height(), output.width()], size, "size of the output");
        let (rows, dst) = (output.height(), output.dst());
        let src = input.src();
        thread_pool.run(&|part| {
            let rows = part.chunk(rows);
            let first = rows.start as isize;
            let src = src.with_first_row(first * self.shape.stride as isize);
            // SAFETY: sizes were compared, rows of the parts are disjoint, and the level is one of
            // this processor's.
            unsafe { self.rows(src, None, activation, dst.with_first_row(first), rows.len()) };
        });
    }

    /// Computes `rows` rows of all channels, from row 0 of `dst` on.
    ///
    /// # Safety
    /// The windows of these rows are readable, the rows writable, and those of the residual
    /// readable.
    pub(super) unsafe fn rows(
        &self,
        src: F32Src,
        residual: Option<F32Src>,
        activation: Activation,
        dst: F32Dst,
        rows: usize,
    ) {
        let exec = ConvExec { conv: self, src, residual, activation, dst };
        for group in 0..self.block_groups().len() {
            // SAFETY: the caller's.
            unsafe { exec.run(group, 0..rows) };
        }
    }

    fn block_groups(&self) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
        block_groups(self.shape.channels_out, self.blocks_per_group)
    }

    /// Writes `activation(conv(input) + residual)` to `output`.
    ///
    /// # Panics
    /// If an image has another size, or the border of the input is narrower than the padding.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: &Image,
        residual: Option<&Image>,
        activation: Activation,
        output: &mut Image,
    ) {
        let shape = self.shape;
        assert_eq!(input.channels(), shape.channels_in, "channels of the input");
        assert_eq!(output.channels(), shape.channels_out, "channels of the output");
        assert!(input.border() >= shape.border(), "a border as wide as the padding");
        let size = |image: &Image| [image.height(), image.width()];
        assert_eq!(size(output), shape.output(size(input)), "size of the output");
        assert!(residual.is_none_or(|residual| {
            size(residual) == size(output) && residual.channels() == shape.channels_out
        }));
        let (rows, groups) = (output.height(), self.block_groups().len());
        let (src, residual) = (input.src(), residual.map(Image::src));
        let dst = output.dst();
        thread_pool.run(&|part: Part| {
            let exec = ConvExec { conv: self, src, residual, activation, dst };
            for (group, rows) in rows_by_group(part, groups, rows) {
                // SAFETY: sizes were compared above, outputs of the parts are disjoint, and the level
                // is one of this processor's.
                unsafe { exec.run(group, rows) };
            }
        });
    }
}

/// Execution of a convolution.
struct ConvExec<'a> {
    conv: &'a Conv,
    src: F32Src,
    residual: Option<F32Src>,
    activation: Activation,
    dst: F32Dst,
}

/// Kernel for one group of `B` channel blocks, with `PIXEL` values from an input pixel to the next.
/// A type per combination, so that each is compiled on its own: in one function with all of them,
/// LLVM spills half of the accumulators.
struct GroupKernel<'a, const B: usize, const STRIDE: usize, const PIXEL: usize> {
    exec: &'a ConvExec<'a>,
    rows: Range<usize>,
    block_out: usize,
    /// Index of the first line of the group's weights.
    first: usize,
}

impl ConvExec<'_> {
    /// Runs the kernel of a group on some rows.
    ///
    /// # Safety
    /// The windows of these rows are readable, the rows writable by nobody else, and those of the
    /// residual readable; the level is one of this processor's.
    unsafe fn run(&self, group: usize, rows: Range<usize>) {
        let Conv { shape, blocks_per_group, .. } = *self.conv;
        let block_out = group * blocks_per_group;
        let blocks = blocks_per_group.min(shape.channels_out.div_ceil(LANES) - block_out);
        let first = shape.channels_in * shape.taps() * block_out;
        // Constants, so that the compiler unrolls each kernel.
        macro_rules! run {
            ($b:literal, $stride:literal, $pixel:expr) => {{
                let kernel =
                    GroupKernel::<$b, $stride, $pixel> { exec: self, rows, block_out, first };
                // SAFETY: the caller's.
                unsafe { self.conv.level.run(&kernel) }
            }};
        }
        match (blocks, shape.stride, self.src.is_nchw) {
            (1, 1, false) => run!(1, 1, LANES),
            (1, _, false) => run!(1, 2, LANES),
            (_, 1, false) => run!(2, 1, LANES),
            (_, _, false) => run!(2, 2, LANES),
            (1, 1, true) => run!(1, 1, 1),
            (1, _, true) => run!(1, 2, 1),
            (_, 1, true) => run!(2, 1, 1),
            (_, _, true) => run!(2, 2, 1),
        }
    }
}

impl<const B: usize, const STRIDE: usize, const PIXEL: usize> Kernel
    for GroupKernel<'_, B, STRIDE, PIXEL>
{
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let Self { exec, ref rows, block_out, first } = *self;
        let ConvShape { channels_in, kernel, padding, .. } = exec.conv.shape;
        let blocks_in = exec.conv.shape.blocks_in();
        let lines_per_block = exec.conv.shape.taps() * LANES * B;
        let block_bytes = lines_per_block * size_of::<Line>();
        // As many input blocks as have weights that fit in the L1 cache: all rows use them again.
        let chunk = (L1_WEIGHT_BYTES / block_bytes).clamp(1, blocks_in);
        let max_tile =
            if STRIDE == 2 { V::TILE[B - 1].min(MAX_STRIDE_2_TILE) } else { V::TILE[B - 1] };
        let width = exec.dst.width;
        // Tiles of a row of nearly the same width: a narrow last one would waste registers.
        let tile_width = width.div_ceil(width.div_ceil(max_tile));
        for block_in in (0..blocks_in).step_by(chunk) {
            let blocks = chunk.min(blocks_in - block_in);
            let is_last = block_in + blocks == blocks_in;
            let mut window = InputWindow {
                blocks,
                block_pitch: exec.src.block_pitch,
                // Only the last block has lanes without a channel, which are not multiplied.
                last_channels: if is_last { channels_in - (blocks_in - 1) * LANES } else { LANES },
                kernel,
                row_pitch: exec.src.row_pitch,
                channel_pitch: if exec.src.is_nchw { exec.src.block_pitch } else { 1 },
                prefetch: std::ptr::null(),
                prefetch_lines: 0,
            };
            let weights = &exec.conv.weights[first + block_in * lines_per_block..];
            let (weights, next) = weights.split_at(weights.len().min(blocks * lines_per_block));
            // The tiles of this chunk prefetch the weights of the next, each its share.
            let next = &next[..next.len().min(weights.len())];
            let weights = weights.as_ptr().cast::<f32>();
            let (tiles_per_row, mut tile) = (width.div_ceil(tile_width), 0);
            let bias = exec.conv.bias[block_out..].as_ptr().cast::<f32>();
            let init =
                // Later chunks go on with the sums that the output holds.
                if block_in == 0 { AccumulatorInit::Bias(bias) } else { AccumulatorInit::Dst };
            for y in rows.clone() {
                for x in (0..width).step_by(tile_width) {
                    let from = exec.src.corner(block_in, y * STRIDE, x * STRIDE, padding);
                    // SAFETY: the pixel is inside the output.
                    let to = unsafe { (exec.dst.pixel(block_out, y, x), exec.dst.block_pitch) };
                    // Residual and activation need the whole sum: the last chunk applies them.
                    let epilogue = is_last.then(|| Epilogue {
                        residual: exec
                            .residual
                            .map_or(std::ptr::null(), |image| image.tap(block_out, y, x, 0)),
                        residual_pitch: exec.residual.map_or(0, |image| image.block_pitch),
                        activation: exec.activation,
                    });
                    let pixels = tile_width.min(width - x);
                    let tiles = tiles_per_row * rows.len();
                    let share = Part { index: tile, count: tiles }.chunk(next.len());
                    let next = &next[share];
                    (window.prefetch, window.prefetch_lines) = (next.as_ptr().cast(), next.len());
                    tile += 1;
                    // SAFETY: the caller's; the windows of these pixels are inside the input and
                    // its border.
                    unsafe {
                        dispatch_tile::<V, B, STRIDE, PIXEL>(
                            pixels,
                            &window,
                            from,
                            weights,
                            init,
                            to,
                            epilogue.as_ref(),
                        );
                    }
                }
            }
        }
    }
}

/// Calls [`tile`] for `pixels` pixels.
///
/// # Safety
/// That of [`tile`]; there are at most twelve pixels.
#[inline(always)]
pub(super) unsafe fn dispatch_tile<
    V: Lanes,
    const B: usize,
    const STRIDE: usize,
    const PIXEL: usize,
>(
    pixels: usize,
    window: &InputWindow,
    from: *const f32,
    weights: *const f32,
    init: AccumulatorInit,
    to: (*mut f32, usize),
    epilogue: Option<&Epilogue>,
) {
    macro_rules! match_pixels {
        ($($n:literal)*) => {
            match pixels {
                // SAFETY: the caller's. Tiles that exceed the registers are not compiled.
                $($n if $n <= V::TILE[B - 1] => unsafe {
                    tile::<V, $n, B, STRIDE, PIXEL>(window, from, weights, init, to, epilogue);
                },)*
                _ => unreachable!("{pixels} pixels in a tile"),
            }
        };
    }
    match_pixels!(1 2 3 4 5 6 7 8 9 10 11 12);
}

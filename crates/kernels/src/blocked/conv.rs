//! Direct convolution of images in blocks of channels.
//!
//! Outputs are made a tile at a time, whose sums stay in registers; so many blocks of input
//! channels at a time that their weights stay in the nearest cache while the tiles of the image go
//! by.

use std::ops::Range;

use super::image::{Image, Input, Line};
use super::packing::{blocks_of, groups};
use super::planes::Planes;
use super::thread_pool::{Part, ThreadPool};
use super::tile::{Activation, End, Start, Taps, tile};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Bytes of weights that are used over and over again, of the nearest cache of 32 KiB.
const NEAREST: usize = 24 << 10;
/// Pixels of a tile of stride 2 at most: the inputs of more lie too far apart.
const TILE_OF_TWO: usize = 8;

/// Shape of a square convolution that keeps the image size, up to its stride.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConvShape {
    /// Channels of the input.
    pub channels_in: usize,
    /// Channels of the output.
    pub channels_out: usize,
    /// Rows and columns of the kernel; odd.
    pub kernel: usize,
    /// Pixels between outputs: 1 or 2.
    pub stride: usize,
}

impl ConvShape {
    /// Rows or columns of the output for so many of the input.
    pub fn output(&self, pixels: usize) -> usize {
        pixels.div_ceil(self.stride)
    }

    /// Zeros that the kernel sees beyond the image.
    pub fn padding(&self) -> usize {
        self.kernel / 2
    }

    fn blocks_in(&self) -> usize {
        self.channels_in.div_ceil(LANES)
    }
}

/// A convolution with its weights laid out for it.
#[derive(Debug, Clone)]
pub struct Conv {
    shape: ConvShape,
    level: Level,
    /// Blocks of output channels that are made together, 2 or 1; a last odd one is alone.
    together: usize,
    /// `[blocks together][input block][ky][kx][channel][block][16]`.
    weights: Vec<Line>,
    bias: Vec<Line>,
}

impl Conv {
    /// Lays `weight`, `[channels_out][channels_in][kernel][kernel]`, and `bias`, `[channels_out]`,
    /// out.
    ///
    /// # Panics
    /// If there are more or fewer, or the stride is not 1 or 2, or the kernel is even.
    pub fn new(shape: ConvShape, weight: &[f32], bias: &[f32], level: Level) -> Self {
        let ConvShape { channels_in, channels_out, kernel, stride } = shape;
        assert!(matches!(stride, 1 | 2) && kernel % 2 == 1, "a square kernel of stride 1 or 2");
        assert_eq!(weight.len(), channels_out * channels_in * kernel * kernel, "weights");
        assert_eq!(bias.len(), channels_out, "bias");
        let together = if level.holds_two() { 2 } else { 1 };
        let mut conv = Self { shape, level, together, weights: Vec::new(), bias: blocks_of(bias) };
        for blocks in conv.groups() {
            for channel_in_block in 0..shape.blocks_in() {
                let first = channel_in_block * LANES;
                let channels = LANES.min(channels_in - first);
                for tap in 0..kernel * kernel {
                    for channel_in in first..first + channels {
                        for block in blocks.clone() {
                            let mut line = Line::ZERO;
                            for (lane, value) in line.0.iter_mut().enumerate() {
                                let channel = block * LANES + lane;
                                if channel < channels_out {
                                    let row = channel * channels_in + channel_in;
                                    *value = weight[row * kernel * kernel + tap];
                                }
                            }
                            conv.weights.push(line);
                        }
                    }
                }
            }
        }
        conv
    }

    /// Its shape.
    pub fn shape(&self) -> ConvShape {
        self.shape
    }

    /// As [`run`](Self::run), of an image in planes, of at most sixteen.
    ///
    /// # Panics
    /// As there, and if there are more.
    pub fn run_planes(
        &self,
        thread_pool: &ThreadPool,
        input: &Planes,
        activation: Activation,
        output: &mut Image,
    ) {
        let [channels, height, width] = input.size();
        assert!(channels == self.shape.channels_in && channels <= LANES, "channels of the input");
        assert_eq!(output.channels(), self.shape.channels_out, "channels of the output");
        assert!(input.border() >= self.shape.padding(), "a border as wide as the padding");
        let size = [height, width].map(|side| self.shape.output(side));
        assert_eq!([output.height(), output.width()], size, "size of the output");
        let (rows, out) = (output.height(), Output::of(output));
        let input = Input::of_planes(input);
        thread_pool.run(&|part| {
            let rows = part.chunk(rows);
            let first = rows.start as isize;
            let input = input.beginning_at(first * self.shape.stride as isize);
            // SAFETY: sizes were compared, rows of the parts are disjoint, and the level is one of
            // this processor's.
            unsafe { self.rows(input, None, activation, out.beginning_at(first), rows.len()) };
        });
    }

    /// Writes so many rows from row 0 of `out` on, of all channels.
    ///
    /// # Safety
    /// Taps of these rows are readable, the rows writable, and those of the residual readable.
    pub(super) unsafe fn rows(
        &self,
        input: Input,
        residual: Option<Input>,
        activation: Activation,
        out: Output,
        rows: usize,
    ) {
        let groups = 0..self.groups().len();
        let work = Rows { conv: self, input, residual, activation, out, groups, rows: 0..rows };
        // SAFETY: the caller's.
        unsafe { work.run() };
    }

    fn groups(&self) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
        groups(self.shape.channels_out, self.together)
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
        assert!(input.border() >= shape.padding(), "a border as wide as the padding");
        let size = |image: &Image| [image.height(), image.width()];
        assert_eq!(size(output), size(input).map(|side| shape.output(side)), "size of the output");
        assert!(residual.is_none_or(|residual| {
            size(residual) == size(output) && residual.channels() == shape.channels_out
        }));
        let (rows, groups) = (output.height(), self.groups().len());
        let (input, residual) = (Input::of(input), residual.map(Input::of));
        let out = Output::of(output);
        thread_pool.run(&|part: Part| {
            // Every output belongs to one part.
            let (groups, rows) = if groups.is_multiple_of(part.count) {
                (part.chunk(groups), 0..rows)
            } else {
                (0..groups, part.chunk(rows))
            };
            let work = Rows { conv: self, input, residual, activation, out, groups, rows };
            // SAFETY: sizes were compared above, outputs of the parts are disjoint, and the level
            // is one of this processor's.
            unsafe { work.run() };
        });
    }
}

/// Where outputs go. Distances are in `f32`.
#[derive(Clone, Copy)]
pub(super) struct Output {
    pub(super) pixels: *mut f32,
    pub(super) row_pitch: usize,
    pub(super) block_pitch: usize,
    pub(super) width: usize,
}

impl Output {
    pub(super) fn of(image: &mut Image) -> Self {
        Self {
            pixels: image.first_mut(),
            row_pitch: image.row_pitch() * LANES,
            block_pitch: image.block_pitch() * LANES,
            width: image.width(),
        }
    }

    /// The same with another row as row 0.
    pub(super) fn beginning_at(self, row: isize) -> Self {
        let pixels = self.pixels.wrapping_offset(row * self.row_pitch as isize);
        Self { pixels, ..self }
    }

    /// A pixel of a block of channels.
    ///
    /// # Safety
    /// It is inside the image.
    #[inline(always)]
    pub(super) unsafe fn pixel(&self, block: usize, y: usize, x: usize) -> *mut f32 {
        let at = block * self.block_pitch + y * self.row_pitch + x * LANES;
        // SAFETY: the caller's.
        unsafe { self.pixels.add(at) }
    }
}

// SAFETY: each part of a parallel region writes its own pixels through it.
unsafe impl Send for Output {}
// SAFETY: as above.
unsafe impl Sync for Output {}

/// Some rows of some blocks of channels.
struct Rows<'a> {
    conv: &'a Conv,
    input: Input,
    residual: Option<Input>,
    activation: Activation,
    out: Output,
    groups: Range<usize>,
    rows: Range<usize>,
}

/// A group of `B` blocks of them, from an input of `PIXEL` values a pixel. Each kind of group is
/// compiled by itself: of one function for all, compilers leave half in memory.
struct Group<'a, const B: usize, const STRIDE: usize, const PIXEL: usize> {
    of: &'a Rows<'a>,
    block_out: usize,
    /// The line at which its weights begin.
    first: usize,
}

impl Rows<'_> {
    /// Makes them.
    ///
    /// # Safety
    /// Taps of these rows are readable, the rows writable by nobody else, and those of the residual
    /// readable; the level is one of this processor's.
    unsafe fn run(&self) {
        let mut first = 0;
        for (group, blocks) in self.conv.groups().enumerate() {
            let lines = self.conv.shape.channels_in * self.conv.shape.kernel.pow(2) * blocks.len();
            let block_out = blocks.start;
            macro_rules! run {
                ($b:literal, $stride:literal, $pixel:expr) => {{
                    let group = Group::<$b, $stride, $pixel> { of: self, block_out, first };
                    // SAFETY: the caller's.
                    unsafe { self.conv.level.run(&group) }
                }};
            }
            if self.groups.contains(&group) {
                match (blocks.len(), self.conv.shape.stride, self.input.is_planes) {
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
            first += lines;
        }
    }
}

impl<const B: usize, const STRIDE: usize, const PIXEL: usize> Kernel
    for Group<'_, B, STRIDE, PIXEL>
{
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let Self { of: rows, block_out, first } = *self;
        let ConvShape { channels_in, kernel, .. } = rows.conv.shape;
        let blocks_in = rows.conv.shape.blocks_in();
        let of_block = kernel * kernel * LANES * B;
        let at_once = (NEAREST / (of_block * size_of::<Line>())).clamp(1, blocks_in);
        let most = if STRIDE == 2 { V::TILE[B - 1].min(TILE_OF_TWO) } else { V::TILE[B - 1] };
        let width = rows.out.width;
        let of_tile = width.div_ceil(width.div_ceil(most));
        for block_in in (0..blocks_in).step_by(at_once) {
            let blocks = at_once.min(blocks_in - block_in);
            let is_last = block_in + blocks == blocks_in;
            let mut taps = Taps {
                blocks,
                block_pitch: rows.input.block_pitch,
                last_channels: if is_last { channels_in - (blocks_in - 1) * LANES } else { LANES },
                kernel,
                row_pitch: rows.input.row_pitch,
                channel_pitch: if rows.input.is_planes { rows.input.block_pitch } else { 1 },
                ahead: std::ptr::null(),
                ahead_lines: 0,
            };
            let weights = &rows.conv.weights[first + block_in * of_block..];
            let (weights, ahead) = weights.split_at(weights.len().min(blocks * of_block));
            let ahead = &ahead[..ahead.len().min(weights.len())];
            let weights = weights.as_ptr().cast::<f32>();
            let (of_row, mut tile) = (width.div_ceil(of_tile), 0);
            let bias = rows.conv.bias[block_out..].as_ptr().cast::<f32>();
            let start = if block_in == 0 { Start::Bias(bias) } else { Start::Output };
            for y in rows.rows.clone() {
                for x in (0..width).step_by(of_tile) {
                    let from = rows.input.tap(block_in, y * STRIDE, x * STRIDE, kernel / 2);
                    // SAFETY: the pixel is inside the output.
                    let to = unsafe { (rows.out.pixel(block_out, y, x), rows.out.block_pitch) };
                    let end = is_last.then(|| End {
                        residual: rows
                            .residual
                            .map_or(std::ptr::null(), |image| image.tap(block_out, y, x, 0)),
                        residual_pitch: rows.residual.map_or(0, |image| image.block_pitch),
                        activation: rows.activation,
                    });
                    let pixels = of_tile.min(width - x);
                    let ahead = &ahead
                        [Part { index: tile, count: of_row * rows.rows.len() }.chunk(ahead.len())];
                    (taps.ahead, taps.ahead_lines) = (ahead.as_ptr().cast(), ahead.len());
                    tile += 1;
                    // SAFETY: the caller's; taps of these pixels are inside the input and its
                    // border.
                    unsafe {
                        some::<V, B, STRIDE, PIXEL>(
                            pixels,
                            &taps,
                            from,
                            weights,
                            start,
                            to,
                            end.as_ref(),
                        );
                    }
                }
            }
        }
    }
}

/// A tile of so many pixels.
///
/// # Safety
/// That of [`tile`]; there are at most twelve.
#[inline(always)]
pub(super) unsafe fn some<V: Lanes, const B: usize, const STRIDE: usize, const PIXEL: usize>(
    pixels: usize,
    taps: &Taps,
    from: *const f32,
    weights: *const f32,
    start: Start,
    to: (*mut f32, usize),
    end: Option<&End>,
) {
    macro_rules! of {
        ($($n:literal)*) => {
            match pixels {
                // SAFETY: the caller's. Larger tiles than registers hold are not compiled.
                $($n if $n <= V::TILE[B - 1] => unsafe {
                    tile::<V, $n, B, STRIDE, PIXEL>(taps, from, weights, start, to, end);
                },)*
                _ => unreachable!("{pixels} pixels in a tile"),
            }
        };
    }
    of!(1 2 3 4 5 6 7 8 9 10 11 12);
}

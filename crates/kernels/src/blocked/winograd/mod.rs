//! Winograd's convolution for 3x3 kernels of stride 1: fewer multiplications for more additions.
//!
//! The inputs of a batch of tiles are transformed. Then, for each group of output channels, a GEMM
//! at every point of the Winograd domain sums over the input channels, and the sums are transformed
//! to outputs while they are in the cache.
//!
//! Transformed weights are 1.8 times (F(2, 3)) or 4 times (F(4, 3)) as large as the weights. Those
//! of small layers are transformed in advance and stay in the L2 cache. Those of large layers would
//! have to be read from memory for every image, which takes longer than the GEMM: they are stored
//! untransformed and transformed on the fly, a few input channels at a time, while the next are
//! prefetched.
//!
//! # Errors of rounding
//! Relative to the largest output, some 1e-5 with F(4, 3) and 2e-6 with F(2, 3).

#![allow(clippy::needless_range_loop, reason = "columns become rows")]

mod tiles;
mod transform;
mod weights;

use std::marker::PhantomData;

use super::blocks::{block_groups, pad_to_blocks};
use super::conv_shape::ConvShape;
use super::image::{Image, Line};
use super::lines::Lines;
use super::tile::Activation;
use super::views::F32Dst;
use super::{Part, ThreadPool};
use crate::cache::l2_share_bytes;
use crate::simd::{LANES, Level};
use tiles::{Tiles, pitch};
use transform::F2x3;
pub(crate) use transform::{F4x3, MAX_INPUTS, WinogradTransform};
use weights::WinogradWeights;

/// Share of an L2 cache for the scratch of a thread: it stays there beside a part of the weights.
const L2_SCRATCH_SHARE: f64 = 0.74;
/// Tiles per register tile of the GEMM on AVX-512; batches are multiples of it.
const TILE_BLOCK: usize = 12;

/// Outputs of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TileSize {
    /// F(2x2, 3x3): 16 multiplications instead of 36.
    Two,
    /// F(4x4, 3x3): 36 multiplications instead of 144.
    Four,
    /// F(2x4, 3x3), two rows of four: 24 multiplications instead of 72.
    TwoByFour,
}

/// A 3x3 convolution of stride 1 with its weights packed for Winograd's algorithm.
#[derive(Debug, Clone)]
pub struct Winograd {
    shape: ConvShape,
    level: Level,
    size: TileSize,
    /// Blocks of output channels per group, which are computed at once: 2 or 1. An odd last block
    /// is a group of its own.
    blocks_per_group: usize,
    weights: WinogradWeights,
    bias: Vec<Line>,
}

/// Scratch memory of layers, which grows to the size that the largest of them needs.
#[derive(Debug, Clone, Default)]
pub struct Scratch(Lines);

impl Scratch {
    /// Pointer to `lines` lines of unspecified content.
    pub(super) fn lines(&mut self, lines: usize) -> *mut Line {
        if self.0.len() < lines {
            self.0 = Lines::unspecified(lines);
        }
        self.0.as_mut_ptr()
    }
}

impl Winograd {
    /// Packs `weight`, `[channels_out][channels_in][3][3]`, and `bias`, `[channels_out]`.
    ///
    /// # Panics
    /// If either has another length.
    pub fn new(
        [channels_in, channels_out]: [usize; 2],
        weight: &[f32],
        bias: &[f32],
        size: TileSize,
        level: Level,
    ) -> Self {
        let shape = ConvShape::square(channels_in, channels_out, 3, 1);
        let are_large = Self::transforms_weights_on_the_fly(shape, size);
        Self::with_transform([channels_in, channels_out], weight, bias, size, level, are_large)
    }

    /// [`new`](Self::new) with a choice of when weights are transformed: in advance or on the fly.
    pub(super) fn with_transform(
        [channels_in, channels_out]: [usize; 2],
        weight: &[f32],
        bias: &[f32],
        size: TileSize,
        level: Level,
        is_on_the_fly: bool,
    ) -> Self {
        let shape = ConvShape::square(channels_in, channels_out, 3, 1);
        assert_eq!(weight.len(), channels_in * channels_out * 9, "weights");
        assert_eq!(bias.len(), channels_out, "bias");
        // Two blocks of channels share the loads of an input, if there are registers for their
        // sums.
        let blocks_per_group = if level.has_room_for_two_blocks() { 2 } else { 1 };
        let pack = match size {
            TileSize::Two => WinogradWeights::new::<F2x3, F2x3>,
            TileSize::Four => WinogradWeights::new::<F4x3, F4x3>,
            TileSize::TwoByFour => WinogradWeights::new::<F2x3, F4x3>,
        };
        let weights = pack(shape, blocks_per_group, weight, is_on_the_fly);
        Self { shape, level, size, blocks_per_group, weights, bias: pad_to_blocks(bias) }
    }

    /// Whether weights are transformed for every image, since the transformed ones exceed the L2 cache of
    /// this machine.
    pub fn transforms_weights_on_the_fly(shape: ConvShape, size: TileSize) -> bool {
        WinogradWeights::are_large(shape, size.points())
    }

    /// Shape of the convolution.
    pub fn shape(&self) -> ConvShape {
        self.shape
    }

    /// Size of its tiles.
    pub fn size(&self) -> TileSize {
        self.size
    }

    /// As [`Conv::run`](super::Conv::run).
    ///
    /// # Panics
    /// If an image has another size, or the border of the input is less than 1.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: &Image,
        residual: Option<&Image>,
        activation: Activation,
        output: &mut Image,
        scratch: &mut Scratch,
    ) {
        let size = |image: &Image| [image.height(), image.width()];
        assert_eq!(input.channels(), self.shape.channels_in, "channels of the input");
        assert_eq!(output.channels(), self.shape.channels_out, "channels of the output");
        assert_eq!(size(output), size(input), "size of the output");
        assert!(input.border() >= 1, "a border for the kernel");
        assert!(residual.is_none_or(|residual| {
            size(residual) == size(output) && residual.channels() == self.shape.channels_out
        }));
        let dst = output.dst();
        let exec = WinogradExec { conv: self, input, residual, activation, dst, size: size(input) };
        match self.size {
            TileSize::Two => exec.run::<F2x3, F2x3>(thread_pool, scratch),
            TileSize::Four => exec.run::<F4x3, F4x3>(thread_pool, scratch),
            TileSize::TwoByFour => exec.run::<F2x3, F4x3>(thread_pool, scratch),
        }
    }
}

/// Execution of a convolution on an image.
#[derive(Clone, Copy)]
struct WinogradExec<'a> {
    conv: &'a Winograd,
    input: &'a Image,
    residual: Option<&'a Image>,
    activation: Activation,
    dst: F32Dst,
    /// Height and width.
    size: [usize; 2],
}

/// Partition of an image into batches of tiles, and of the scratch among threads.
struct Batches<'a> {
    exec: WinogradExec<'a>,
    /// Tiles of the image, and per row.
    tiles: usize,
    columns: usize,
    /// Tiles per batch, and batches.
    batch: usize,
    count: usize,
    blocks_in: usize,
    /// Lines of transformed inputs, of sums, and of all that a thread has to itself but the inputs.
    input_lines: usize,
    sum_lines: usize,
    thread_lines: usize,
}

impl WinogradExec<'_> {
    fn run<R: WinogradTransform, C: WinogradTransform>(
        self,
        thread_pool: &ThreadPool,
        scratch: &mut Scratch,
    ) {
        let threads = thread_pool.threads();
        let batches = Batches::new::<R, C>(self, threads);
        let scratch = ScratchPtr(scratch.lines(batches.scratch_lines(threads)));
        if batches.is_single() {
            batches.run_single::<R, C>(thread_pool, &scratch);
        } else {
            batches.run_all::<R, C>(thread_pool, &scratch);
        }
    }
}

impl<'a> Batches<'a> {
    fn new<R: WinogradTransform, C: WinogradTransform>(
        exec: WinogradExec<'a>,
        threads: usize,
    ) -> Self {
        let [height, width] = exec.size;
        let [rows, columns] = [height.div_ceil(R::OUT), width.div_ceil(C::OUT)];
        let tiles = rows * columns;
        let Winograd { shape, blocks_per_group, weights, .. } = exec.conv;
        let blocks_in = shape.channels_in.div_ceil(LANES);
        let points = R::IN * C::IN;
        let lines_per_tile = points * (blocks_in + blocks_per_group);
        let scratch_lines =
            weights.scratch_bytes(l2_share_bytes(L2_SCRATCH_SHARE)) / size_of::<Line>();
        let max_batch = (scratch_lines / lines_per_tile).max(TILE_BLOCK);
        // A single batch is shared by the threads. Otherwise each thread gets as many batches.
        let count = match tiles.div_ceil(max_batch) {
            1 if tiles < 2 * threads * TILE_BLOCK || weights.is_on_the_fly() => 1,
            count => count.next_multiple_of(threads),
        };
        // Whole groups of tiles, so that only the last batch has a rest.
        let batch = tiles.div_ceil(count).next_multiple_of(TILE_BLOCK).min(tiles);
        let sum_lines = points * pitch(*blocks_per_group, batch);
        Self {
            exec,
            tiles,
            columns,
            batch,
            count: tiles.div_ceil(batch),
            blocks_in,
            input_lines: points * pitch(blocks_in, batch),
            sum_lines,
            thread_lines: sum_lines + weights.scratch_lines(),
        }
    }

    /// Whether all threads work on one batch and share its transformed inputs.
    fn is_single(&self) -> bool {
        self.count == 1
    }

    fn scratch_lines(&self, threads: usize) -> usize {
        if self.is_single() {
            self.input_lines + threads * self.thread_lines
        } else {
            threads * (self.input_lines + self.thread_lines)
        }
    }

    /// `count` tiles from `first` on, with the scratch of a thread.
    fn tiles<R, C>(
        &self,
        scratch: &ScratchPtr,
        thread: usize,
        first: usize,
        count: usize,
    ) -> Tiles<'a, R, C> {
        // A single batch is shared: threads have its inputs in common, and sums of their own.
        let (inputs, own) = if self.is_single() {
            (0, self.input_lines + thread * self.thread_lines)
        } else {
            let begin = thread * (self.input_lines + self.thread_lines);
            (begin, begin + self.input_lines)
        };
        // SAFETY: the scratch has the lines of all threads.
        let [inputs, sums, weight_scratch] =
            unsafe { [inputs, own, own + self.sum_lines].map(|line| scratch.at(line)) };
        let Self { exec, columns, blocks_in, .. } = *self;
        let transforms = PhantomData;
        Tiles { exec, columns, first, count, inputs, sums, weight_scratch, blocks_in, transforms }
    }

    /// Groups of output channels.
    fn groups(&self) -> usize {
        let Winograd { shape, blocks_per_group, .. } = self.exec.conv;
        block_groups(shape.channels_out, *blocks_per_group).len()
    }

    /// Runs a single batch: threads split its channels, with a barrier after the input transform.
    fn run_single<R: WinogradTransform, C: WinogradTransform>(
        &self,
        thread_pool: &ThreadPool,
        scratch: &ScratchPtr,
    ) {
        let (level, groups, threads) = (self.exec.conv.level, self.groups(), thread_pool.threads());
        thread_pool.run(&|part: Part| {
            let tiles = self.tiles::<R, C>(scratch, part.index, 0, self.tiles);
            // SAFETY: sizes were compared, parts write channel blocks of their own, and the level
            // is one of this processor's.
            unsafe { level.run(&tiles.input_transform(part.chunk(self.blocks_in))) };
        });
        // Groups that do not divide evenly among the threads are split into ranges of tiles.
        let splits = match self.tiles / TILE_BLOCK {
            _ if groups.is_multiple_of(threads) => 1,
            splits => splits.clamp(1, threads),
        };
        thread_pool.run(&|part: Part| {
            let all = self.tiles::<R, C>(scratch, part.index, 0, self.tiles);
            for unit in part.chunk(groups * splits) {
                let split = Part { index: unit % splits, count: splits }.chunk(self.tiles);
                // SAFETY: as above; sums are the thread's own, and outputs of the units disjoint.
                unsafe { level.run(&all.group_kernel(unit / splits, split)) };
            }
        });
    }

    /// Runs several batches: each thread takes whole batches, without barriers between them.
    fn run_all<R: WinogradTransform, C: WinogradTransform>(
        &self,
        thread_pool: &ThreadPool,
        scratch: &ScratchPtr,
    ) {
        let (level, groups) = (self.exec.conv.level, self.groups());
        thread_pool.run(&|part: Part| {
            for batch in part.chunk(self.count) {
                let first = batch * self.batch;
                let count = self.batch.min(self.tiles - first);
                let tiles = self.tiles::<R, C>(scratch, part.index, first, count);
                // SAFETY: as above; the scratch is this thread's.
                unsafe {
                    level.run(&tiles.input_transform(0..self.blocks_in));
                    for group in 0..groups {
                        level.run(&tiles.group_kernel(group, 0..tiles.count));
                    }
                }
            }
        });
    }
}

impl TileSize {
    /// Rows and columns.
    pub fn outputs(self) -> [usize; 2] {
        match self {
            Self::Two => [F2x3::OUT; 2],
            Self::Four => [F4x3::OUT; 2],
            Self::TwoByFour => [F2x3::OUT, F4x3::OUT],
        }
    }

    /// Multiplications per channel of input and output: points in the Winograd domain.
    pub fn points(self) -> usize {
        self.outputs().iter().map(|outputs| outputs + 2).product()
    }
}

/// Scratch of all threads.
struct ScratchPtr(*mut Line);

impl ScratchPtr {
    /// The scratch from a line on.
    ///
    /// # Safety
    /// The scratch has that many lines.
    unsafe fn at(&self, line: usize) -> *mut f32 {
        // SAFETY: the caller's.
        unsafe { self.0.add(line).cast() }
    }
}

// SAFETY: threads write ranges of their own.
unsafe impl Sync for ScratchPtr {}

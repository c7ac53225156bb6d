//! Winograd's convolution of 3x3 kernels of stride 1: fewer products for more additions.
//!
//! The inputs of all tiles are transformed. Then the outputs of one group of channels after the
//! other are made: products at every place of a tile, added up over the input channels, and
//! transformed back while they are still near.
//!
//! Transformed kernels are 1.8 or 4 times as large as the kernels. Those of small layers are
//! transformed once and stay in the second cache. Those of large layers would come from memory for
//! every image, which takes longer than the products: they are kept as they are, and transformed a
//! few channels at a time where they are used, while the next ones are fetched.
//!
//! Rounding: outputs of `F(4, 3)` are off by some 1e-5 of the largest, of `F(2, 3)` by 2e-6.

#![allow(clippy::needless_range_loop, reason = "columns become rows")]

mod kernels;
mod tiles;

use std::marker::PhantomData;

use super::conv::{ConvShape, Output};
use super::image::{Image, Line};
use super::packing::{blocks_of, groups};
use super::scheme::{Four, Scheme, Two};
use super::thread_pool::{Part, ThreadPool};
use super::tile::Activation;
use crate::simd::{LANES, Level};
use kernels::Kernels;
use tiles::{Tiles, pitch};

/// Bytes of what lies between the transforms, of a second cache of 1 MiB.
const SECOND: usize = 760 << 10;
/// Tiles that are multiplied at once.
const TOGETHER: usize = 12;

/// Outputs of a tile along one side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TileSize {
    /// `F(2, 3)`: 16 products instead of 36.
    Two,
    /// `F(4, 3)`: 36 products instead of 144.
    Four,
}

/// A 3x3 convolution of stride 1 with its weights laid out for tiles.
#[derive(Debug, Clone)]
pub struct Winograd {
    shape: ConvShape,
    level: Level,
    size: TileSize,
    /// Blocks of output channels that are made together; a last odd one is alone.
    together: usize,
    kernels: Kernels,
    bias: Vec<Line>,
}

/// Memory between the transforms, which grows to what the largest layer asks for.
#[derive(Debug, Clone, Default)]
pub struct Scratch(Vec<Line>);

impl Scratch {
    /// So many lines, whatever they hold.
    pub(super) fn lines(&mut self, lines: usize) -> *mut Line {
        if self.0.len() < lines {
            self.0.resize(lines, Line::ZERO);
        }
        self.0.as_mut_ptr()
    }
}

impl Winograd {
    /// Lays `weight`, `[channels_out][channels_in][3][3]`, and `bias`, `[channels_out]`, out.
    ///
    /// # Panics
    /// If there are more or fewer.
    pub fn new(
        [channels_in, channels_out]: [usize; 2],
        weight: &[f32],
        bias: &[f32],
        size: TileSize,
        level: Level,
    ) -> Self {
        let shape = ConvShape { channels_in, channels_out, kernel: 3, stride: 1 };
        let are_large = Kernels::are_large(shape, size.inputs());
        Self::of([channels_in, channels_out], weight, bias, size, level, are_large)
    }

    /// As [`new`](Self::new), with kernels that are kept plain, or not.
    pub(super) fn of(
        [channels_in, channels_out]: [usize; 2],
        weight: &[f32],
        bias: &[f32],
        size: TileSize,
        level: Level,
        is_plain: bool,
    ) -> Self {
        let shape = ConvShape { channels_in, channels_out, kernel: 3, stride: 1 };
        assert_eq!(weight.len(), channels_in * channels_out * 9, "weights");
        assert_eq!(bias.len(), channels_out, "bias");
        let together = if level.holds_two() { 2 } else { 1 };
        let kernels = match size {
            TileSize::Two => Kernels::new::<Two>(shape, together, weight, is_plain),
            TileSize::Four => Kernels::new::<Four>(shape, together, weight, is_plain),
        };
        Self { shape, level, size, together, kernels, bias: blocks_of(bias) }
    }

    /// Its shape.
    pub fn shape(&self) -> ConvShape {
        self.shape
    }

    /// Its tiles.
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
        let out = Output::of(output);
        let job = Job { of: self, input, residual, activation, out, size: size(input) };
        match self.size {
            TileSize::Two => job.run::<Two>(thread_pool, scratch),
            TileSize::Four => job.run::<Four>(thread_pool, scratch),
        }
    }
}

/// A convolution of an image.
#[derive(Clone, Copy)]
struct Job<'a> {
    of: &'a Winograd,
    input: &'a Image,
    residual: Option<&'a Image>,
    activation: Activation,
    out: Output,
    size: [usize; 2],
}

impl Job<'_> {
    fn run<S: Scheme>(self, thread_pool: &ThreadPool, scratch: &mut Scratch) {
        let [rows, columns] = self.size.map(|side| side.div_ceil(S::OUT));
        let (tiles, threads) = (rows * columns, thread_pool.threads());
        let shape = self.of.shape;
        let blocks_in = shape.channels_in.div_ceil(LANES);
        let places = S::IN * S::IN;
        let of_tile = places * (blocks_in + self.of.together);
        let most = (self.of.kernels.between(SECOND) / size_of::<Line>() / of_tile).max(TOGETHER);
        // As many rounds for each thread, if there are any rounds.
        let rounds = match tiles.div_ceil(most) {
            1 if tiles < 2 * threads * TOGETHER || self.of.kernels.is_plain() => 1,
            rounds => rounds.next_multiple_of(threads),
        };
        let at_once = tiles.div_ceil(rounds).next_multiple_of(TOGETHER).min(tiles);
        let rounds = tiles.div_ceil(at_once);
        let is_shared = rounds == 1;
        let inputs = places * pitch(blocks_in, at_once);
        let sums = places * pitch(self.of.together, at_once);
        let own = sums + self.of.kernels.scratch_lines();
        let lines = if is_shared { inputs + threads * own } else { threads * (inputs + own) };
        let between = Between(scratch.lines(lines));
        // SAFETY of all: there are as many lines as all threads ask for.
        let work = |thread: usize, first: usize, count: usize| {
            let (from, own_from) = if is_shared {
                (0, inputs + thread * own)
            } else {
                (thread * (inputs + own), thread * (inputs + own) + inputs)
            };
            let (inputs, sums, kernels) =
                unsafe { (between.at(from), between.at(own_from), between.at(own_from + sums)) };
            let scheme = PhantomData::<S>;
            Tiles { job: self, columns, first, count, inputs, sums, kernels, blocks_in, scheme }
        };
        let groups = groups(shape.channels_out, self.of.together).len();
        if is_shared {
            thread_pool.run(&|part: Part| {
                let tiles = work(part.index, 0, tiles);
                // SAFETY: sizes were compared, parts write blocks of their own, and the level is
                // one of this processor's.
                unsafe { self.of.level.run(&tiles.taking(part.chunk(blocks_in))) };
            });
            // Each thread makes its groups; where there are too few, only some of the tiles of
            // each.
            let splits = match tiles / TOGETHER {
                _ if groups.is_multiple_of(threads) => 1,
                splits => splits.clamp(1, threads),
            };
            thread_pool.run(&|part: Part| {
                let all = work(part.index, 0, tiles);
                for unit in part.chunk(groups * splits) {
                    let split = Part { index: unit % splits, count: splits }.chunk(tiles);
                    // SAFETY: as above; sums are the thread's own, and outputs of the units
                    // disjoint.
                    unsafe { self.of.level.run(&all.making(unit / splits, split)) };
                }
            });
            return;
        }
        thread_pool.run(&|part: Part| {
            for round in part.chunk(rounds) {
                let first = round * at_once;
                let tiles = work(part.index, first, at_once.min(tiles - first));
                // SAFETY: as above; all of the scratch is this thread's.
                unsafe {
                    self.of.level.run(&tiles.taking(0..blocks_in));
                    for group in 0..groups {
                        self.of.level.run(&tiles.making(group, 0..tiles.count));
                    }
                }
            }
        });
    }
}

impl TileSize {
    fn inputs(self) -> usize {
        match self {
            Self::Two => Two::IN,
            Self::Four => Four::IN,
        }
    }
}

/// The scratch of all threads.
struct Between(*mut Line);

impl Between {
    /// What begins at a line.
    ///
    /// # Safety
    /// There are so many lines.
    unsafe fn at(&self, line: usize) -> *mut f32 {
        // SAFETY: the caller's.
        unsafe { self.0.add(line).cast() }
    }
}

// SAFETY: threads write what is theirs.
unsafe impl Sync for Between {}

//! Winograd's convolution of 3x3 kernels of stride 1: fewer products for more additions.
//!
//! Tiles of outputs are transformed, multiplied as one matrix product for each of their places, and
//! transformed back. Of a large image so many tiles are taken at a time that what lies between the
//! transforms stays in the second cache, and each thread takes its own; of a small one the threads
//! share every step.
//!
//! Rounding: outputs of `F(4, 3)` are off by some 1e-5 of the largest, of `F(2, 3)` by 2e-6.

#![allow(clippy::needless_range_loop, reason = "columns become rows")]

mod tiles;

use std::marker::PhantomData;
use std::ops::Range;

use super::conv::{ConvShape, Output};
use super::image::{Image, Line};
use super::packing::{blocks_of, groups};
use super::scheme::{Four, MOST, Scheme, Two};
use super::team::{Part, Team};
use super::tile::Activation;
use crate::simd::{LANES, Level};
use tiles::{Step, Tiles};

/// Bytes between the transforms, of a second cache of 1 MiB.
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

/// A 3x3 convolution of stride 1 with its weights transformed.
#[derive(Debug, Clone)]
pub struct Winograd {
    shape: ConvShape,
    level: Level,
    size: TileSize,
    /// Blocks of output channels that are made together; a last odd one is alone.
    together: usize,
    /// `[place][blocks together][input channel][block][16]`.
    weights: Vec<Line>,
    bias: Vec<Line>,
}

/// Memory between the transforms, which grows to what the largest layer asks for.
#[derive(Debug, Clone, Default)]
pub struct Scratch(Vec<Line>);

impl Winograd {
    /// Transforms `weight`, `[channels_out][channels_in][3][3]`; `bias` is `[channels_out]`.
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
        assert_eq!(weight.len(), channels_in * channels_out * 9, "weights");
        assert_eq!(bias.len(), channels_out, "bias");
        let together = if level.holds_two() { 2 } else { 1 };
        let transformed = match size {
            TileSize::Two => transformed::<Two>(weight),
            TileSize::Four => transformed::<Four>(weight),
        };
        let places = size.inputs().pow(2);
        let mut weights = Vec::new();
        for place in 0..places {
            for blocks in groups(channels_out, together) {
                for channel_in in 0..channels_in {
                    for block in blocks.clone() {
                        let mut line = Line::ZERO;
                        for (lane, value) in line.0.iter_mut().enumerate() {
                            let channel = block * LANES + lane;
                            if channel < channels_out {
                                let kernel = channel * channels_in + channel_in;
                                *value = transformed[kernel * places + place];
                            }
                        }
                        weights.push(line);
                    }
                }
            }
        }
        Self { shape, level, size, together, weights, bias: blocks_of(bias) }
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
        team: &Team,
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
        match self.size {
            TileSize::Two => {
                self.with::<Two>(team, input, residual, activation, out, size(input), scratch);
            }
            TileSize::Four => {
                self.with::<Four>(team, input, residual, activation, out, size(input), scratch);
            }
        }
    }

    #[allow(clippy::too_many_arguments, reason = "those of `run`")]
    fn with<S: Scheme>(
        &self,
        team: &Team,
        input: &Image,
        residual: Option<&Image>,
        activation: Activation,
        out: Output,
        [height, width]: [usize; 2],
        scratch: &mut Scratch,
    ) {
        let [rows, columns] = [height, width].map(|side| side.div_ceil(S::OUT));
        let tiles = rows * columns;
        let (blocks_in, blocks_out) =
            (self.shape.channels_in.div_ceil(LANES), self.shape.channels_out.div_ceil(LANES));
        let lines_of_tile = S::IN * S::IN * (blocks_in + blocks_out);
        let most = (SECOND / size_of::<Line>() / lines_of_tile).max(TOGETHER);
        // As many rounds for each thread, if there are any rounds.
        let threads = team.threads();
        let rounds = match tiles.div_ceil(most) {
            1 if tiles < 2 * threads * TOGETHER => 1,
            rounds => rounds.next_multiple_of(threads),
        };
        let at_once = tiles.div_ceil(rounds).next_multiple_of(TOGETHER).min(tiles);
        let rounds = tiles.div_ceil(at_once);
        let lines = lines_of_tile * at_once;
        let is_shared = rounds == 1;
        let copies = if is_shared { 1 } else { threads };
        if scratch.0.len() < copies * lines {
            scratch.0.resize(copies * lines, Line::ZERO);
        }
        let scratch = Between { first: scratch.0.as_mut_ptr().cast(), lines };
        let work = |part: Part, copy: usize, tiles: Range<usize>, step: Step| Tiles {
            of: self,
            input,
            residual,
            activation,
            out,
            size: [height, width],
            columns,
            tiles,
            part,
            step,
            inputs: scratch.of(copy),
            blocks: [blocks_in, blocks_out],
            scheme: PhantomData::<S>,
        };
        if is_shared {
            for step in [Step::Inputs, Step::Products, Step::Outputs] {
                team.run(&|part| {
                    let work = work(part, 0, 0..tiles, step);
                    // SAFETY: sizes were compared, what parts write is disjoint, and steps follow one
                    // another.
                    unsafe { self.level.run(&work) };
                });
            }
            return;
        }
        team.run(&|part| {
            for round in part.share(rounds) {
                let tiles = round * at_once..tiles.min((round + 1) * at_once);
                for step in [Step::Inputs, Step::Products, Step::Outputs] {
                    let whole = Part { index: 0, of: 1 };
                    let work = work(whole, part.index, tiles.clone(), step);
                    // SAFETY: as above; the copy of the scratch is this thread's.
                    unsafe { self.level.run(&work) };
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

/// Kernels of 3x3 as `[kernel][place]`, in double precision up to the end.
fn transformed<S: Scheme>(weight: &[f32]) -> Vec<f32> {
    let (kernels, _) = weight.as_chunks::<9>();
    let mut all = Vec::with_capacity(kernels.len() * S::IN * S::IN);
    for kernel in kernels {
        let tap = |y: usize, x: usize| f64::from(kernel[3 * y + x]);
        let columns: [[f64; MOST]; 3] =
            std::array::from_fn(|x| S::taps(std::array::from_fn(|y| tap(y, x))));
        for y in 0..S::IN {
            let row = S::taps(std::array::from_fn(|x| columns[x][y]));
            all.extend(row[..S::IN].iter().map(|value| *value as f32));
        }
    }
    all
}

/// The scratch of all threads.
struct Between {
    first: *mut f32,
    lines: usize,
}

impl Between {
    /// That of a thread.
    fn of(&self, thread: usize) -> *mut f32 {
        // SAFETY: there are as many as threads that ask for one.
        unsafe { self.first.add(thread * self.lines * LANES) }
    }
}

// SAFETY: threads write what is theirs.
unsafe impl Sync for Between {}

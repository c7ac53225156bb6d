//! Winograd's convolution of 3x3 kernels of stride 1, over the tiles of a whole batch.
//!
//! As [`blocked::Winograd`](crate::blocked::Winograd) does it for one image. Each thread takes so
//! many tiles at a time that what lies between the transforms stays in its second cache.

use std::marker::PhantomData;
use std::ops::Range;

use rayon::prelude::*;

use super::blocks::Blocks;
use super::gather::Gather;
use super::norm::{NormalizedInput, ScaleShift};
use super::padded::Padded;
use super::shape::blocks_at_once;
use super::weights::Weights;
use crate::blocked::{F4x3, Line, MAX_INPUTS, WinogradTransform, pad_to_blocks};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Bytes between the transforms.
const SECOND: usize = 1 << 20;
/// Tiles that are multiplied at once.
const TOGETHER: usize = 12;

/// The scheme of all layers.
pub(super) type Chosen = F4x3;

/// The tiles of a batch.
#[derive(Clone, Copy)]
pub(super) struct Tiles {
    pub(super) shape: Blocks,
    /// Rows and columns of tiles of an image.
    pub(super) rows: usize,
    pub(super) columns: usize,
}

impl Tiles {
    pub(super) fn new<S: WinogradTransform>(shape: Blocks) -> Self {
        let [rows, columns] = [shape.height, shape.width].map(|side| side.div_ceil(S::OUT));
        Self { shape, rows, columns }
    }

    pub(super) fn count(&self) -> usize {
        self.shape.batch * self.rows * self.columns
    }

    /// Image, first row and first column of a tile.
    #[inline(always)]
    pub(super) fn place<S: WinogradTransform>(&self, tile: usize) -> [usize; 3] {
        let (image, rest) = (tile / (self.rows * self.columns), tile % (self.rows * self.columns));
        [image, rest / self.columns * S::OUT, rest % self.columns * S::OUT]
    }
}

/// The convolution of `input`, of `shape`.
pub(super) fn convolved(
    shape: Blocks,
    input: NormalizedInput<'_>,
    weights: Weights<'_>,
    bias: Option<&[f32]>,
    level: Level,
) -> Vec<f32> {
    let [channels_out, _] = weights.channels();
    // Transformed once for all tiles and images.
    let weights = weights.transformed::<Chosen>(blocks_at_once(level), level);
    let out = Blocks { channels: channels_out, ..shape };
    let mut output = vec![0.0; out.value_count()];
    let tiles = Tiles::new::<Chosen>(shape);
    let count = tiles.count();
    let of_tile = Chosen::IN * Chosen::IN * (shape.blocks() + out.blocks());
    // As many rounds for each thread. How tiles are shared out does not change any sum.
    let most = (SECOND / size_of::<Line>() / of_tile.max(1)).max(TOGETHER);
    let rounds = count.div_ceil(most).next_multiple_of(rayon::current_num_threads());
    let at_once = count.div_ceil(rounds.max(1)).next_multiple_of(TOGETHER);
    let bias = bias.map(pad_to_blocks);
    let to = Target(output.as_mut_ptr());
    (0..count.div_ceil(at_once.max(1))).into_par_iter().for_each_init(
        Padded::default,
        |scratch, round| {
            let range = round * at_once..count.min((round + 1) * at_once);
            let mut work = Round {
                tiles,
                step: Step::Inputs,
                out,
                input,
                weights: &weights,
                bias: bias.as_deref(),
                blocks_at_once: blocks_at_once(level),
                scratch: scratch.room(of_tile * range.len()).as_mut_ptr().cast(),
                range,
                to: &to,
                scheme: PhantomData::<Chosen>,
            };
            // SAFETY: tiles of rounds are disjoint and there is room for what they transform.
            unsafe {
                // Inputs, products, outputs: all of a round's data stay in the cache.
                level.run(&work);
                for place in 0..Chosen::IN * Chosen::IN {
                    level.run(&work.products(place));
                }
                work.step = Step::Outputs;
                level.run(&work);
            }
        },
    );
    output
}

/// The output of all rounds.
struct Target(*mut f32);

// SAFETY: each round writes the pixels of its own tiles.
unsafe impl Sync for Target {}

/// Some tiles, from inputs to outputs.
struct Round<'a, S> {
    tiles: Tiles,
    out: Blocks,
    input: NormalizedInput<'a>,
    /// Of every place, see [`Weights::transformed`].
    weights: &'a [Line],
    bias: Option<&'a [Line]>,
    blocks_at_once: usize,
    range: Range<usize>,
    /// `[block][place][tile][16]` of the inputs, and behind them the same of the outputs.
    scratch: *mut f32,
    to: &'a Target,
    step: Step,
    scheme: PhantomData<S>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Inputs,
    Outputs,
}

impl<S: WinogradTransform> Kernel for Round<'_, S> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        // SAFETY: the caller's; inputs and outputs of all places are in the scratch.
        unsafe {
            match self.step {
                Step::Inputs => {
                    for block in 0..self.tiles.shape.blocks() {
                        let to = self.scratch.add(block * self.block_pitch());
                        let line = self.input.block_norm(block);
                        let (from, line) = (self.input.values, line.as_ref());
                        take::<V, S>(&self.tiles, self.range.clone(), block, from, line, to);
                    }
                }
                Step::Outputs => {
                    for block in 0..self.out.blocks() {
                        self.give::<V>(block, self.outputs().add(block * self.block_pitch()));
                    }
                }
            }
        }
    }
}

impl<S: WinogradTransform> Round<'_, S> {
    /// From a block between the transforms to the next.
    fn block_pitch(&self) -> usize {
        S::IN * S::IN * self.range.len() * LANES
    }

    fn outputs(&self) -> *mut f32 {
        // SAFETY: both are in the same memory.
        unsafe { self.scratch.add(self.tiles.shape.blocks() * self.block_pitch()) }
    }

    /// The products of a place.
    fn products(&self, place: usize) -> Gather<'_> {
        let count = self.range.len();
        let of_place = self.weights.len() / (S::IN * S::IN);
        Gather {
            taps: &[0],
            channels: self.tiles.shape.channels,
            block_pitch: self.block_pitch(),
            from_pitch: [LANES, 0, 0],
            weights: &self.weights[place * of_place..],
            bias: None,
            channels_out: self.out.channels,
            blocks_at_once: self.blocks_at_once,
            block_pitch_out: self.block_pitch(),
            size: [count, 1, 1],
            to_pitch: [LANES, 0, 0],
            // SAFETY: places are in the scratch.
            from: unsafe { self.scratch.add(place * count * LANES) },
            // SAFETY: as above.
            to: unsafe { self.outputs().add(place * count * LANES) },
        }
    }

    /// Transforms outputs of a block back.
    ///
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn give<V: Lanes>(&self, block: usize, from: *const f32) {
        let Blocks { height, width, .. } = self.out;
        let pitch = self.range.len() * LANES;
        // SAFETY: pixels of a tile that are written are inside of the output.
        unsafe {
            let bias = self.bias.map_or(V::splat(0.0), |bias| V::load(bias[block].0.as_ptr()));
            for (k, tile) in self.range.clone().enumerate() {
                let [image, y0, x0] = self.tiles.place::<S>(tile);
                let from = from.add(k * LANES);
                let at = image * self.out.image() + block * self.out.block();
                let to = self.to.0.add(at + (y0 * width + x0) * LANES);
                let mut halves = [[V::splat(0.0); 4]; MAX_INPUTS];
                for (x, half) in halves.iter_mut().enumerate().take(S::IN) {
                    let mut m = [V::splat(0.0); MAX_INPUTS];
                    for (y, m) in m.iter_mut().enumerate().take(S::IN) {
                        *m = V::load(from.add((y * S::IN + x) * pitch));
                    }
                    *half = S::output(m);
                }
                // Tiles at the border reach beyond the output.
                for y in 0..S::OUT.min(height - y0) {
                    let row = S::output(std::array::from_fn(|x| halves[x][y]));
                    for (x, value) in row.iter().enumerate().take(S::OUT.min(width - x0)) {
                        value.add(bias).store(to.add((y * width + x) * LANES));
                    }
                }
            }
        }
    }
}

/// Transforms inputs of a block of tiles, to `[place][tile][16]`.
///
/// # Safety
/// The processor has the instructions of `V`; values are those of the tiles; there is room.
#[inline(always)]
pub(super) unsafe fn take<V: Lanes, S: WinogradTransform>(
    tiles: &Tiles,
    range: Range<usize>,
    block: usize,
    values: &[f32],
    line: Option<&ScaleShift>,
    to: *mut f32,
) {
    let shape = tiles.shape;
    let pitch = range.len() * LANES;
    // SAFETY: pixels that are read are inside of the image; what is written has room.
    unsafe {
        let zero = V::splat(0.0);
        let norm = line.map(|line| {
            let [scale, offset] = [&line.scale, &line.offset].map(|it| V::load(it.as_ptr()));
            (scale, offset, V::splat(line.min), V::splat(line.max))
        });
        for (k, tile) in range.enumerate() {
            let [image, y0, x0] = tiles.place::<S>(tile);
            let from = values[image * shape.image() + block * shape.block()..].as_ptr();
            let to = to.add(k * LANES);
            let mut columns = [[zero; MAX_INPUTS]; MAX_INPUTS];
            for (x, column) in columns.iter_mut().enumerate().take(S::IN) {
                let mut d = [zero; MAX_INPUTS];
                // One pixel beyond the tile on each side.
                // Outside of the image there is the padding, which is zero.
                let Some(x) = (x0 + x).checked_sub(1).filter(|x| *x < shape.width) else {
                    continue;
                };
                for (y, d) in d.iter_mut().enumerate().take(S::IN) {
                    let Some(y) = (y0 + y).checked_sub(1).filter(|y| *y < shape.height) else {
                        continue;
                    };
                    *d = V::load(from.add((y * shape.width + x) * LANES));
                    if let Some((scale, offset, min, max)) = norm {
                        // Bounds come first: of NaN and another, the second is the result.
                        *d = min.max(max.min(scale.mul_add(*d, offset)));
                    }
                }
                *column = S::input(d);
            }
            for y in 0..S::IN {
                let row = S::input(std::array::from_fn(|x| columns[x][y]));
                for (x, value) in row.iter().enumerate().take(S::IN) {
                    value.store(to.add((y * S::IN + x) * pitch));
                }
            }
        }
    }
}

//! Packed weights of Winograd convolutions, transformed in advance or on the fly.

use std::ops::Range;

use super::transform::{MAX_INPUTS, WinogradTransform};
use crate::blocked::blocks::block_groups;
use crate::blocked::conv_shape::ConvShape;
use crate::blocked::image::Line;
use crate::simd::{LANES, Lanes};

/// Taps of a 3x3 kernel.
const TAPS: usize = 9;
/// Largest transformed weights, in bytes, that stay in an L2 cache of 1 MiB beside a part of the
/// scratch.
const L2_WEIGHT_BYTES: usize = 640 << 10;
/// Blocks of input channels whose weights are transformed at once on the fly: more would leave the
/// L2 cache.
const MAX_ON_THE_FLY_BLOCKS: usize = 2;
/// Scratch of a thread, in bytes, where weights are transformed on the fly: larger than otherwise,
/// since weights are transformed once per batch of tiles.
const ON_THE_FLY_SCRATCH_BYTES: usize = 1280 << 10;

/// The weights of a convolution, packed group by group of output channel blocks: transformed in
/// advance, as `[group][point][channel][block][16]`, or untransformed, as
/// `[group][channel][tap][block][16]`.
#[derive(Debug, Clone)]
pub(super) struct WinogradWeights {
    lines: Vec<Line>,
    /// Whether they are transformed where they are used.
    is_on_the_fly: bool,
    /// Blocks of output channels per group.
    blocks_per_group: usize,
    shape: ConvShape,
    /// Points of a tile in the Winograd domain, `IN * IN`.
    points: usize,
}

/// Transformed weights of some input channels for one group.
#[derive(Clone, Copy)]
pub(super) struct TransformedWeights {
    /// `[point][channel][block][16]`.
    pub(super) first: *const f32,
    /// Distance between points, in `f32`.
    pub(super) pitch: usize,
}

impl WinogradWeights {
    /// Whether the transformed weights of a convolution exceed the L2 cache.
    pub(super) fn are_large(shape: ConvShape, inputs: usize) -> bool {
        let blocks_out = shape.channels_out.div_ceil(LANES);
        inputs * inputs * shape.channels_in * blocks_out * size_of::<Line>() > L2_WEIGHT_BYTES
    }

    /// Packs `weight`, `[channels_out][channels_in][3][3]`.
    pub(super) fn new<S: WinogradTransform>(
        shape: ConvShape,
        blocks_per_group: usize,
        weight: &[f32],
        is_on_the_fly: bool,
    ) -> Self {
        let taps = if is_on_the_fly { weight.to_vec() } else { transform_weights::<S>(weight) };
        let values_per_kernel = taps.len() * TAPS / weight.len();
        let line = |block: usize, channel_in: usize, tap: usize| {
            let value = |lane: usize| {
                let channel = block * LANES + lane;
                let kernel = channel * shape.channels_in + channel_in;
                if channel < shape.channels_out {
                    taps[kernel * values_per_kernel + tap]
                } else {
                    0.0
                }
            };
            Line(std::array::from_fn(value))
        };
        let mut lines = Vec::new();
        for blocks in block_groups(shape.channels_out, blocks_per_group) {
            let [slow, fast] = if is_on_the_fly {
                [shape.channels_in, TAPS]
            } else {
                [values_per_kernel, shape.channels_in]
            };
            for outer in 0..slow {
                for inner in 0..fast {
                    let (channel, tap) =
                        if is_on_the_fly { (outer, inner) } else { (inner, outer) };
                    lines.extend(blocks.clone().map(|block| line(block, channel, tap)));
                }
            }
        }
        Self { lines, is_on_the_fly, blocks_per_group, shape, points: S::IN * S::IN }
    }

    /// Whether weights are transformed where they are used.
    pub(super) fn is_on_the_fly(&self) -> bool {
        self.is_on_the_fly
    }

    /// Bytes of scratch for the transformed inputs and sums of a thread.
    pub(super) fn scratch_bytes(&self, default: usize) -> usize {
        if self.is_on_the_fly { ON_THE_FLY_SCRATCH_BYTES } else { default }
    }

    /// Blocks of input channels per chunk of the batched GEMM.
    pub(super) fn blocks_per_chunk(&self) -> usize {
        if self.is_on_the_fly {
            MAX_ON_THE_FLY_BLOCKS
        } else {
            self.shape.channels_in.div_ceil(LANES)
        }
    }

    /// Lines of scratch in which a thread transforms weights.
    pub(super) fn scratch_lines(&self) -> usize {
        if self.is_on_the_fly { self.points * pitch(self.blocks_per_group) } else { 0 }
    }

    /// Packed lines of a group of `blocks` blocks, from input channel block `block_in` on.
    fn lines(&self, group: usize, blocks: usize, block_in: usize) -> &[Line] {
        let lines_per_channel = if self.is_on_the_fly { TAPS } else { self.points };
        let groups = group * self.shape.channels_in * lines_per_channel * self.blocks_per_group;
        let before = if self.is_on_the_fly { block_in * LANES * TAPS * blocks } else { 0 };
        &self.lines[(groups + before).min(self.lines.len())..]
    }

    /// Transformed weights of a group of `B` blocks and the input channel blocks `blocks_in`, at
    /// all points.
    ///
    /// # Safety
    /// The processor has the instructions of `V`; [`scratch_lines`](Self::scratch_lines) are
    /// writable at `scratch`.
    #[inline(always)]
    pub(super) unsafe fn transformed<V: Lanes, S: WinogradTransform, const B: usize>(
        &self,
        group: usize,
        blocks_in: Range<usize>,
        scratch: *mut f32,
    ) -> TransformedWeights {
        let channels_in = self.shape.channels_in;
        let lines = self.lines(group, B, blocks_in.start);
        if !self.is_on_the_fly {
            return TransformedWeights {
                first: lines.as_ptr().cast(),
                pitch: channels_in * B * LANES,
            };
        }
        let channels = channels_in.min(blocks_in.end * LANES) - blocks_in.start * LANES;
        let pitch = pitch(B) * LANES;
        let lines = &lines[..channels * TAPS * B];
        let mut from: *const f32 = lines.as_ptr().cast();
        // SAFETY: the lines hold nine taps of each channel and block, and the scratch has room for
        // all points.
        unsafe {
            for channel in 0..channels {
                for block in 0..B {
                    let to = scratch.add((channel * B + block) * LANES);
                    let mut columns = [[V::splat(0.0); MAX_INPUTS]; 3];
                    for (x, column) in columns.iter_mut().enumerate() {
                        let tap = |y: usize| V::load(from.add(((3 * y + x) * B + block) * LANES));
                        *column = S::weights([tap(0), tap(1), tap(2)]);
                    }
                    for y in 0..S::IN {
                        let row = S::weights(columns.map(|column| column[y]));
                        for (x, value) in row.iter().enumerate().take(S::IN) {
                            value.store(to.add((y * S::IN + x) * pitch));
                        }
                    }
                }
                from = from.add(TAPS * B * LANES);
            }
        }
        TransformedWeights { first: scratch, pitch }
    }

    /// Lines to prefetch while the chunk `blocks_in` is multiplied: those of the next chunk.
    pub(super) fn next_lines(
        &self,
        group: usize,
        blocks: usize,
        blocks_in: Range<usize>,
    ) -> &[Line] {
        if !self.is_on_the_fly {
            return &[];
        }
        let after = self.lines(group, blocks, blocks_in.end);
        &after[..after.len().min(MAX_ON_THE_FLY_BLOCKS * LANES * TAPS * blocks)]
    }
}

/// Lines from a point to the next in the scratch. One channel more than needed, so that points do
/// not alias in the cache.
fn pitch(blocks: usize) -> usize {
    (MAX_ON_THE_FLY_BLOCKS * LANES + 1) * blocks
}

/// Transforms 3x3 weights to `[kernel][point]`, in double precision until the last step.
fn transform_weights<S: WinogradTransform>(weight: &[f32]) -> Vec<f32> {
    let (kernels, _) = weight.as_chunks::<TAPS>();
    let mut all = Vec::with_capacity(kernels.len() * S::IN * S::IN);
    for kernel in kernels {
        let tap = |y: usize, x: usize| f64::from(kernel[3 * y + x]);
        let columns: [[f64; MAX_INPUTS]; 3] =
            std::array::from_fn(|x| transform_taps::<S>(std::array::from_fn(|y| tap(y, x))));
        for y in 0..S::IN {
            let row = transform_taps::<S>(std::array::from_fn(|x| columns[x][y]));
            all.extend(row[..S::IN].iter().map(|value| *value as f32));
        }
    }
    all
}

/// `G g` without the scales.
fn transform_taps<S: WinogradTransform>(g: [f64; 3]) -> [f64; MAX_INPUTS] {
    S::G.map(|row| row.iter().zip(g).map(|(g, tap)| f64::from(*g) * tap).sum())
}

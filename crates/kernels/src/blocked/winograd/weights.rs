//! Packed weights of Winograd convolutions, transformed in advance or on the fly.

use std::ops::Range;

use super::transform::{MAX_INPUTS, WinogradTransform};
use crate::blocked::conv_shape::ConvShape;
use crate::blocked::image::Line;
use crate::blocked::lines::Lines;
use crate::blocked::pack::pack;
use crate::cache::l2_share_bytes;
use crate::simd::{LANES, Lanes};

/// Taps of a 3x3 kernel.
const TAPS: usize = 9;
/// Share of an L2 cache that transformed weights may take, so that they stay there beside a part of the
/// scratch.
const L2_WEIGHT_SHARE: f64 = 0.625;
/// Blocks of input channels whose weights are transformed at once on the fly: more would leave the
/// L2 cache.
const MAX_ON_THE_FLY_BLOCKS: usize = 2;
/// Scratch of a thread over the L2 cache where weights are transformed on the fly: larger than otherwise,
/// since weights are transformed once per batch of tiles.
const ON_THE_FLY_SCRATCH_SHARE: f64 = 1.25;

/// The weights of a convolution, packed group by group of output channel blocks: transformed in
/// advance, as `[group][point][channel][block][16]`, or untransformed, as
/// `[group][channel][tap][block][16]`.
#[derive(Debug, Clone)]
pub(super) struct WinogradWeights {
    lines: Lines,
    /// Whether they are transformed where they are used.
    is_on_the_fly: bool,
    blocks_per_group: usize,
    shape: ConvShape,
    /// Points of a tile in the Winograd domain.
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
    pub(super) fn are_large(shape: ConvShape, points: usize) -> bool {
        let blocks_out = shape.channels_out.div_ceil(LANES);
        let bytes = points * shape.channels_in * blocks_out * size_of::<Line>();
        bytes > l2_share_bytes(L2_WEIGHT_SHARE)
    }

    /// Packs `weight`, `[channels_out][channels_in][3][3]`.
    pub(super) fn new<R: WinogradTransform, C: WinogradTransform>(
        shape: ConvShape,
        blocks_per_group: usize,
        weight: &[f32],
        is_on_the_fly: bool,
    ) -> Self {
        let [channels_out, channels_in] = [shape.channels_out, shape.channels_in];
        let points = R::IN * C::IN;
        // On the fly, nine values per channel are read instead of all points: less memory, more
        // work.
        let lines = if is_on_the_fly {
            let position = |channel_in: usize, tap: usize| channel_in * TAPS + tap;
            pack(weight, [channels_out, channels_in, TAPS], blocks_per_group, position)
        } else {
            let position = |channel_in: usize, point: usize| point * channels_in + channel_in;
            let weight = transform_weights::<R, C>(weight);
            pack(&weight, [channels_out, channels_in, points], blocks_per_group, position)
        };
        Self { lines, is_on_the_fly, blocks_per_group, shape, points }
    }

    /// Whether weights are transformed where they are used.
    pub(super) fn is_on_the_fly(&self) -> bool {
        self.is_on_the_fly
    }

    /// Bytes of scratch for the transformed inputs and sums of a thread.
    pub(super) fn scratch_bytes(&self, default: usize) -> usize {
        if self.is_on_the_fly { l2_share_bytes(ON_THE_FLY_SCRATCH_SHARE) } else { default }
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
    pub(super) unsafe fn transformed<
        V: Lanes,
        R: WinogradTransform,
        C: WinogradTransform,
        const B: usize,
    >(
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
                        *column = R::weights([tap(0), tap(1), tap(2)]);
                    }
                    for y in 0..R::IN {
                        let row = C::weights(columns.map(|column| column[y]));
                        for (x, value) in row.iter().enumerate().take(C::IN) {
                            value.store(to.add((y * C::IN + x) * pitch));
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
fn transform_weights<R: WinogradTransform, C: WinogradTransform>(weight: &[f32]) -> Vec<f32> {
    let (kernels, _) = weight.as_chunks::<TAPS>();
    let mut all = Vec::with_capacity(kernels.len() * R::IN * C::IN);
    for kernel in kernels {
        let tap = |y: usize, x: usize| f64::from(kernel[3 * y + x]);
        let columns: [[f64; MAX_INPUTS]; 3] =
            std::array::from_fn(|x| transform_taps::<R>(std::array::from_fn(|y| tap(y, x))));
        for y in 0..R::IN {
            let row = transform_taps::<C>(std::array::from_fn(|x| columns[x][y]));
            all.extend(row[..C::IN].iter().map(|value| *value as f32));
        }
    }
    all
}

/// `G g` without the scales.
fn transform_taps<S: WinogradTransform>(g: [f64; 3]) -> [f64; MAX_INPUTS] {
    S::G.map(|row| row.iter().zip(g).map(|(g, tap)| f64::from(*g) * tap).sum())
}

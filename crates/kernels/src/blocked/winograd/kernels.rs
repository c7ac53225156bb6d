//! Kernels as Winograd's scheme multiplies by them.

use std::ops::Range;

use crate::blocked::conv::ConvShape;
use crate::blocked::image::Line;
use crate::blocked::packing::groups;
use crate::blocked::scheme::{MOST, Scheme};
use crate::simd::{LANES, Lanes};

/// Bytes of transformed kernels that stay in a second cache of 1 MiB beside what lies between.
const NEAR: usize = 640 << 10;
/// Blocks of input channels whose kernels are transformed at once: more would leave the second cache.
const AT_ONCE: usize = 2;
/// Bytes between the transforms where kernels are transformed for them: the more tiles, the less often.
const BETWEEN_PLAIN: usize = 1280 << 10;

/// The kernels of a convolution, group after group of blocks of output channels.
#[derive(Debug, Clone)]
pub(super) struct Kernels {
    lines: Vec<Line>,
    is_plain: bool,
    /// Blocks of output channels that are made together.
    together: usize,
    shape: ConvShape,
    /// Of a tile.
    places: usize,
}

/// Kernels of some input channels for one group, at the places of a tile.
#[derive(Clone, Copy)]
pub(super) struct Places {
    /// `[place][channel][block][16]`.
    pub(super) first: *const f32,
    /// From a place to the next, in `f32`.
    pub(super) pitch: usize,
}

impl Kernels {
    /// Whether the transformed kernels of a convolution are too large to stay near.
    pub(super) fn are_large(shape: ConvShape, inputs: usize) -> bool {
        let blocks_out = shape.channels_out.div_ceil(LANES);
        inputs * inputs * shape.channels_in * blocks_out * size_of::<Line>() > NEAR
    }

    /// Of `weight`, `[channels_out][channels_in][3][3]`: as they are, or transformed.
    pub(super) fn new<S: Scheme>(
        shape: ConvShape,
        together: usize,
        weight: &[f32],
        is_plain: bool,
    ) -> Self {
        let taps = if is_plain { weight.to_vec() } else { transformed::<S>(weight) };
        let of_kernel = taps.len() * 9 / weight.len();
        let line = |block: usize, channel_in: usize, tap: usize| {
            let value = |lane: usize| {
                let channel = block * LANES + lane;
                let kernel = channel * shape.channels_in + channel_in;
                if channel < shape.channels_out { taps[kernel * of_kernel + tap] } else { 0.0 }
            };
            Line(std::array::from_fn(value))
        };
        let mut lines = Vec::new();
        for blocks in groups(shape.channels_out, together) {
            let [slow, fast] =
                if is_plain { [shape.channels_in, 9] } else { [of_kernel, shape.channels_in] };
            for outer in 0..slow {
                for inner in 0..fast {
                    let (channel, tap) = if is_plain { (outer, inner) } else { (inner, outer) };
                    lines.extend(blocks.clone().map(|block| line(block, channel, tap)));
                }
            }
        }
        Self { lines, is_plain, together, shape, places: S::IN * S::IN }
    }

    /// Whether kernels are transformed where they are used.
    pub(super) fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// Bytes that should lie between the transforms of a thread.
    pub(super) fn between(&self, usual: usize) -> usize {
        if self.is_plain { BETWEEN_PLAIN } else { usual }
    }

    /// Blocks of input channels that are multiplied at once.
    pub(super) fn blocks_at_once(&self) -> usize {
        if self.is_plain { AT_ONCE } else { self.shape.channels_in.div_ceil(LANES) }
    }

    /// Lines that a thread needs to transform kernels.
    pub(super) fn scratch_lines(&self) -> usize {
        if self.is_plain { self.places * pitch(self.together) } else { 0 }
    }

    /// Lines of the kernels of a group of `blocks` from a block of input channels on.
    fn lines(&self, group: usize, blocks: usize, block_in: usize) -> &[Line] {
        let of_channel = if self.is_plain { 9 } else { self.places };
        let groups = group * self.shape.channels_in * of_channel * self.together;
        let before = if self.is_plain { block_in * LANES * 9 * blocks } else { 0 };
        &self.lines[(groups + before).min(self.lines.len())..]
    }

    /// The kernels of a group of `B` blocks and of some blocks of input channels at all places.
    ///
    /// # Safety
    /// The processor has the instructions of `V`; [`scratch_lines`](Self::scratch_lines) are writable
    /// at `scratch`.
    #[inline(always)]
    pub(super) unsafe fn places<V: Lanes, S: Scheme, const B: usize>(
        &self,
        group: usize,
        blocks_in: Range<usize>,
        scratch: *mut f32,
    ) -> Places {
        let channels_in = self.shape.channels_in;
        let lines = self.lines(group, B, blocks_in.start);
        if !self.is_plain {
            return Places { first: lines.as_ptr().cast(), pitch: channels_in * B * LANES };
        }
        let channels = channels_in.min(blocks_in.end * LANES) - blocks_in.start * LANES;
        let pitch = pitch(B) * LANES;
        let lines = &lines[..channels * 9 * B];
        let mut from: *const f32 = lines.as_ptr().cast();
        // SAFETY: nine taps of each channel and block are there, and as many places.
        unsafe {
            for channel in 0..channels {
                for block in 0..B {
                    let to = scratch.add((channel * B + block) * LANES);
                    let mut columns = [[V::splat(0.0); MOST]; 3];
                    for (x, column) in columns.iter_mut().enumerate() {
                        let tap = |y: usize| V::load(from.add(((3 * y + x) * B + block) * LANES));
                        *column = S::taps([tap(0), tap(1), tap(2)]);
                    }
                    for y in 0..S::IN {
                        let row = S::taps(columns.map(|column| column[y]));
                        for (x, value) in row.iter().enumerate().take(S::IN) {
                            value.store(to.add((y * S::IN + x) * pitch));
                        }
                    }
                }
                from = from.add(9 * B * LANES);
            }
        }
        Places { first: scratch, pitch }
    }

    /// Lines that are read after those of some blocks of input channels.
    pub(super) fn next(&self, group: usize, blocks: usize, blocks_in: Range<usize>) -> &[Line] {
        if !self.is_plain {
            return &[];
        }
        let after = self.lines(group, blocks, blocks_in.end);
        &after[..after.len().min(AT_ONCE * LANES * 9 * blocks)]
    }
}

/// Lines from a place to the next: one channel more than there are, so that places do not fall on the
/// same lines of the cache.
fn pitch(blocks: usize) -> usize {
    (AT_ONCE * LANES + 1) * blocks
}

/// Kernels of 3x3 as `[kernel][place]`, in double precision up to the end.
fn transformed<S: Scheme>(weight: &[f32]) -> Vec<f32> {
    let (kernels, _) = weight.as_chunks::<9>();
    let mut all = Vec::with_capacity(kernels.len() * S::IN * S::IN);
    for kernel in kernels {
        let tap = |y: usize, x: usize| f64::from(kernel[3 * y + x]);
        let columns: [[f64; MOST]; 3] =
            std::array::from_fn(|x| taps::<S>(std::array::from_fn(|y| tap(y, x))));
        for y in 0..S::IN {
            let row = taps::<S>(std::array::from_fn(|x| columns[x][y]));
            all.extend(row[..S::IN].iter().map(|value| *value as f32));
        }
    }
    all
}

/// `G g` without its factors.
fn taps<S: Scheme>(g: [f64; 3]) -> [f64; MOST] {
    S::TAPS.map(|row| row.iter().zip(g).map(|(factor, tap)| f64::from(*factor) * tap).sum())
}

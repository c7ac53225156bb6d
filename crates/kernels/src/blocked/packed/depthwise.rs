//! Convolution of every channel by itself, of images of fewer bits.

use std::ops::Range;

use super::held::{HeldMut, To, ToBytes};
use super::image::{Packed, Storage};
use super::weights::Bytes;
use crate::blocked::depthwise::DepthwiseShape;
use crate::blocked::image::Line;
use crate::blocked::packing::blocks_of;
use crate::blocked::thread_pool::ThreadPool;
use crate::blocked::tile::{Activation, activated};
use crate::simd::dots::{Bf16, Dots, Stored};
use crate::simd::{LANES, Lanes, Level, Packed as _, PackedKernel};

/// Pixels that are read at once where bytes are multiplied by rows.
const ROW: usize = 4;

/// Such a convolution with its weights laid out for it.
#[derive(Debug, Clone)]
pub struct PackedDepthwise {
    shape: DepthwiseShape,
    level: Level,
    input: Storage,
    /// `[block][ky][kx][16]`, in steps where they are bytes.
    weights: Vec<Line>,
    /// `[block][ky][even and odd output][channel][4]`: a row of three taps, the fourth is 0. Of 3x3
    /// bytes.
    rows: Vec<[i8; LANES * ROW]>,
    /// What sums are multiplied by, and what is added to them.
    factors: Vec<Line>,
    bias: Vec<Line>,
}

impl PackedDepthwise {
    /// Lays `weight`, `[channels][kernel][kernel]`, and `bias`, `[channels]`, out for images that
    /// are kept as `input`.
    ///
    /// # Panics
    /// If there are more or fewer, the kernel is not of 3 or 5, or the stride not 1 or 2.
    pub fn new(
        shape: DepthwiseShape,
        weight: &[f32],
        bias: &[f32],
        input: Storage,
        level: Level,
    ) -> Self {
        let DepthwiseShape { channels, kernel, stride } = shape;
        assert!(
            matches!((kernel, stride), (3 | 5, 1 | 2)),
            "a kernel of 3 or 5, a stride of 1 or 2"
        );
        assert_eq!(weight.len(), channels * kernel * kernel, "weights");
        assert_eq!(bias.len(), channels, "bias");
        let taps = kernel * kernel;
        let mut rows = Vec::new();
        let (weight, factors, bias): (Vec<f32>, _, _) = match input {
            Storage::Bf16 => {
                let weight = weight.iter().map(|value| Bf16::nearest(*value).value()).collect();
                (weight, vec![1.0; channels], bias.to_vec())
            }
            Storage::Byte(scale) => {
                let bytes = Bytes::new(weight, bias, scale);
                if kernel == 3 {
                    rows = rows_of(&bytes.weight, channels);
                }
                let weight = bytes.weight.iter().map(|byte| f32::from(*byte)).collect();
                (weight, bytes.factors, bytes.offsets)
            }
        };
        let mut weights = vec![Line::ZERO; channels.div_ceil(LANES) * taps];
        for (channel, kernel) in weight.chunks(taps).enumerate() {
            for (tap, value) in kernel.iter().enumerate() {
                weights[channel / LANES * taps + tap].0[channel % LANES] = *value;
            }
        }
        let [factors, bias] = [blocks_of(&factors), blocks_of(&bias)];
        Self { shape, level, input, weights, rows, factors, bias }
    }

    /// Its shape.
    pub fn shape(&self) -> DepthwiseShape {
        self.shape
    }

    /// Writes `activation(conv(input))` to `output`.
    ///
    /// # Panics
    /// If an image has another size, or the input is kept otherwise than the weights are made for
    /// or its border narrower than half a kernel.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: &Packed,
        activation: Activation,
        mut output: HeldMut<'_>,
    ) {
        let DepthwiseShape { channels, kernel, stride } = self.shape;
        let [channels_in, height, width] = input.size();
        assert_eq!(channels_in, channels, "channels");
        assert_eq!(input.storage(), self.input, "an input that the weights are made for");
        assert!(input.border() >= kernel / 2, "a border as wide as half a kernel");
        let [rows, width] = [height, width].map(|side| side.div_ceil(stride));
        assert_eq!(output.size(), [channels, rows, width], "size of the output");
        let units = channels.div_ceil(LANES) * rows;
        let to = output.to();
        thread_pool.run(&|part| {
            let units = part.chunk(units);
            let work = Rows { of: self, input, activation, to, rows, width, units };
            // SAFETY: sizes were compared above, rows of the parts are disjoint, and the level is
            // one of this processor's.
            unsafe {
                match self.input {
                    Storage::Bf16 => Bf16::run(self.level, &work),
                    Storage::Byte(_) => u8::run(self.level, &work),
                }
            }
        });
    }
}

/// Weights of 3x3 for rows of four pixels, of which an even output sees the first three and the odd
/// one next to it the last three.
fn rows_of(weight: &[i8], channels: usize) -> Vec<[i8; LANES * ROW]> {
    let mut rows = vec![[0; LANES * ROW]; channels.div_ceil(LANES) * 6];
    for (channel, taps) in weight.chunks(9).enumerate() {
        for (tap, byte) in taps.iter().enumerate() {
            let (ky, kx) = (tap / 3, tap % 3);
            for shift in 0..2 {
                let row = &mut rows[(channel / LANES * 3 + ky) * 2 + shift];
                row[channel % LANES * ROW + kx + shift] = *byte;
            }
        }
    }
    rows
}

/// Some rows, block after block.
struct Rows<'a> {
    of: &'a PackedDepthwise,
    input: &'a Packed,
    activation: Activation,
    to: To,
    /// Of a block.
    rows: usize,
    width: usize,
    units: Range<usize>,
}

/// What whole sums are multiplied by and what is added to them, and where they go if they go into
/// bytes.
#[derive(Clone, Copy)]
struct End<V> {
    bytes: Option<ToBytes>,
    by: [V; 2],
}

impl<S: Stored> PackedKernel<S> for Rows<'_> {
    #[inline(always)]
    unsafe fn run<D: Dots<Stored = S>>(&self) {
        // SAFETY: the caller's.
        unsafe {
            match (self.of.shape.kernel, self.of.shape.stride) {
                (3, 1) if D::HAS_ROWS => self.by_rows::<D, 1>(),
                (3, _) if D::HAS_ROWS => self.by_rows::<D, 2>(),
                (3, 1) => self.by_taps::<D, 3, 1>(),
                (3, _) => self.by_taps::<D, 3, 2>(),
                (_, 1) => self.by_taps::<D, 5, 1>(),
                _ => self.by_taps::<D, 5, 2>(),
            }
        }
    }
}

impl Rows<'_> {
    /// Four pixels at a time, two of whose outputs are made where they are neighbours.
    ///
    /// # Safety
    /// That of [`PackedKernel::run`].
    #[inline(always)]
    unsafe fn by_rows<D: Dots, const STRIDE: usize>(&self) {
        let row_pitch = self.input.row_pitch() * LANES;
        for unit in self.units.clone() {
            let (block, y) = (unit / self.rows, unit % self.rows);
            let from: *const D::Stored = self.input.tap(block, y * STRIDE, 0, 1);
            // SAFETY: the caller's; a row of four pixels ends within what may be read beyond the
            // border.
            unsafe {
                let weights: [[D::Weights; 2]; 3] = std::array::from_fn(|ky| {
                    let rows = &self.of.rows[(block * 3 + ky) * 2..][..2];
                    std::array::from_fn(|shift| D::weights(rows[shift].as_ptr().cast()))
                });
                let (to, end) = (self.to.at(block, y), self.end::<D::Lanes>(block));
                let row = |x: usize, ky: usize| D::row(from.add(ky * row_pitch + x * LANES));
                let mut x = 0;
                while STRIDE == 1 && x + 2 <= self.width {
                    let mut sums = [D::zero(); 2];
                    for (ky, weights) in weights.iter().enumerate() {
                        let values = row(x, ky);
                        sums[0] = D::add(sums[0], values, weights[0]);
                        sums[1] = D::add(sums[1], values, weights[1]);
                    }
                    self.put(D::whole(sums[0]), end, to + x * LANES);
                    self.put(D::whole(sums[1]), end, to + (x + 1) * LANES);
                    x += 2;
                }
                while x < self.width {
                    let mut sum = D::zero();
                    for (ky, weights) in weights.iter().enumerate() {
                        sum = D::add(sum, row(x * STRIDE, ky), weights[0]);
                    }
                    self.put(D::whole(sum), end, to + x * LANES);
                    x += 1;
                }
            }
        }
    }

    /// What sums of a block become.
    ///
    /// # Safety
    /// That of [`PackedKernel::run`].
    #[inline(always)]
    unsafe fn end<V: Lanes>(&self, block: usize) -> End<V> {
        // SAFETY: the caller's.
        unsafe {
            let factor = V::load(self.of.factors[block].0.as_ptr());
            let bias = V::load(self.of.bias[block].0.as_ptr());
            let bytes = self.to.bytes(self.activation);
            End { bytes, by: bytes.map_or([factor, bias], |bytes| bytes.after(factor, bias)) }
        }
    }

    /// # Safety
    /// That of [`PackedKernel::run`]; the pixel is inside the output.
    #[inline(always)]
    unsafe fn put<V: Lanes>(&self, sum: V, end: End<V>, at: usize) {
        // SAFETY: the caller's.
        unsafe {
            match end.bytes {
                Some(bytes) => bytes.store(sum, end.by, at),
                None => {
                    let sum = sum.mul_add(end.by[0], end.by[1]);
                    self.to.store(activated(sum, self.activation), at);
                }
            }
        }
    }

    /// Tap by tap.
    ///
    /// # Safety
    /// That of [`PackedKernel::run`].
    #[inline(always)]
    unsafe fn by_taps<D: Dots, const K: usize, const STRIDE: usize>(&self) {
        for unit in self.units.clone() {
            let (block, y) = (unit / self.rows, unit % self.rows);
            let from = self.input.tap(block, y * STRIDE, 0, K / 2);
            let to = self.to.at(block, y);
            // SAFETY: the caller's; taps and outputs of this row are inside.
            unsafe {
                let mut x = 0;
                while x + 4 <= self.width {
                    self.tile::<D, K, STRIDE, 4>(block, from, to, x);
                    x += 4;
                }
                while x < self.width {
                    self.tile::<D, K, STRIDE, 1>(block, from, to, x);
                    x += 1;
                }
            }
        }
    }

    /// `N` outputs from column `x` on.
    ///
    /// # Safety
    /// That of [`PackedKernel::run`]; they and their taps are inside.
    #[inline(always)]
    unsafe fn tile<D: Dots, const K: usize, const STRIDE: usize, const N: usize>(
        &self,
        block: usize,
        from: *const D::Stored,
        to: usize,
        x: usize,
    ) {
        let row_pitch = self.input.row_pitch() * LANES;
        let weights = self.of.weights[block * K * K..][..K * K].as_ptr().cast::<f32>();
        // SAFETY: the caller's.
        unsafe {
            let from = from.add(x * STRIDE * LANES);
            let mut sums = [D::Lanes::splat(0.0); N];
            for ky in 0..K {
                for kx in 0..K {
                    let weight = D::Lanes::load(weights.add((ky * K + kx) * LANES));
                    for (pixel, sum) in sums.iter_mut().enumerate() {
                        let at = ky * row_pitch + (pixel * STRIDE + kx) * LANES;
                        let value: D::Lanes = D::Stored::load(from.add(at));
                        *sum = value.mul_add(weight, *sum);
                    }
                }
            }
            let end = self.end::<D::Lanes>(block);
            for (pixel, sum) in sums.into_iter().enumerate() {
                self.put(sum, end, to + (x + pixel) * LANES);
            }
        }
    }
}

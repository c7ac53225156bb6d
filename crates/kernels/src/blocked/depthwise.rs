//! Convolution of every channel by itself.

use std::ops::Range;

use super::conv::Output;
use super::image::{Image, Input, Line};
use super::packing::blocks_of;
use super::thread_pool::ThreadPool;
use super::tile::{Activation, activated};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Shape of a square convolution of single channels that keeps the image size, up to its stride.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DepthwiseShape {
    /// Channels of input and output.
    pub channels: usize,
    /// Rows and columns of the kernel: 3 or 5.
    pub kernel: usize,
    /// Pixels between outputs: 1 or 2.
    pub stride: usize,
}

/// Such a convolution with its weights laid out for it.
#[derive(Debug, Clone)]
pub struct Depthwise {
    shape: DepthwiseShape,
    level: Level,
    /// `[block][ky][kx][16]`.
    weights: Vec<Line>,
    bias: Vec<Line>,
}

impl Depthwise {
    /// Lays `weight`, `[channels][kernel][kernel]`, and `bias`, `[channels]`, out.
    ///
    /// # Panics
    /// If there are more or fewer, the kernel is not of 3 or 5, or the stride not 1 or 2.
    pub fn new(shape: DepthwiseShape, weight: &[f32], bias: &[f32], level: Level) -> Self {
        let DepthwiseShape { channels, kernel, stride } = shape;
        assert!(
            matches!((kernel, stride), (3 | 5, 1 | 2)),
            "a kernel of 3 or 5, a stride of 1 or 2"
        );
        assert_eq!(weight.len(), channels * kernel * kernel, "weights");
        assert_eq!(bias.len(), channels, "bias");
        let taps = kernel * kernel;
        let mut weights = vec![Line::ZERO; channels.div_ceil(LANES) * taps];
        for (channel, kernel) in weight.chunks(taps).enumerate() {
            for (tap, value) in kernel.iter().enumerate() {
                weights[channel / LANES * taps + tap].0[channel % LANES] = *value;
            }
        }
        Self { shape, level, weights, bias: blocks_of(bias) }
    }

    /// Its shape.
    pub fn shape(&self) -> DepthwiseShape {
        self.shape
    }

    /// Writes `activation(conv(input))` to `output`.
    ///
    /// # Panics
    /// If an image has another size, or the border of the input is narrower than half a kernel.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: &Image,
        activation: Activation,
        output: &mut Image,
    ) {
        let DepthwiseShape { channels, kernel, stride } = self.shape;
        assert_eq!([input.channels(), output.channels()], [channels; 2], "channels");
        assert!(input.border() >= kernel / 2, "a border as wide as half a kernel");
        let size = [input.height(), input.width()].map(|side| side.div_ceil(stride));
        assert_eq!([output.height(), output.width()], size, "size of the output");
        let rows = output.height();
        let units = output.blocks() * rows;
        let (input, out) = (Input::of(input), Output::of(output));
        thread_pool.run(&|part| {
            let work = Rows { of: self, input, activation, out, rows, units: part.chunk(units) };
            // SAFETY: sizes were compared above, rows of the parts are disjoint, and the level is
            // one of this processor's.
            unsafe { self.level.run(&work) };
        });
    }

    /// Writes so many rows from row 0 of `out` on, of all channels.
    ///
    /// # Safety
    /// Taps of these rows are readable, and the rows writable.
    pub(super) unsafe fn rows(
        &self,
        input: Input,
        activation: Activation,
        out: Output,
        rows: usize,
    ) {
        let units = 0..self.shape.channels.div_ceil(LANES) * rows;
        let work = Rows { of: self, input, activation, out, rows, units };
        // SAFETY: the caller's.
        unsafe { self.level.run(&work) };
    }
}

/// Some rows, block after block.
struct Rows<'a> {
    of: &'a Depthwise,
    input: Input,
    activation: Activation,
    out: Output,
    /// Of a block.
    rows: usize,
    units: Range<usize>,
}

impl Kernel for Rows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        // SAFETY: the caller's.
        unsafe {
            match (self.of.shape.kernel, self.of.shape.stride) {
                (3, 1) => self.all::<V, 3, 1>(),
                (3, _) => self.all::<V, 3, 2>(),
                (_, 1) => self.all::<V, 5, 1>(),
                _ => self.all::<V, 5, 2>(),
            }
        }
    }
}

impl Rows<'_> {
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn all<V: Lanes, const K: usize, const STRIDE: usize>(&self) {
        for unit in self.units.clone() {
            let (block, y) = (unit / self.rows, unit % self.rows);
            let weights = self.of.weights[block * K * K..].as_ptr().cast::<f32>();
            let bias = self.of.bias[block].0.as_ptr();
            let from = self.input.tap(block, y * STRIDE, 0, K / 2);
            // SAFETY: the caller's; taps and outputs of this row are inside.
            unsafe {
                let to = self.out.pixel(block, y, 0);
                let mut x = 0;
                // Weights and sums together stay in registers.
                while V::TILE[0] == 12 && x + 8 <= self.out.width {
                    self.tile::<V, K, STRIDE, 8>(from, weights, bias, to, x);
                    x += 8;
                }
                while x + 4 <= self.out.width {
                    self.tile::<V, K, STRIDE, 4>(from, weights, bias, to, x);
                    x += 4;
                }
                while x < self.out.width {
                    self.tile::<V, K, STRIDE, 1>(from, weights, bias, to, x);
                    x += 1;
                }
            }
        }
    }

    /// `N` outputs from column `x` on.
    ///
    /// # Safety
    /// That of [`Kernel::run`]; they and their taps are inside.
    #[inline(always)]
    unsafe fn tile<V: Lanes, const K: usize, const STRIDE: usize, const N: usize>(
        &self,
        from: *const f32,
        weights: *const f32,
        bias: *const f32,
        to: *mut f32,
        x: usize,
    ) {
        let row_pitch = self.input.row_pitch;
        // SAFETY: the caller's.
        unsafe {
            let from = from.add(x * STRIDE * LANES);
            let mut sums = [V::load(bias); N];
            for ky in 0..K {
                for kx in 0..K {
                    let weight = V::load(weights.add((ky * K + kx) * LANES));
                    for (pixel, sum) in sums.iter_mut().enumerate() {
                        let at = ky * row_pitch + (pixel * STRIDE + kx) * LANES;
                        *sum = V::load(from.add(at)).mul_add(weight, *sum);
                    }
                }
            }
            for (pixel, sum) in sums.into_iter().enumerate() {
                activated(sum, self.activation).store(to.add((x + pixel) * LANES));
            }
        }
    }
}

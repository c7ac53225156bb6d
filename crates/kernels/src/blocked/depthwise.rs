//! Depthwise convolution in nChw16c.

use std::ops::Range;

use super::ThreadPool;
use super::blocks::pad_to_blocks;
use super::image::{Image, Line};
use super::low_precision::{Bf16Dst, TensorViewMut};
use super::tile::{Activation, activated};
use super::views::{F32Dst, F32Src};
use crate::simd::dots::{Bf16, ReducedPrecision as _};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Shape of a square depthwise convolution with padding `kernel / 2`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DepthwiseShape {
    /// Channels of input and output.
    pub channels: usize,
    /// Height and width of the kernel: 3 or 5.
    pub kernel: usize,
    /// Stride: 1 or 2.
    pub stride: usize,
}

/// A depthwise convolution with its weights packed.
#[derive(Debug, Clone)]
pub struct Depthwise {
    shape: DepthwiseShape,
    level: Level,
    /// `[block][ky][kx][16]`.
    weights: Vec<Line>,
    bias: Vec<Line>,
}

impl Depthwise {
    /// Packs `weight`, `[channels][kernel][kernel]`, and `bias`, `[channels]`.
    ///
    /// # Panics
    /// If either has another length, the kernel is not 3 or 5, or the stride not 1 or 2.
    pub fn new(shape: DepthwiseShape, weight: &[f32], bias: &[f32], level: Level) -> Self {
        let DepthwiseShape { channels, kernel, stride } = shape;
        assert!(
            matches!((kernel, stride), (3 | 5, 1 | 2)),
            "a kernel of 3 or 5, a stride of 1 or 2"
        );
        assert_eq!(weight.len(), channels * kernel * kernel, "weights");
        assert_eq!(bias.len(), channels, "bias");
        let taps = kernel * kernel;
        // Channels that fill up the last block have weight zero, and outputs that nobody reads.
        let mut weights = vec![Line::ZERO; channels.div_ceil(LANES) * taps];
        for (channel, kernel) in weight.chunks(taps).enumerate() {
            for (tap, value) in kernel.iter().enumerate() {
                weights[channel / LANES * taps + tap].0[channel % LANES] = *value;
            }
        }
        Self { shape, level, weights, bias: pad_to_blocks(bias) }
    }

    /// Shape of the convolution.
    pub fn shape(&self) -> DepthwiseShape {
        self.shape
    }

    /// Writes `activation(conv(input))` to `output`, in f32 or in bf16: of bf16 inputs each tap would have to be
    /// converted, which takes twice as long as to multiply it.
    ///
    /// # Panics
    /// If an image has another size, the border of the input is narrower than half a kernel, or the output is quantised.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: &Image,
        activation: Activation,
        output: TensorViewMut<'_>,
    ) {
        let DepthwiseShape { channels, kernel, stride } = self.shape;
        assert_eq!(input.channels(), channels, "channels");
        assert!(input.border() >= kernel / 2, "a border as wide as half a kernel");
        let [rows_per_block, width] =
            [input.height(), input.width()].map(|side| side.div_ceil(stride));
        assert_eq!(output.size(), [channels, rows_per_block, width], "size of the output");
        let (src, size) = (input.src(), [rows_per_block, width]);
        match output {
            TensorViewMut::F32(image) => {
                self.run_to(thread_pool, src, activation, image.dst(), size);
            }
            TensorViewMut::LowPrecision(image) => {
                self.run_to(thread_pool, src, activation, image.bf16_dst(), size);
            }
        }
    }

    /// Writes outputs of `size`, rows and columns.
    fn run_to(
        &self,
        thread_pool: &ThreadPool,
        src: F32Src,
        activation: Activation,
        dst: impl Destination,
        size: [usize; 2],
    ) {
        let rows = self.shape.channels.div_ceil(LANES) * size[0];
        thread_pool.run(&|part| {
            let rows = part.chunk(rows);
            let kernel = DepthwiseRows { conv: self, src, activation, dst, size, rows };
            // SAFETY: sizes were compared before, rows of the parts are disjoint, and the level is
            // one of this processor's.
            unsafe { self.level.run(&kernel) };
        });
    }

    /// Computes `rows` rows of all channels, from row 0 of `dst` on.
    ///
    /// # Safety
    /// The windows of these rows are readable, and the rows writable.
    pub(super) unsafe fn rows(
        &self,
        src: F32Src,
        activation: Activation,
        dst: F32Dst,
        rows: usize,
    ) {
        let size = [rows, dst.width];
        let rows = 0..self.shape.channels.div_ceil(LANES) * size[0];
        let kernel = DepthwiseRows { conv: self, src, activation, dst, size, rows };
        // SAFETY: the caller's.
        unsafe { self.level.run(&kernel) };
    }
}

/// Place of outputs: a type for each, since a choice at every store slows f32 down.
trait Destination: Copy + Sync {
    /// Offset of the first pixel of a row.
    fn row(&self, block: usize, y: usize) -> usize;

    /// # Safety
    /// There is room for sixteen values, nobody else writes there, and the processor has the instructions of `V`.
    unsafe fn write<V: Lanes>(&self, value: V, at: usize);
}

impl Destination for F32Dst {
    fn row(&self, block: usize, y: usize) -> usize {
        block * self.block_pitch + y * self.row_pitch
    }

    #[inline(always)]
    unsafe fn write<V: Lanes>(&self, value: V, at: usize) {
        // SAFETY: the caller's.
        unsafe { value.store(self.pixels.add(at)) }
    }
}

impl Destination for Bf16Dst {
    fn row(&self, block: usize, y: usize) -> usize {
        block * self.block_pitch + y * self.row_pitch
    }

    #[inline(always)]
    unsafe fn write<V: Lanes>(&self, value: V, at: usize) {
        // SAFETY: the caller's.
        unsafe { Bf16::store(value, self.pixels.add(at)) }
    }
}

/// Kernel over a range of output rows, counted over all channel blocks.
struct DepthwiseRows<'a, D> {
    conv: &'a Depthwise,
    src: F32Src,
    activation: Activation,
    dst: D,
    /// Rows and columns of a block of outputs.
    size: [usize; 2],
    rows: Range<usize>,
}

impl<D: Destination> Kernel for DepthwiseRows<'_, D> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        // SAFETY: the caller's.
        unsafe {
            match (self.conv.shape.kernel, self.conv.shape.stride) {
                (3, 1) => self.compute::<V, 3, 1>(),
                (3, _) => self.compute::<V, 3, 2>(),
                (_, 1) => self.compute::<V, 5, 1>(),
                _ => self.compute::<V, 5, 2>(),
            }
        }
    }
}

impl<D: Destination> DepthwiseRows<'_, D> {
    /// Computes the rows with a kernel of `K` and a stride of `STRIDE`.
    ///
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn compute<V: Lanes, const K: usize, const STRIDE: usize>(&self) {
        let [rows_per_block, width] = self.size;
        for row in self.rows.clone() {
            let (block, y) = (row / rows_per_block, row % rows_per_block);
            // One line for each tap: a block is sixteen kernels side by side.
            let weights = self.conv.weights[block * K * K..].as_ptr().cast::<f32>();
            let bias = self.conv.bias[block].0.as_ptr();
            let from = self.src.tap(block, y * STRIDE, 0, K / 2);
            // SAFETY: the caller's; taps and outputs of this row are inside.
            unsafe {
                let to = self.dst.row(block, y);
                let mut x = 0;
                // AVX-512 has the registers for 8 sums and their weights; other levels for 4.
                while V::TILE[0] == 12 && x + 8 <= width {
                    self.tile::<V, K, STRIDE, 8>(from, weights, bias, to, x);
                    x += 8;
                }
                while x + 4 <= width {
                    self.tile::<V, K, STRIDE, 4>(from, weights, bias, to, x);
                    x += 4;
                }
                while x < width {
                    self.tile::<V, K, STRIDE, 1>(from, weights, bias, to, x);
                    x += 1;
                }
            }
        }
    }

    /// Computes `N` output pixels of a block from column `x` on.
    ///
    /// # Safety
    /// That of [`Kernel::run`]; the pixels and their windows are inside the images.
    #[inline(always)]
    unsafe fn tile<V: Lanes, const K: usize, const STRIDE: usize, const N: usize>(
        &self,
        from: *const f32,
        weights: *const f32,
        bias: *const f32,
        to: usize,
        x: usize,
    ) {
        let row_pitch = self.src.row_pitch;
        // SAFETY: the caller's.
        unsafe {
            let from = from.add(x * STRIDE * LANES);
            let mut sums = [V::load(bias); N];
            for ky in 0..K {
                for kx in 0..K {
                    // A weight is loaded once for all pixels, whose sums stay in registers.
                    let weight = V::load(weights.add((ky * K + kx) * LANES));
                    for (pixel, sum) in sums.iter_mut().enumerate() {
                        let at = ky * row_pitch + (pixel * STRIDE + kx) * LANES;
                        *sum = V::load(from.add(at)).mul_add(weight, *sum);
                    }
                }
            }
            for (pixel, sum) in sums.into_iter().enumerate() {
                self.dst.write(activated(sum, self.activation), to + (x + pixel) * LANES);
            }
        }
    }
}

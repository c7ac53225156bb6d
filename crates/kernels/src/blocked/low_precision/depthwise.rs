//! Depthwise convolution of quantised images.

use std::ops::Range;

use super::image::{LowPrecisionImage, LowPrecisionType, QuantizationParams};
use super::quantized_weights::QuantizedWeights;
use super::view::{DstView, RequantizingDst, TensorViewMut};
use crate::blocked::ThreadPool;
use crate::blocked::blocks::pad_to_blocks;
use crate::blocked::depthwise::DepthwiseShape;
use crate::blocked::image::Line;
use crate::blocked::tile::{Activation, activated};
use crate::simd::dots::{DotProduct, ReducedPrecision as _};
use crate::simd::{LANES, Lanes, Level, ReducedDispatch as _, ReducedKernel};

/// Pixels of a dot product of bytes: VNNI multiplies four bytes and adds them up in one
/// instruction.
const PIXELS_PER_ROW: usize = 4;

/// A depthwise convolution with its weights quantised and packed.
#[derive(Debug, Clone)]
pub struct QuantizedDepthwise {
    shape: DepthwiseShape,
    level: Level,
    input: QuantizationParams,
    /// `[block][ky][kx][16]`, integers in f32.
    weights: Vec<Line>,
    /// For 3x3 weights `[block][ky][even or odd output][channel][4]`: a row of three taps and
    /// a zero.
    rows: Vec<[i8; LANES * PIXELS_PER_ROW]>,
    /// Scale and bias of the sums, per channel.
    scales: Vec<Line>,
    bias: Vec<Line>,
}

impl QuantizedDepthwise {
    /// Packs `weight`, `[channels][kernel][kernel]`, and `bias`, `[channels]`, for inputs quantised by
    /// `input`.
    ///
    /// # Panics
    /// If either has another length, the kernel is not 3 or 5, or the stride not 1 or 2.
    pub fn new(
        shape: DepthwiseShape,
        weight: &[f32],
        bias: &[f32],
        input: QuantizationParams,
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
        let QuantizedWeights { weight, scales, bias } = QuantizedWeights::new(weight, bias, input);
        // Only kernels of 3 have instructions for rows of bytes; others multiply in f32.
        let rows = if kernel == 3 { pack_rows(&weight, channels) } else { Vec::new() };
        // Lanes beyond the last channel stay zero.
        let mut weights = vec![Line::ZERO; channels.div_ceil(LANES) * taps];
        for (channel, kernel) in weight.chunks(taps).enumerate() {
            for (tap, byte) in kernel.iter().enumerate() {
                weights[channel / LANES * taps + tap].0[channel % LANES] = f32::from(*byte);
            }
        }
        let [scales, bias] = [pad_to_blocks(&scales), pad_to_blocks(&bias)];
        Self { shape, level, input, weights, rows, scales, bias }
    }

    /// Shape of the convolution.
    pub fn shape(&self) -> DepthwiseShape {
        self.shape
    }

    /// Writes `activation(conv(input))` to `output`.
    ///
    /// # Panics
    /// If an image has another size, the input is quantised otherwise than the weights were
    /// packed for, or its border is narrower than half a kernel.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: &LowPrecisionImage,
        activation: Activation,
        mut output: TensorViewMut<'_>,
    ) {
        let DepthwiseShape { channels, kernel, stride } = self.shape;
        let [channels_in, height, width] = input.size();
        assert_eq!(channels_in, channels, "channels");
        assert_eq!(input.element_type(), LowPrecisionType::Uint8(self.input), "type of the input");
        assert!(input.border() >= kernel / 2, "a border as wide as half a kernel");
        let [rows_per_block, width] = [height, width].map(|side| side.div_ceil(stride));
        assert_eq!(output.size(), [channels, rows_per_block, width], "size of the output");
        let rows = channels.div_ceil(LANES) * rows_per_block;
        let to = output.dst();
        thread_pool.run(&|part| {
            let rows = part.chunk(rows);
            let kernel =
                DepthwiseRows { conv: self, input, activation, to, rows_per_block, width, rows };
            // SAFETY: sizes were compared above, rows of the parts are disjoint, and the level is
            // one of this processor's.
            unsafe { u8::run(self.level, &kernel) };
        });
    }
}

/// Packs 3x3 weights for dot products over rows of four pixels. Two neighbouring outputs share the
/// four pixels: the even one multiplies the first three, the odd one the last three.
fn pack_rows(weight: &[i8], channels: usize) -> Vec<[i8; LANES * PIXELS_PER_ROW]> {
    let mut rows = vec![[0; LANES * PIXELS_PER_ROW]; channels.div_ceil(LANES) * 6];
    for (channel, taps) in weight.chunks(9).enumerate() {
        for (tap, byte) in taps.iter().enumerate() {
            let (ky, kx) = (tap / 3, tap % 3);
            for shift in 0..2 {
                let row = &mut rows[(channel / LANES * 3 + ky) * 2 + shift];
                row[channel % LANES * PIXELS_PER_ROW + kx + shift] = *byte;
            }
        }
    }
    rows
}

/// Kernel over a range of output rows, counted over all channel blocks.
struct DepthwiseRows<'a> {
    conv: &'a QuantizedDepthwise,
    input: &'a LowPrecisionImage,
    activation: Activation,
    to: DstView,
    rows_per_block: usize,
    width: usize,
    rows: Range<usize>,
}

/// Scale and bias of the sums of a block, with the requantising view if the output is uint8.
#[derive(Clone, Copy)]
struct Epilogue<V> {
    requantizing: Option<RequantizingDst>,
    scale_bias: [V; 2],
}

impl ReducedKernel<u8> for DepthwiseRows<'_> {
    #[inline(always)]
    unsafe fn run<D: DotProduct<Element = u8>>(&self) {
        // SAFETY: the caller's.
        unsafe {
            match (self.conv.shape.kernel, self.conv.shape.stride) {
                (3, 1) if D::HAS_PIXEL_ROWS => self.by_rows::<D, 1>(),
                (3, _) if D::HAS_PIXEL_ROWS => self.by_rows::<D, 2>(),
                (3, 1) => self.by_taps::<D, 3, 1>(),
                (3, _) => self.by_taps::<D, 3, 2>(),
                (_, 1) => self.by_taps::<D, 5, 1>(),
                _ => self.by_taps::<D, 5, 2>(),
            }
        }
    }
}

impl DepthwiseRows<'_> {
    /// Computes 3x3 convolutions by dot products over rows of four pixels, with stride 1 two
    /// outputs at a time.
    ///
    /// # Safety
    /// That of [`ReducedKernel::run`].
    #[inline(always)]
    unsafe fn by_rows<D: DotProduct, const STRIDE: usize>(&self) {
        let row_pitch = self.input.row_pitch() * LANES;
        for unit in self.rows.clone() {
            let (block, y) = (unit / self.rows_per_block, unit % self.rows_per_block);
            let from: *const D::Element = self.input.tap(block, y * STRIDE, 0, 1);
            // SAFETY: the caller's; a row of four pixels ends within the overread beyond the
            // border.
            unsafe {
                // Six vectors, loaded once for a whole row of outputs.
                let weights: [[D::Weights; 2]; 3] = std::array::from_fn(|ky| {
                    let rows = &self.conv.rows[(block * 3 + ky) * 2..][..2];
                    std::array::from_fn(|shift| D::weights(rows[shift].as_ptr().cast()))
                });
                let (to, epilogue) =
                    (self.to.row_offset(block, y), self.epilogue::<D::Lanes>(block));
                let row = |x: usize, ky: usize| D::pixel_row(from.add(ky * row_pitch + x * LANES));
                let mut x = 0;
                while STRIDE == 1 && x + 2 <= self.width {
                    let mut sums = [D::zero(); 2];
                    for (ky, weights) in weights.iter().enumerate() {
                        // One load of four pixels serves two outputs: weights are shifted instead.
                        let values = row(x, ky);
                        sums[0] = D::add(sums[0], values, weights[0]);
                        sums[1] = D::add(sums[1], values, weights[1]);
                    }
                    self.store(D::to_f32(sums[0]), epilogue, to + x * LANES);
                    self.store(D::to_f32(sums[1]), epilogue, to + (x + 1) * LANES);
                    x += 2;
                }
                while x < self.width {
                    let mut sum = D::zero();
                    for (ky, weights) in weights.iter().enumerate() {
                        // Of stride 2, and at the end of a row, outputs go one by one.
                        sum = D::add(sum, row(x * STRIDE, ky), weights[0]);
                    }
                    self.store(D::to_f32(sum), epilogue, to + x * LANES);
                    x += 1;
                }
            }
        }
    }

    /// Scale and bias of a block, for the element type of the output.
    ///
    /// # Safety
    /// That of [`ReducedKernel::run`].
    #[inline(always)]
    unsafe fn epilogue<V: Lanes>(&self, block: usize) -> Epilogue<V> {
        // SAFETY: the caller's.
        unsafe {
            let scale = V::load(self.conv.scales[block].0.as_ptr());
            let bias = V::load(self.conv.bias[block].0.as_ptr());
            let requantizing = self.to.requantizing(self.activation);
            let scale_bias =
                requantizing.map_or([scale, bias], |requantizing| requantizing.fold(scale, bias));
            Epilogue { requantizing, scale_bias }
        }
    }

    /// Applies the epilogue to sums and stores them.
    ///
    /// # Safety
    /// That of [`ReducedKernel::run`]; the pixel is inside the output.
    #[inline(always)]
    unsafe fn store<V: Lanes>(&self, sum: V, epilogue: Epilogue<V>, at: usize) {
        // SAFETY: the caller's.
        unsafe {
            match epilogue.requantizing {
                Some(requantizing) => requantizing.store(sum, epilogue.scale_bias, at),
                None => {
                    let sum = sum.mul_add(epilogue.scale_bias[0], epilogue.scale_bias[1]);
                    self.to.store(activated(sum, self.activation), at);
                }
            }
        }
    }

    /// Computes the convolution tap by tap in f32.
    ///
    /// # Safety
    /// That of [`ReducedKernel::run`].
    #[inline(always)]
    unsafe fn by_taps<D: DotProduct, const K: usize, const STRIDE: usize>(&self) {
        for unit in self.rows.clone() {
            let (block, y) = (unit / self.rows_per_block, unit % self.rows_per_block);
            let from = self.input.tap(block, y * STRIDE, 0, K / 2);
            let to = self.to.row_offset(block, y);
            // SAFETY: the caller's; taps and outputs of this row are inside.
            unsafe {
                let mut x = 0;
                // Four pixels share each weight; the rest of the row goes one by one.
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

    /// Computes `N` output pixels of a block from column `x` on.
    ///
    /// # Safety
    /// That of [`ReducedKernel::run`]; the pixels and their windows are inside the images.
    #[inline(always)]
    unsafe fn tile<D: DotProduct, const K: usize, const STRIDE: usize, const N: usize>(
        &self,
        block: usize,
        from: *const D::Element,
        to: usize,
        x: usize,
    ) {
        let row_pitch = self.input.row_pitch() * LANES;
        let weights = self.conv.weights[block * K * K..][..K * K].as_ptr().cast::<f32>();
        // SAFETY: the caller's.
        unsafe {
            let from = from.add(x * STRIDE * LANES);
            let mut sums = [D::Lanes::splat(0.0); N];
            for ky in 0..K {
                for kx in 0..K {
                    let weight = D::Lanes::load(weights.add((ky * K + kx) * LANES));
                    for (pixel, sum) in sums.iter_mut().enumerate() {
                        let at = ky * row_pitch + (pixel * STRIDE + kx) * LANES;
                        let value: D::Lanes = D::Element::load(from.add(at));
                        *sum = value.mul_add(weight, *sum);
                    }
                }
            }
            let epilogue = self.epilogue::<D::Lanes>(block);
            for (pixel, sum) in sums.into_iter().enumerate() {
                self.store(sum, epilogue, to + (x + pixel) * LANES);
            }
        }
    }
}

//! Convolution of images in nchw with a few channels.
//!
//! In nChw16c a convolution into three channels uses three of 16 lanes. In nchw the lanes are 16
//! neighbouring pixels of one channel, and all are used.

use std::ops::Range;

use super::ThreadPool;
use super::conv_shape::ConvShape;
use super::low_precision::{DstView, TensorViewMut};
use super::nchw::NchwImage;
use super::tile::{Activation, activated};
use super::views::F32Dst;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Largest number of input or output channels; each output channel takes an accumulator.
const MAX_CHANNELS: usize = 4;

/// A convolution of stride 1 of a few channels in nchw, with its weights packed.
#[derive(Debug, Clone)]
pub struct NchwConv {
    shape: ConvShape,
    level: Level,
    /// `[channels_in][kernel][kernel][channels_out]`.
    weights: Vec<f32>,
    bias: Vec<f32>,
}

impl NchwConv {
    /// Whether this kernel supports a shape: at most four channels in and out, stride 1.
    pub fn supports(shape: ConvShape) -> bool {
        let has_few =
            (1..=MAX_CHANNELS).contains(&shape.channels_out) && shape.channels_in <= MAX_CHANNELS;
        has_few && shape.stride == 1 && shape.square_side().is_some()
    }

    /// Packs `weight`, `[channels_out][channels_in][kernel][kernel]`, and `bias`, `[channels_out]`.
    ///
    /// # Panics
    /// If either has another length, or the shape is not [supported](Self::supports).
    pub fn new(shape: ConvShape, weight: &[f32], bias: &[f32], level: Level) -> Self {
        let ConvShape { channels_in, channels_out, .. } = shape;
        assert!(Self::supports(shape), "a few channels and stride 1");
        let taps = channels_in * shape.taps();
        assert_eq!(weight.len(), channels_out * taps, "weights");
        assert_eq!(bias.len(), channels_out, "bias");
        let of_tap =
            |tap: usize| (0..channels_out).map(move |channel| weight[channel * taps + tap]);
        Self { shape, level, weights: (0..taps).flat_map(of_tap).collect(), bias: bias.to_vec() }
    }

    /// Shape of the convolution.
    pub fn shape(&self) -> ConvShape {
        self.shape
    }

    /// Writes `activation(conv(input))` to `output` in nChw16c. Lanes that pad its last block are
    /// left unwritten.
    ///
    /// # Panics
    /// If an image has another size, or the border of the input is narrower than the padding.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: &NchwImage,
        activation: Activation,
        mut output: TensorViewMut<'_>,
    ) {
        let [channels, height, width] = input.size();
        assert_eq!(channels, self.shape.channels_in, "channels of the input");
        assert!(input.border() >= self.shape.border(), "a border as wide as the padding");
        assert_eq!(output.size(), [self.shape.channels_out, height, width], "size of the output");
        let dst = output.dst();
        thread_pool.run(&|part| {
            let dst = Dst::Blocked(dst);
            let kernel = ConvRows { conv: self, input, activation, dst, rows: part.chunk(height) };
            // SAFETY: sizes were compared, rows of the parts are disjoint, and the level is one of
            // this processor's.
            unsafe { self.level.run(&kernel) };
        });
    }

    /// Computes rows `rows` and writes them to the same rows of `dst` in nchw.
    ///
    /// # Safety
    /// The rows are inside the input, and those of `dst` are writable.
    pub(super) unsafe fn rows(
        &self,
        input: &NchwImage,
        activation: Activation,
        dst: F32Dst,
        rows: Range<usize>,
    ) {
        let kernel = ConvRows { conv: self, input, activation, dst: Dst::Nchw(dst), rows };
        // SAFETY: the caller's.
        unsafe { self.level.run(&kernel) };
    }
}

/// Destination, in either layout.
#[derive(Clone, Copy)]
enum Dst {
    Blocked(DstView),
    Nchw(F32Dst),
}

/// Kernel that computes a range of output rows.
struct ConvRows<'a> {
    conv: &'a NchwConv,
    input: &'a NchwImage,
    activation: Activation,
    dst: Dst,
    rows: Range<usize>,
}

impl Kernel for ConvRows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        // SAFETY: the caller's.
        unsafe {
            match self.conv.shape.channels_out {
                1 => self.channels::<V, 1>(),
                2 => self.channels::<V, 2>(),
                3 => self.channels::<V, 3>(),
                _ => self.channels::<V, MAX_CHANNELS>(),
            }
        }
    }
}

impl ConvRows<'_> {
    /// Computes the rows of `C` output channels.
    ///
    /// # Safety
    /// That of [`Kernel::run`]; the convolution has `C` output channels.
    #[inline(always)]
    unsafe fn channels<V: Lanes, const C: usize>(&self) {
        let ConvShape { channels_in, kernel: [kernel, _], .. } = self.conv.shape;
        let [_, _, width] = self.input.size();
        for y in self.rows.clone() {
            for x in (0..width).step_by(LANES) {
                // SAFETY: the caller's. Taps of lanes beyond the last column read the next row or
                // the padding at the end of the image; their sums are discarded.
                unsafe {
                    let mut sums: [V; C] = std::array::from_fn(|c| V::splat(self.conv.bias[c]));
                    let mut weights = self.conv.weights.as_ptr();
                    for channel in 0..channels_in {
                        let first = self.input.row_start(channel, y) + x;
                        // Half a kernel to the left and above, where the border is.
                        let corner = first - (self.input.row_pitch() + 1) * (kernel / 2);
                        let from = self.input.values().as_ptr().add(corner);
                        for ky in 0..kernel {
                            for kx in 0..kernel {
                                let value = V::load(from.add(ky * self.input.row_pitch() + kx));
                                for (c, sum) in sums.iter_mut().enumerate() {
                                    // Each value is loaded once for all output channels.
                                    *sum = value.mul_add(V::splat(*weights.add(c)), *sum);
                                }
                                weights = weights.add(C);
                            }
                        }
                    }
                    for (c, sum) in sums.into_iter().enumerate() {
                        let value = activated(sum, self.activation);
                        let count = LANES.min(width - x);
                        match self.dst {
                            Dst::Blocked(dst) => {
                                dst.scatter(value, dst.row_offset(0, y) + x * LANES + c, count);
                            }
                            Dst::Nchw(dst) => {
                                let at = c * dst.block_pitch + y * dst.row_pitch + x;
                                let to = dst.pixels.wrapping_add(at);
                                if count == LANES {
                                    value.store(to);
                                } else {
                                    // A whole store would overwrite the border.
                                    to.copy_from(value.to_array().as_ptr(), count);
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::blocked::Image;
    use crate::blocked::tests::{
        ReferenceEpilogue, activations, image, magnitude, max_abs_difference, planes,
        random_values, reference_conv,
    };

    proptest! {
        #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

        #[test]
        fn nchw_conv_matches_plain_loops(
            seed in any::<u64>(),
            channels_in in 1_usize..=4,
            channels_out in 1_usize..=4,
            half in 0_usize..=2,
            (height, width) in (1_usize..9, 1_usize..40),
            (threads, activation) in (1_usize..4, activations()),
        ) {
            let shape = ConvShape::square(channels_in, channels_out, 2 * half + 1, 1);
            let size = [height, width];
            let values = random_values(seed, channels_in * height * width);
            let weight = random_values(seed ^ 1, channels_out * channels_in * shape.taps());
            let bias = random_values(seed ^ 2, channels_out);
            let scaled: Vec<f32> = values.iter().map(|value| 2.0 * value - 0.5).collect();
            let after = ReferenceEpilogue { bias: &bias, residual: None, activation };
            let expected = after.apply(reference_conv(shape, &scaled, size, &weight));
            let most = 1e-6 * magnitude(shape, &scaled, size, &weight);
            let mut input = NchwImage::zeros([channels_in, height, width], half);
            for level in Level::available() {
                let conv = NchwConv::new(shape, &weight, &bias, level);
                input.copy_from(&ThreadPool::new(threads), level, &values, [2.0, -0.5]);
                let mut output = Image::zeros(channels_out, height, width, 1);
                conv.run(&ThreadPool::new(threads), &input, activation, TensorViewMut::F32(&mut output));
                let difference = max_abs_difference(&planes(&output), &expected);
                prop_assert!(difference < most, "{level}: {difference}");
                let inner = image(&planes(&output), channels_out, size, 1);
                prop_assert_eq!(inner.lines(), output.lines());
            }
        }
    }
}

//! The 7x7 convolution of stride 2 with which ResNets begin, computed as a dense 4x4 one.
//!
//! Burn's CPU device is slow on few, strided input channels. The same sums come from a convolution
//! of stride 1 over 2x2 pixel blocks, four times the channels and a quarter of the pixels, which
//! runs as a matrix product: a training step of a network a quarter as wide as published takes a
//! seventh less time; from half the width on there is no difference. Where training runs on our own
//! kernels, the convolution is computed as it stands.

use burn::nn::PaddingConfig2d;
use burn::nn::conv::Conv2d;
use burn::tensor::Tensor;
use burn::tensor::module::conv2d;
use burn::tensor::ops::{ConvOptions, PadMode};

const KERNEL: usize = 7;
const PAD: usize = 3;
const STRIDE: usize = 2;

/// Whether a convolution has a 7x7 kernel, stride 2, padding 3, no bias.
pub(super) fn suits(conv: &Conv2d) -> bool {
    conv.kernel_size == [KERNEL; 2]
        && conv.stride == [STRIDE; 2]
        && conv.dilation == [1, 1]
        && conv.groups == 1
        && conv.bias.is_none()
        && matches!(conv.padding, PaddingConfig2d::Explicit(PAD, PAD, PAD, PAD))
}

/// `conv(input)` for a convolution that [`suits`].
///
/// # Model
/// With the kernel extended to 8x8 by a last row and column of zeros, output `(i, j)` sums
/// `k[2a + p][2b + q] x[2(i + a) + p][2(j + b) + q]` over `a, b` in 0..4 and `p, q` in 0..2: a 4x4
/// convolution at stride 1 whose channels are `(c, p, q)`.
///
/// # Shapes
/// - input: `[batch, channels_in, height, width]`
/// - output: `[batch, channels_out, ceil(height / 2), ceil(width / 2)]`
pub(super) fn stride_two_seven(conv: &Conv2d, input: Tensor<4>) -> Tensor<4> {
    assert!(suits(conv));
    let [_, _, height, width] = input.dims();
    let zeros = PadMode::Constant(0.0);
    // An odd side gets one more row or column of zeros, so that blocks of 2x2 divide it.
    let padding = (PAD, PAD + width % STRIDE, PAD, PAD + height % STRIDE);
    let blocks = blocks_to_channels(input.pad(padding, zeros));
    let kernel = blocks_to_channels(conv.weight.val().pad((0, 1, 0, 1), zeros));
    conv2d(blocks, kernel, None, ConvOptions::new([1, 1], [0, 0], [1, 1], 1))
}

/// # Shapes
/// - input: `[n, channels, 2 height, 2 width]`
/// - output: `[n, 4 channels, height, width]`
fn blocks_to_channels(x: Tensor<4>) -> Tensor<4> {
    let [n, channels, height, width] = x.dims();
    let (height, width) = (height / STRIDE, width / STRIDE);
    x.reshape([n, channels, height, STRIDE, width, STRIDE]).permute([0, 1, 3, 5, 2, 4]).reshape([
        n,
        channels * STRIDE * STRIDE,
        height,
        width,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::nn::conv::Conv2dConfig;
    use burn::tensor::{Device, Distribution};

    #[test]
    fn blocks_give_the_strided_convolution_at_even_and_odd_sizes() {
        let device = Device::flex();
        let conv = Conv2dConfig::new([3, 5], [7, 7])
            .with_stride([2, 2])
            .with_padding(PaddingConfig2d::Explicit(3, 3, 3, 3))
            .with_bias(false)
            .init(&device);
        // Sides are even, odd, and shorter than the kernel.
        for (height, width) in [(12, 16), (13, 16), (12, 9), (7, 7), (1, 2)] {
            let shape = [2, 3, height, width];
            let x = Tensor::<4>::random(shape, Distribution::Uniform(-1.0, 1.0), &device);
            let (ours, theirs) = (stride_two_seven(&conv, x.clone()), conv.forward(x));
            assert_eq!(ours.dims(), theirs.dims());
            let worst = (ours - theirs).abs().max().into_scalar::<f32>();
            assert!(worst < 1e-5, "{height}x{width}: {worst}");
        }
    }
}

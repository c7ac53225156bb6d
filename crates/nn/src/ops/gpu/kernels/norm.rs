//! Kernels of batch normalisation.

use cubecl::prelude::*;
use cubecl::std::FastDivmod;

/// `activation((values - mean) * gamma / sqrt(variance + epsilon) + beta)`, with the channel as the last
/// of four dimensions. `activation` is 0 for none, 1 for ReLU, 2 for ReLU6.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn normalize<E: Float>(
    values: &Tensor<E>,
    output: &mut Tensor<E>,
    gamma: &Tensor<E>,
    beta: &Tensor<E>,
    mean: &Tensor<E>,
    variance: &Tensor<E>,
    shape: Sequence<FastDivmod<usize>>,
    epsilon: f32,
    #[comptime] activation: u32,
    #[define(E)] _element: ElemType,
) {
    // The last cube reaches behind the end.
    if ABSOLUTE_POS >= output.len() {
        terminate!();
    }
    // Channels are last in the output, so they run fastest.
    let (rest, channel) = shape.index(3).div_mod(ABSOLUTE_POS);
    let (rest, x) = shape.index(2).div_mod(rest);
    let (image, y) = shape.index(1).div_mod(rest);
    let value = values[image * values.stride(0)
        + channel * values.stride(3)
        + y * values.stride(1)
        + x * values.stride(2)];
    let deviation = E::sqrt(variance[channel] + E::cast_from(epsilon));
    let mut result = (value - mean[channel]) * (gamma[channel] / deviation) + beta[channel];
    if comptime![activation > 0] {
        result = max(result, E::from_int(0));
    }
    if comptime![activation > 1] {
        result = min(result, E::from_int(6));
    }
    output[ABSOLUTE_POS] = result;
}

/// Sums of a channel's differences to its first value, and of their squares, over the pixels of a piece;
/// both of shape `[pieces, channels]`. A piece has `per[0]` pixels, the last one fewer.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn shifted_sums<E: Float>(
    values: &Tensor<E>,
    sums: &mut Tensor<E>,
    squares: &mut Tensor<E>,
    shape: Sequence<FastDivmod<usize>>,
    per: Sequence<usize>,
    #[define(E)] _element: ElemType,
) {
    if ABSOLUTE_POS >= sums.len() {
        terminate!();
    }
    let (piece, channel) = shape.index(3).div_mod(ABSOLUTE_POS);
    let begin = piece * *per.index(0);
    let mut end = begin + *per.index(0);
    let pixels = values.shape(0) * values.shape(1) * values.shape(2);
    if end > pixels {
        end = pixels;
    }
    // Without it, the difference of two large sums would be the variance.
    let shift = values[channel * values.stride(3)];
    let mut sum = E::from_int(0);
    let mut square = E::from_int(0);
    for pixel in begin..end {
        let (rest, x) = shape.index(2).div_mod(pixel);
        let (image, y) = shape.index(1).div_mod(rest);
        let value = values[image * values.stride(0)
            + y * values.stride(1)
            + x * values.stride(2)
            + channel * values.stride(3)]
            - shift;
        sum += value;
        square += value * value;
    }
    sums[ABSOLUTE_POS] = sum;
    squares[ABSOLUTE_POS] = square;
}

/// Mean and variance of each channel from the sums of [`shifted_sums`], and the running ones, moved towards
/// them by a share of `momentum`.
///
/// # Source
/// Chan, Golub and LeVeque, "Algorithms for computing the sample variance", 1983: shifted data.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn moments<E: Float>(
    values: &Tensor<E>,
    sums: &Tensor<E>,
    squares: &Tensor<E>,
    running_mean: &Tensor<E>,
    running_variance: &Tensor<E>,
    mean: &mut Tensor<E>,
    variance: &mut Tensor<E>,
    next_mean: &mut Tensor<E>,
    next_variance: &mut Tensor<E>,
    momentum: f32,
    #[define(E)] _element: ElemType,
) {
    if ABSOLUTE_POS >= mean.len() {
        terminate!();
    }
    let channels = mean.len();
    let mut sum = E::from_int(0);
    let mut square = E::from_int(0);
    for piece in 0..sums.shape(0) {
        sum += sums[piece * channels + ABSOLUTE_POS];
        square += squares[piece * channels + ABSOLUTE_POS];
    }
    let pixels = values.shape(0) * values.shape(1) * values.shape(2);
    let count = E::cast_from(pixels);
    let offset = sum / count;
    let center = values[ABSOLUTE_POS * values.stride(3)] + offset;
    // Rounding may leave a constant channel below zero, where the root is not a number.
    let spread = max(square / count - offset * offset, E::from_int(0));
    mean[ABSOLUTE_POS] = center;
    variance[ABSOLUTE_POS] = spread;
    let new = E::cast_from(momentum);
    let old = E::from_int(1) - new;
    next_mean[ABSOLUTE_POS] = old * running_mean[ABSOLUTE_POS] + new * center;
    next_variance[ABSOLUTE_POS] = old * running_variance[ABSOLUTE_POS] + new * spread;
}

/// Sums of the gradients by beta and by gamma, over the pixels of a piece; both of shape
/// `[pieces, channels]`, pieces as in [`shifted_sums`].
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn parameter_sums<E: Float>(
    values: &Tensor<E>,
    gradient: &Tensor<E>,
    gamma: &Tensor<E>,
    beta: &Tensor<E>,
    mean: &Tensor<E>,
    variance: &Tensor<E>,
    by_beta: &mut Tensor<E>,
    by_gamma: &mut Tensor<E>,
    shape: Sequence<FastDivmod<usize>>,
    per: Sequence<usize>,
    epsilon: f32,
    #[comptime] activation: u32,
    #[define(E)] _element: ElemType,
) {
    if ABSOLUTE_POS >= by_beta.len() {
        terminate!();
    }
    let (piece, channel) = shape.index(3).div_mod(ABSOLUTE_POS);
    let begin = piece * *per.index(0);
    let mut end = begin + *per.index(0);
    let pixels = values.shape(0) * values.shape(1) * values.shape(2);
    if end > pixels {
        end = pixels;
    }
    let scale = E::from_int(1) / E::sqrt(variance[channel] + E::cast_from(epsilon));
    let center = mean[channel];
    let (slope, offset) = (gamma[channel], beta[channel]);
    let mut sum = E::from_int(0);
    let mut product = E::from_int(0);
    for pixel in begin..end {
        let (rest, x) = shape.index(2).div_mod(pixel);
        let (image, y) = shape.index(1).div_mod(rest);
        let normal = (values[image * values.stride(0)
            + y * values.stride(1)
            + x * values.stride(2)
            + channel * values.stride(3)]
            - center)
            * scale;
        let by_output = gradient[image * gradient.stride(0)
            + y * gradient.stride(1)
            + x * gradient.stride(2)
            + channel * gradient.stride(3)];
        // The output before its activation is computed again: to keep it would cost a batch of
        // memory.
        let by_norm = before_activation::<E>(by_output, normal * slope + offset, activation);
        sum += by_norm;
        product += by_norm * normal;
    }
    by_beta[ABSOLUTE_POS] = sum;
    by_gamma[ABSOLUTE_POS] = product;
}

/// The gradient by the values of a batch, which its mean and variance depend on too.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn value_gradient<E: Float>(
    values: &Tensor<E>,
    gradient: &Tensor<E>,
    gamma: &Tensor<E>,
    beta: &Tensor<E>,
    mean: &Tensor<E>,
    variance: &Tensor<E>,
    by_beta: &Tensor<E>,
    by_gamma: &Tensor<E>,
    output: &mut Tensor<E>,
    shape: Sequence<FastDivmod<usize>>,
    epsilon: f32,
    #[comptime] activation: u32,
    #[define(E)] _element: ElemType,
) {
    if ABSOLUTE_POS >= output.len() {
        terminate!();
    }
    let (rest, channel) = shape.index(3).div_mod(ABSOLUTE_POS);
    let (rest, x) = shape.index(2).div_mod(rest);
    let (image, y) = shape.index(1).div_mod(rest);
    let scale = E::from_int(1) / E::sqrt(variance[channel] + E::cast_from(epsilon));
    let normal = (values[image * values.stride(0)
        + y * values.stride(1)
        + x * values.stride(2)
        + channel * values.stride(3)]
        - mean[channel])
        * scale;
    let by_output = gradient[image * gradient.stride(0)
        + y * gradient.stride(1)
        + x * gradient.stride(2)
        + channel * gradient.stride(3)];
    let slope = gamma[channel];
    let by_norm = before_activation::<E>(by_output, normal * slope + beta[channel], activation);
    let pixels = values.shape(0) * values.shape(1) * values.shape(2);
    // Mean and variance move with every value: their share of the gradient is taken off.
    let mean_gradient = (by_beta[channel] + normal * by_gamma[channel]) / E::cast_from(pixels);
    output[ABSOLUTE_POS] = slope * scale * (by_norm - mean_gradient);
}

/// The gradient by `value` from that by its activation.
#[cube]
#[allow(
    clippy::collapsible_if,
    reason = "the outer conditions are decided when a kernel is compiled"
)]
fn before_activation<E: Float>(gradient: E, value: E, #[comptime] activation: u32) -> E {
    let mut result = gradient;
    // At the kinks themselves the gradient is zero, as PyTorch has it.
    if comptime![activation > 0] {
        if value <= E::from_int(0) {
            result = E::from_int(0);
        }
    }
    if comptime![activation > 1] {
        if value >= E::from_int(6) {
            result = E::from_int(0);
        }
    }
    result
}

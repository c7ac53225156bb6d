//! Every operation against plain loops in double precision, over odd shapes, on every level.

use proptest::prelude::*;

use super::*;
use crate::Level;

mod chain;
mod unary;

/// Pseudo-random values between -1 and 1.
pub(crate) fn random_values(seed: u64, count: usize) -> Vec<f32> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

pub(super) fn image(planes: &[f32], channels: usize, size: [usize; 2], border: usize) -> Image {
    let mut image = Image::zeros(channels, size[0], size[1], border);
    image.copy_from_nchw(planes);
    image
}

pub(super) fn planes(image: &Image) -> Vec<f32> {
    let mut planes = vec![0.0; image.channels() * image.height() * image.width()];
    image.copy_to_nchw(&mut planes);
    planes
}

pub(crate) fn activated(value: f64, activation: Activation) -> f64 {
    match activation {
        Activation::Identity => value,
        Activation::Relu => value.max(0.0),
        Activation::Relu6 => value.clamp(0.0, 6.0),
    }
}

/// Convolution by plain loops in double precision.
pub(super) fn reference_conv(
    shape: ConvShape,
    input: &[f32],
    size: [usize; 2],
    weight: &[f32],
) -> Vec<f64> {
    let ConvShape { channels_in, channels_out, kernel: [_, columns], stride, padding } = shape;
    let [height, width] = size;
    let mut output = Vec::new();
    for channel in 0..channels_out {
        for y in 0..shape.output(size)[0] {
            for x in 0..shape.output(size)[1] {
                let mut sum = 0.0;
                for from in 0..channels_in {
                    for (tap, weight) in weight[(channel * channels_in + from) * shape.taps()..]
                        [..shape.taps()]
                        .iter()
                        .enumerate()
                    {
                        let at = |out: usize, tap: usize, padding: usize| {
                            (out * stride + tap).checked_sub(padding)
                        };
                        let (Some(y), Some(x)) =
                            (at(y, tap / columns, padding[0]), at(x, tap % columns, padding[1]))
                        else {
                            continue;
                        };
                        if y < height && x < width {
                            let value = input[(from * height + y) * width + x];
                            sum += f64::from(value) * f64::from(*weight);
                        }
                    }
                }
                output.push(sum);
            }
        }
    }
    output
}

/// Bias, residual and activation of a reference convolution.
pub(super) struct ReferenceEpilogue<'a> {
    pub(super) bias: &'a [f32],
    pub(super) residual: Option<&'a Vec<f32>>,
    pub(super) activation: Activation,
}

impl ReferenceEpilogue<'_> {
    pub(super) fn apply(&self, mut sums: Vec<f64>) -> Vec<f64> {
        let pixels = sums.len() / self.bias.len();
        for (i, value) in sums.iter_mut().enumerate() {
            let sum = *value + f64::from(self.bias[i / pixels]);
            let sum = sum + self.residual.map_or(0.0, |residual| f64::from(residual[i]));
            *value = activated(sum, self.activation);
        }
        sums
    }
}

/// The largest sum of a convolution whose products do not cancel: rounding is relative to it.
pub(super) fn magnitude(shape: ConvShape, input: &[f32], size: [usize; 2], weight: &[f32]) -> f64 {
    let [input, weight] =
        [input, weight].map(|values| values.iter().map(|value| value.abs()).collect::<Vec<_>>());
    reference_conv(shape, &input, size, &weight).into_iter().fold(1.0, f64::max)
}

pub(super) fn max_abs_difference(ours: &[f32], expected: &[f64]) -> f64 {
    assert_eq!(ours.len(), expected.len());
    let pairs = ours.iter().zip(expected);
    pairs.map(|(ours, expected)| (f64::from(*ours) - expected).abs()).fold(0.0, f64::max)
}

pub(crate) fn activations() -> impl Strategy<Value = Activation> {
    prop_oneof![Just(Activation::Identity), Just(Activation::Relu), Just(Activation::Relu6)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn conv_matches_plain_loops(
        (channels_in, channels_out) in (1..50_usize, 1..70_usize),
        kernel in [1..8_usize, 1..8_usize],
        is_square: bool,
        padding in [0..4_usize, 0..4_usize],
        stride in 1..3_usize,
        size in [1..12_usize, 1..31_usize],
        activation in activations(),
        has_residual: bool,
        threads in 1..4_usize,
        seed: u64,
    ) {
        let shape = match is_square {
            true => ConvShape::square(channels_in, channels_out, kernel[0] | 1, stride),
            false => ConvShape { channels_in, channels_out, kernel, stride, padding },
        };
        let out = shape.output(size);
        prop_assume!(out[0] * out[1] > 0);
        let input = random_values(seed, channels_in * size[0] * size[1]);
        let weight = random_values(seed ^ 1, channels_out * channels_in * shape.taps());
        let bias = random_values(seed ^ 2, channels_out);
        let residual = random_values(seed ^ 3, channels_out * out[0] * out[1]);
        let after = ReferenceEpilogue { bias: &bias, residual: has_residual.then_some(&residual), activation };
        let expected = after.apply(reference_conv(shape, &input, size, &weight));
        let magnitude = magnitude(shape, &input, size, &weight);
        let input = image(&input, channels_in, size, shape.border());
        let residual = has_residual.then(|| image(&residual, channels_out, out, 1));
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let conv = Conv::new(shape, &weight, &bias, level);
            let mut output = Image::zeros(channels_out, out[0], out[1], 1);
            conv.run(&thread_pool, &input, residual.as_ref(), activation, &mut output);
            let apart = max_abs_difference(&planes(&output), &expected) / magnitude;
            prop_assert!(apart < 5e-7, "{level}: {apart}");
            prop_assert!(output.is_zero_outside(), "{level}: the border is not zero");
        }
    }

    #[test]
    fn winograd_matches_plain_loops(
        channels in [1..40_usize, 1..70_usize],
        size in [1..26_usize, 1..40_usize],
        activation in activations(),
        has_residual: bool,
        is_plain: bool,
        threads in 1..4_usize,
        seed: u64,
    ) {
        let [channels_in, channels_out] = channels;
        let shape = ConvShape::square(channels_in, channels_out, 3, 1);
        let input = random_values(seed, channels_in * size[0] * size[1]);
        let weight = random_values(seed ^ 1, channels_out * channels_in * 9);
        let bias = random_values(seed ^ 2, channels_out);
        let residual = random_values(seed ^ 3, channels_out * size[0] * size[1]);
        let after = ReferenceEpilogue { bias: &bias, residual: has_residual.then_some(&residual), activation };
        let expected = after.apply(reference_conv(shape, &input, size, &weight));
        let magnitude = magnitude(shape, &input, size, &weight);
        let input = image(&input, channels_in, size, 1);
        let residual = has_residual.then(|| image(&residual, channels_out, size, 0));
        let thread_pool = ThreadPool::new(threads);
        let mut scratch = Scratch::default();
        for level in Level::available() {
            for (tile, most) in
                [(TileSize::Two, 1e-6), (TileSize::Four, 5e-6), (TileSize::TwoByFour, 5e-6)]
            {
                let conv = Winograd::with_transform(channels, &weight, &bias, tile, level, is_plain);
                let mut output = Image::zeros(channels_out, size[0], size[1], 1);
                let residual = residual.as_ref();
                conv.run(&thread_pool, &input, residual, activation, &mut output, &mut scratch);
                let apart = max_abs_difference(&planes(&output), &expected) / magnitude;
                prop_assert!(apart < most, "{level} {tile:?}: {apart}");
                prop_assert!(output.is_zero_outside(), "{level}: the border is not zero");
            }
        }
    }

    #[test]
    fn depthwise_matches_convolutions_of_one_channel(
        channels in 1..50_usize,
        kernel in prop::sample::select(vec![3_usize, 5]),
        stride in 1..3_usize,
        size in [1..14_usize, 1..40_usize],
        activation in activations(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let one = ConvShape::square(1, 1, kernel, stride);
        let pixels = size[0] * size[1];
        let input = random_values(seed, channels * pixels);
        let weight = random_values(seed ^ 1, channels * kernel * kernel);
        let bias = random_values(seed ^ 2, channels);
        let each = input.chunks(pixels).zip(weight.chunks(kernel * kernel));
        let sums = each.flat_map(|(input, weight)| reference_conv(one, input, size, weight)).collect();
        let expected = ReferenceEpilogue { bias: &bias, residual: None, activation }.apply(sums);
        let input = image(&input, channels, size, kernel / 2);
        let out = one.output(size);
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let shape = DepthwiseShape { channels, kernel, stride };
            let conv = Depthwise::new(shape, &weight, &bias, level);
            let mut output = Image::zeros(channels, out[0], out[1], 2);
            conv.run(&thread_pool, &input, activation, TensorViewMut::F32(&mut output));
            let apart = max_abs_difference(&planes(&output), &expected);
            prop_assert!(apart < 5e-6, "{level}: {apart}");
            prop_assert!(output.is_zero_outside(), "{level}: the border is not zero");
        }
    }

    #[test]
    fn pooling_matches_plain_loops(
        channels in 1..40_usize,
        size in [2..20_usize, 2..30_usize],
        (window, stride, padding) in prop::sample::select(vec![(3, 2, 1), (2, 2, 0), (3, 1, 1)]),
        parts in [1..9_usize, 1..9_usize],
        threads in 1..4_usize,
        seed: u64,
    ) {
        let pool = MaxPool { window, stride, padding };
        prop_assume!(size.iter().all(|side| pool.output(*side) > 0));
        let input = random_values(seed, channels * size[0] * size[1]);
        let over = |rows: std::ops::Range<usize>, columns: std::ops::Range<usize>, channel: usize| {
            let plane = &input[channel * size[0] * size[1]..][..size[0] * size[1]];
            let values = rows.flat_map(|y| plane[y * size[1]..][columns.clone()].to_vec());
            values.map(f64::from).collect::<Vec<_>>()
        };
        let inside = |k: usize, side: usize| {
            let from = (k * stride) as isize - padding as isize;
            from.max(0) as usize..((from + window as isize) as usize).min(side)
        };
        let out = size.map(|side| pool.output(side));
        let (mut maxima, mut means) = (Vec::new(), Vec::new());
        for channel in 0..channels {
            for (y, x) in (0..out[0]).flat_map(|y| (0..out[1]).map(move |x| (y, x))) {
                let values = over(inside(y, size[0]), inside(x, size[1]), channel);
                maxima.push(values.into_iter().fold(f64::NEG_INFINITY, f64::max));
            }
            for (y, x) in (0..parts[0]).flat_map(|y| (0..parts[1]).map(move |x| (y, x))) {
                let part = |k: usize, side: usize, of: usize| k * side / of..((k + 1) * side).div_ceil(of);
                let values = over(part(y, size[0], parts[0]), part(x, size[1], parts[1]), channel);
                means.push(values.iter().sum::<f64>() / values.len() as f64);
            }
        }
        let image = image(&input, channels, size, 1);
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let mut output = Image::zeros(channels, out[0], out[1], 1);
            pool.run(&thread_pool, level, &image, &mut output);
            prop_assert_eq!(max_abs_difference(&planes(&output), &maxima), 0.0);
            prop_assert!(output.is_zero_outside());
            let mut output = Image::zeros(channels, parts[0], parts[1], 0);
            adaptive_avg_pool(&thread_pool, level, &image, &mut output);
            prop_assert!(max_abs_difference(&planes(&output), &means) < 1e-6);
            prop_assert!(output.is_zero_outside());
        }
    }

    #[test]
    fn add_gather_and_flatten_match_plain_loops(
        channels in 1..40_usize,
        size in [1..9_usize, 1..20_usize],
        activation in activations(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let pixels = size[0] * size[1];
        let [one, other] = [seed, seed ^ 1].map(|seed| random_values(seed, channels * pixels));
        let [a, b] = [&one, &other].map(|planes| image(planes, channels, size, 1));
        let thread_pool = ThreadPool::new(threads);
        let sums = one.iter().zip(&other).map(|(a, b)| f64::from(a + b));
        let sums: Vec<f64> = sums.map(|sum| activated(sum, activation)).collect();
        for level in Level::available() {
            let mut output = Image::zeros(channels, size[0], size[1], 2);
            add(&thread_pool, level, &a, Some(&b), activation, &mut output);
            prop_assert_eq!(max_abs_difference(&planes(&output), &sums), 0.0);
            prop_assert!(output.is_zero_outside());
        }
        let mut interleaved = Image::zeros(2 * channels, size[0], size[1], 1);
        gather_channels(&mut interleaved, |channel| (if channel % 2 == 0 { &a } else { &b }, channel / 2));
        let want = one.chunks(pixels).zip(other.chunks(pixels)).flat_map(|(a, b)| [a, b].concat());
        prop_assert_eq!(planes(&interleaved), want.collect::<Vec<_>>());
        let mut vector = Image::zeros(channels * pixels, 1, 1, 0);
        flatten(&a, &mut vector);
        prop_assert_eq!(planes(&vector), one);
    }
}

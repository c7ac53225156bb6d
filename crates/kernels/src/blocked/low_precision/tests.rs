//! Low-precision operators against plain loops in double precision, on every level.

use proptest::prelude::*;

use super::*;
use crate::Level;
use crate::blocked::tests::{
    ReferenceEpilogue, activations, image, magnitude, max_abs_difference, planes, random_values,
    reference_conv,
};
use crate::blocked::{
    Activation, ConvShape, Depthwise, DepthwiseShape, Image, MaxPool, ThreadPool, upsample,
};
use crate::simd::dots::{Bf16, ReducedPrecision as _};

mod amx;

/// Element types for values between -1 and 1.
fn element_types() -> impl Strategy<Value = LowPrecisionType> {
    prop_oneof![
        Just(LowPrecisionType::Bf16),
        Just(LowPrecisionType::Uint8(QuantizationParams::from_range(0.0, 1.0))),
        quantization().prop_map(LowPrecisionType::Uint8),
    ]
}

/// Parameters of uint8 for values between -1 and 1.
fn quantization() -> impl Strategy<Value = QuantizationParams> {
    (-1.5_f32..-0.5, 0.5_f32..1.5).prop_map(|(low, high)| QuantizationParams::from_range(low, high))
}

/// An image of low precision with these values.
fn packed(
    planes: &[f32],
    size: [usize; 3],
    border: usize,
    element_type: LowPrecisionType,
) -> LowPrecisionImage {
    let mut packed = LowPrecisionImage::zeros(size, border, element_type);
    let image = image(planes, size[0], [size[1], size[2]], 0);
    convert(TensorView::F32(&image), TensorViewMut::LowPrecision(&mut packed));
    packed
}

/// Values of an image of low precision, in nchw.
fn unpacked(packed: &LowPrecisionImage) -> Vec<f32> {
    let [channels, height, width] = packed.size();
    let mut image = Image::zeros(channels, height, width, 0);
    convert(TensorView::LowPrecision(packed), TensorViewMut::F32(&mut image));
    planes(&image)
}

/// Converts an image to another element type.
fn convert(from: TensorView<'_>, to: TensorViewMut<'_>) {
    add_mixed_precision(&ThreadPool::new(1), Level::Portable, from, None, Activation::Identity, to);
}

/// Weights after quantisation and back: int8 has a scale per output channel.
fn round_trip_weights(weight: &[f32], outputs: usize, element_type: LowPrecisionType) -> Vec<f32> {
    match element_type {
        LowPrecisionType::Bf16 => {
            weight.iter().map(|value| Bf16::nearest(*value).value()).collect()
        }
        LowPrecisionType::Uint8(_) => {
            let of = |kernel: &[f32]| -> Vec<f32> {
                let scale =
                    kernel.iter().fold(0.0_f32, |most, value| most.max(value.abs())) / 127.0;
                kernel.iter().map(|value| (value / scale).round() * scale).collect()
            };
            weight.chunks(weight.len() / outputs).flat_map(of).collect()
        }
    }
}

/// Largest rounding error of a value between -`most` and `most`.
fn rounding(element_type: LowPrecisionType, most: f64) -> f64 {
    match element_type {
        LowPrecisionType::Bf16 => most / 256.0,
        LowPrecisionType::Uint8(QuantizationParams { scale, .. }) => f64::from(scale) / 2.0,
    }
}

#[test]
fn zero_is_exact_and_the_range_is_covered_within_a_step() {
    for (low, high) in [(0.0, 1.0), (-1.0, 3.0), (0.5, 2.0), (-4.0, -1.0), (0.0, 0.0)] {
        let params = QuantizationParams::from_range(low, high);
        let value = |byte: u8| (f32::from(byte) - f32::from(params.zero_point)) * params.scale;
        assert_eq!(value(params.zero_point), 0.0);
        for end in [low, high] {
            let nearest = (0..=255).map(|byte| (value(byte) - end).abs()).fold(f32::MAX, f32::min);
            assert!(nearest <= params.scale, "{low} {high}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn conversion_rounds_to_nearest(
        channels in 1..40_usize,
        size in [1..9_usize, 1..20_usize],
        low in -1.5_f32..-1.0,
        high in 1.0_f32..1.5,
        seed: u64,
    ) {
        let values = random_values(seed, channels * size[0] * size[1]);
        let expected: Vec<f64> = values.iter().map(|value| f64::from(*value)).collect();
        for element_type in [LowPrecisionType::Bf16, LowPrecisionType::Uint8(QuantizationParams::from_range(low, high))] {
            let packed = packed(&values, [channels, size[0], size[1]], 2, element_type);
            let apart = max_abs_difference(&unpacked(&packed), &expected);
            prop_assert!(apart <= rounding(element_type, 1.0) * 1.001, "{element_type:?}: {apart}");
        }
    }

    #[test]
    fn conv_matches_plain_loops_on_quantised_values(
        (channels_in, channels_out) in (1..50_usize, 1..70_usize),
        kernel in prop::sample::select(vec![1_usize, 3, 7]),
        stride in 1..3_usize,
        size in [1..10_usize, 1..31_usize],
        activation in activations(),
        has_residual: bool,
        element_type in element_types(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let shape = ConvShape::square(channels_in, channels_out, kernel, stride);
        let out = shape.output(size);
        let input = random_values(seed, channels_in * size[0] * size[1]);
        let input = packed(&input, [channels_in, size[0], size[1]], kernel / 2, element_type);
        let weight = random_values(seed ^ 1, channels_out * channels_in * kernel * kernel);
        let bias = random_values(seed ^ 2, channels_out);
        let residual = random_values(seed ^ 3, channels_out * out[0] * out[1]);
        let residual = packed(&residual, [channels_out, out[0], out[1]], 0, element_type);
        let added = unpacked(&residual);
        let after = ReferenceEpilogue { bias: &bias, residual: has_residual.then_some(&added), activation };
        let (from, by) = (unpacked(&input), round_trip_weights(&weight, channels_out, element_type));
        let expected = after.apply(reference_conv(shape, &from, size, &by));
        let most = expected.iter().fold(0.0_f64, |most, value| most.max(value.abs())) as f32;
        let to = match element_type {
            LowPrecisionType::Bf16 => LowPrecisionType::Bf16,
            LowPrecisionType::Uint8(_) if activation == Activation::Identity => {
                LowPrecisionType::Uint8(QuantizationParams::from_range(-most, most))
            }
            LowPrecisionType::Uint8(_) => LowPrecisionType::Uint8(QuantizationParams::from_range(0.0, most)),
        };
        let magnitude = magnitude(shape, &from, size, &by);
        let exact = 1e-6 * magnitude + rounding(to, f64::from(most));
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let conv = LowPrecisionConv::new(shape, &weight, &bias, element_type, level);
            let mut output = LowPrecisionImage::zeros([channels_out, out[0], out[1]], 1, to);
            let residual = has_residual.then_some(TensorView::LowPrecision(&residual));
            conv.run(&thread_pool, &input, residual, activation, TensorViewMut::LowPrecision(&mut output));
            let off = max_abs_difference(&unpacked(&output), &expected);
            // A sum that lies between two values may be rounded either way.
            prop_assert!(off <= 1.01 * exact, "{level} {element_type:?}: {off}, {exact}");
            let mut output = Image::zeros(channels_out, out[0], out[1], 0);
            conv.run(&thread_pool, &input, residual, activation, TensorViewMut::F32(&mut output));
            let off = max_abs_difference(&planes(&output), &expected);
            prop_assert!(off <= 1e-6 * magnitude, "{level} {element_type:?}: {off}, {magnitude}");
            prop_assert!(output.is_zero_outside());
        }
    }

    #[test]
    fn depthwise_matches_f32_on_quantised_values(
        channels in 1..50_usize,
        kernel in prop::sample::select(vec![3_usize, 5]),
        stride in 1..3_usize,
        size in [1..14_usize, 1..40_usize],
        activation in activations(),
        params in quantization(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let shape = DepthwiseShape { channels, kernel, stride };
        let element_type = LowPrecisionType::Uint8(params);
        let input = random_values(seed, channels * size[0] * size[1]);
        let input = packed(&input, [channels, size[0], size[1]], kernel / 2, element_type);
        let weight = random_values(seed ^ 1, channels * kernel * kernel);
        let bias = random_values(seed ^ 2, channels);
        let (from, by) = (unpacked(&input), round_trip_weights(&weight, channels, element_type));
        let out = size.map(|side| side.div_ceil(stride));
        let thread_pool = ThreadPool::new(threads);
        // That one is held to sums in double precision.
        let whole = Depthwise::new(shape, &by, &bias, Level::Portable);
        let mut expected = Image::zeros(channels, out[0], out[1], 0);
        let from = image(&from, channels, size, kernel / 2);
        whole.run(&thread_pool, &from, activation, TensorViewMut::F32(&mut expected));
        // What it writes in bf16 is rounded.
        let mut rounded = LowPrecisionImage::zeros([channels, out[0], out[1]], 1, LowPrecisionType::Bf16);
        whole.run(&thread_pool, &from, activation, TensorViewMut::LowPrecision(&mut rounded));
        let nearest: Vec<f32> =
            planes(&expected).iter().map(|value| Bf16::nearest(*value).value()).collect();
        prop_assert_eq!(unpacked(&rounded), nearest);
        let expected: Vec<f64> = planes(&expected).into_iter().map(f64::from).collect();
        for level in Level::available() {
            let conv = QuantizedDepthwise::new(shape, &weight, &bias, params, level);
            let mut output = Image::zeros(channels, out[0], out[1], 1);
            conv.run(&thread_pool, &input, activation, TensorViewMut::F32(&mut output));
            let off = max_abs_difference(&planes(&output), &expected);
            prop_assert!(off <= 3e-5, "{level} {params:?}: {off}");
            prop_assert!(output.is_zero_outside());
        }
    }

    #[test]
    fn pooling_and_upsampling_match_f32(
        channels in 1..40_usize,
        size in [2..20_usize, 2..30_usize],
        (window, stride, padding) in prop::sample::select(vec![(3, 2, 1), (2, 2, 0), (3, 1, 1)]),
        element_type in element_types(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let pool = MaxPool { window, stride, padding };
        let values = random_values(seed, channels * size[0] * size[1]);
        let packed = packed(&values, [channels, size[0], size[1]], 0, element_type);
        let whole = image(&unpacked(&packed), channels, size, 0);
        let (pooled, doubled) = (size.map(|side| pool.output(side)), size.map(|side| 2 * side));
        let thread_pool = ThreadPool::new(threads);
        let blank = |size: [usize; 2]| Image::zeros(channels, size[0], size[1], 0);
        let wide = |image: &Image| planes(image).into_iter().map(f64::from).collect::<Vec<_>>();
        for level in Level::available() {
            let (mut maxima, mut between) = (blank(pooled), blank(doubled));
            pool.run(&thread_pool, level, &whole, &mut maxima);
            upsample(&thread_pool, level, &whole, &mut between);
            let small = |size: [usize; 2]| LowPrecisionImage::zeros([channels, size[0], size[1]], 1, element_type);
            let mut output = small(pooled);
            max_pool_low_precision(&thread_pool, level, pool, &packed, &mut output);
            prop_assert!(max_abs_difference(&unpacked(&output), &wide(&maxima)) <= 1e-6);
            let mut output = small(doubled);
            upsample_low_precision(&thread_pool, level, &packed, &mut output);
            let off = max_abs_difference(&unpacked(&output), &wide(&between));
            prop_assert!(off <= 1.01 * rounding(element_type, 1.0), "{level} {element_type:?}: {off}");
        }
    }

    #[test]
    fn sums_match_f32(
        channels in 1..40_usize,
        size in [1..9_usize, 1..20_usize],
        activation in activations(),
        [one, other, to] in [element_types(), element_types(), element_types()],
        threads in 1..4_usize,
        seed: u64,
    ) {
        let of = |seed: u64, element_type: LowPrecisionType| {
            let values = random_values(seed, channels * size[0] * size[1]);
            packed(&values, [channels, size[0], size[1]], 1, element_type)
        };
        let (one, other) = (of(seed, one), of(seed ^ 1, other));
        let pairs = unpacked(&one).into_iter().zip(unpacked(&other));
        let sums: Vec<f64> = pairs
            .map(|(one, other)| {
                let sum = f64::from(one) + f64::from(other);
                if activation == Activation::Identity { sum } else { sum.max(0.0) }
            })
            .collect();
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let [one, other] = [&one, &other].map(TensorView::LowPrecision);
            let mut whole = Image::zeros(channels, size[0], size[1], 0);
            add_mixed_precision(&thread_pool, level, one, Some(other), activation, TensorViewMut::F32(&mut whole));
            prop_assert!(max_abs_difference(&planes(&whole), &sums) <= 1e-6);
            // What is beyond the ends of a scale is kept as these.
            let mut small = LowPrecisionImage::zeros([channels, size[0], size[1]], 2, to);
            add_mixed_precision(&thread_pool, level, one, Some(other), activation, TensorViewMut::LowPrecision(&mut small));
            let ends = match to {
                LowPrecisionType::Bf16 => [-2.0, 2.0],
                LowPrecisionType::Uint8(QuantizationParams { scale, zero_point }) => {
                    [-f64::from(zero_point), 255.0 - f64::from(zero_point)].map(|end| end * f64::from(scale))
                }
            };
            let clamped: Vec<f64> = sums.iter().map(|sum| sum.clamp(ends[0], ends[1])).collect();
            let off = max_abs_difference(&unpacked(&small), &clamped);
            prop_assert!(off <= 1.01 * rounding(to, 2.0) + 1e-6, "{level} {to:?}: {off}");
        }
    }

    #[test]
    fn reorder_matches_conversion(
        channels in 1..40_usize,
        size in [1..9_usize, 1..40_usize],
        [factor, offset] in [0.5_f32..2.0, -0.5_f32..0.5],
        element_type in element_types(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let shape = [channels, size[0], size[1]];
        let values = random_values(seed, channels * size[0] * size[1]);
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let mut whole = Image::zeros(channels, size[0], size[1], 1);
            reorder_from_nchw(&thread_pool, level, &values, [factor, offset], TensorViewMut::F32(&mut whole));
            let want: Vec<f64> =
                values.iter().map(|v| f64::from(factor) * f64::from(*v) + f64::from(offset)).collect();
            prop_assert!(max_abs_difference(&planes(&whole), &want) < 1e-6);
            prop_assert!(whole.is_zero_outside());
            let (mut packed, mut read) =
                (LowPrecisionImage::zeros(shape, 1, element_type), LowPrecisionImage::zeros(shape, 1, element_type));
            convert(TensorView::F32(&whole), TensorViewMut::LowPrecision(&mut packed));
            reorder_from_nchw(&thread_pool, level, &values, [factor, offset], TensorViewMut::LowPrecision(&mut read));
            let apart = max_abs_difference(&unpacked(&read), &unpacked(&packed).iter().map(|v| f64::from(*v)).collect::<Vec<_>>());
            // Values between two steps may be rounded either way.
            prop_assert!(apart <= 2.01 * rounding(element_type, 2.0), "{level} {element_type:?}: {apart}");
        }
    }
}

//! Images of fewer bits against plain loops in double precision, on every level.

use proptest::prelude::*;

use super::*;
use crate::Level;
use crate::blocked::tests::{
    After, activations, apart, convolved, image, magnitude, noise, planes,
};
use crate::blocked::{
    Activation, ConvShape, Depthwise, DepthwiseShape, Image, MaxPool, ThreadPool, upsample,
};
use crate::simd::dots::{Bf16, Stored as _};

/// Ways to keep numbers between -1 and 1.
fn storages() -> impl Strategy<Value = Storage> {
    prop_oneof![
        Just(Storage::Bf16),
        Just(Storage::Byte(Scale::of(0.0, 1.0))),
        (-1.5_f32..-0.5, 0.5_f32..1.5).prop_map(|(low, high)| Storage::Byte(Scale::of(low, high))),
    ]
}

/// Whole channels of an image that is kept in fewer bits.
fn packed(planes: &[f32], size: [usize; 3], border: usize, storage: Storage) -> Packed {
    let mut packed = Packed::zeros(size, border, storage);
    let image = image(planes, size[0], [size[1], size[2]], 0);
    held(Held::Whole(&image), HeldMut::Packed(&mut packed));
    packed
}

/// What an image stands for.
fn unpacked(packed: &Packed) -> Vec<f32> {
    let [channels, height, width] = packed.size();
    let mut image = Image::zeros(channels, height, width, 0);
    held(Held::Packed(packed), HeldMut::Whole(&mut image));
    planes(&image)
}

/// The same image, kept otherwise.
fn held(from: Held<'_>, to: HeldMut<'_>) {
    add_held(&ThreadPool::new(1), Level::Portable, from, None, Activation::Identity, to);
}

/// Weights as they are kept: of 8 bits each output has its own step.
fn kept(weight: &[f32], outputs: usize, storage: Storage) -> Vec<f32> {
    match storage {
        Storage::Bf16 => weight.iter().map(|value| Bf16::nearest(*value).value()).collect(),
        Storage::Byte(_) => {
            let of = |kernel: &[f32]| -> Vec<f32> {
                let step = kernel.iter().fold(0.0_f32, |most, value| most.max(value.abs())) / 127.0;
                kernel.iter().map(|value| (value / step).round() * step).collect()
            };
            weight.chunks(weight.len() / outputs).flat_map(of).collect()
        }
    }
}

/// By how much a value between -`most` and `most` is off at worst where it is kept.
fn rounding(storage: Storage, most: f64) -> f64 {
    match storage {
        Storage::Bf16 => most / 256.0,
        Storage::Byte(Scale { step, .. }) => f64::from(step) / 2.0,
    }
}

#[test]
fn zero_is_kept_exactly_and_the_ends_within_a_step() {
    for (low, high) in [(0.0, 1.0), (-1.0, 3.0), (0.5, 2.0), (-4.0, -1.0), (0.0, 0.0)] {
        let scale = Scale::of(low, high);
        let value = |byte: u8| (f32::from(byte) - f32::from(scale.zero)) * scale.step;
        assert_eq!(value(scale.zero), 0.0);
        for end in [low, high] {
            let nearest = (0..=255).map(|byte| (value(byte) - end).abs()).fold(f32::MAX, f32::min);
            assert!(nearest <= scale.step, "{low} {high}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn numbers_are_kept_to_the_nearest(
        channels in 1..40_usize,
        size in [1..9_usize, 1..20_usize],
        low in -1.5_f32..-1.0,
        high in 1.0_f32..1.5,
        seed: u64,
    ) {
        let values = noise(seed, channels * size[0] * size[1]);
        let truth: Vec<f64> = values.iter().map(|value| f64::from(*value)).collect();
        for storage in [Storage::Bf16, Storage::Byte(Scale::of(low, high))] {
            let packed = packed(&values, [channels, size[0], size[1]], 2, storage);
            let apart = apart(&unpacked(&packed), &truth);
            prop_assert!(apart <= rounding(storage, 1.0) * 1.001, "{storage:?}: {apart}");
        }
    }

    #[test]
    fn a_convolution_is_the_sum_of_what_is_kept(
        (channels_in, channels_out) in (1..50_usize, 1..70_usize),
        kernel in prop::sample::select(vec![1_usize, 3, 7]),
        stride in 1..3_usize,
        size in [1..10_usize, 1..31_usize],
        activation in activations(),
        has_residual: bool,
        storage in storages(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let shape = ConvShape { channels_in, channels_out, kernel, stride };
        let out = size.map(|side| shape.output(side));
        let input = noise(seed, channels_in * size[0] * size[1]);
        let input = packed(&input, [channels_in, size[0], size[1]], kernel / 2, storage);
        let weight = noise(seed ^ 1, channels_out * channels_in * kernel * kernel);
        let bias = noise(seed ^ 2, channels_out);
        let residual = noise(seed ^ 3, channels_out * out[0] * out[1]);
        let residual = packed(&residual, [channels_out, out[0], out[1]], 0, storage);
        let added = unpacked(&residual);
        let after = After { bias: &bias, residual: has_residual.then_some(&added), activation };
        let (from, by) = (unpacked(&input), kept(&weight, channels_out, storage));
        let truth = after.applied(convolved(shape, &from, size, &by));
        let most = truth.iter().fold(0.0_f64, |most, value| most.max(value.abs())) as f32;
        let to = match storage {
            Storage::Bf16 => Storage::Bf16,
            Storage::Byte(_) if activation == Activation::Identity => {
                Storage::Byte(Scale::of(-most, most))
            }
            Storage::Byte(_) => Storage::Byte(Scale::of(0.0, most)),
        };
        let magnitude = magnitude(shape, &from, size, &by);
        let exact = 1e-6 * magnitude + rounding(to, f64::from(most));
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let conv = PackedConv::new(shape, &weight, &bias, storage, level);
            let mut output = Packed::zeros([channels_out, out[0], out[1]], 1, to);
            let residual = has_residual.then_some(Held::Packed(&residual));
            conv.run(&thread_pool, &input, residual, activation, HeldMut::Packed(&mut output));
            let off = apart(&unpacked(&output), &truth);
            // A sum that lies between two values may be rounded either way.
            prop_assert!(off <= 1.01 * exact, "{level} {storage:?}: {off}, {exact}");
            let mut output = Image::zeros(channels_out, out[0], out[1], 0);
            conv.run(&thread_pool, &input, residual, activation, HeldMut::Whole(&mut output));
            let off = apart(&planes(&output), &truth);
            prop_assert!(off <= 1e-6 * magnitude, "{level} {storage:?}: {off}, {magnitude}");
            prop_assert!(output.is_zero_outside());
        }
    }

    #[test]
    fn a_channel_by_itself_is_the_sum_of_what_is_kept(
        channels in 1..50_usize,
        kernel in prop::sample::select(vec![3_usize, 5]),
        stride in 1..3_usize,
        size in [1..14_usize, 1..40_usize],
        activation in activations(),
        storage in storages(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let shape = DepthwiseShape { channels, kernel, stride };
        let input = noise(seed, channels * size[0] * size[1]);
        let input = packed(&input, [channels, size[0], size[1]], kernel / 2, storage);
        let weight = noise(seed ^ 1, channels * kernel * kernel);
        let bias = noise(seed ^ 2, channels);
        let (from, by) = (unpacked(&input), kept(&weight, channels, storage));
        let out = size.map(|side| side.div_ceil(stride));
        let thread_pool = ThreadPool::new(threads);
        // That one is held to sums in double precision.
        let whole = Depthwise::new(shape, &by, &bias, Level::Portable);
        let mut truth = Image::zeros(channels, out[0], out[1], 0);
        whole.run(&thread_pool, &image(&from, channels, size, kernel / 2), activation, &mut truth);
        let truth: Vec<f64> = planes(&truth).into_iter().map(f64::from).collect();
        for level in Level::available() {
            let conv = PackedDepthwise::new(shape, &weight, &bias, storage, level);
            let mut output = Image::zeros(channels, out[0], out[1], 1);
            conv.run(&thread_pool, &input, activation, HeldMut::Whole(&mut output));
            let off = apart(&planes(&output), &truth);
            prop_assert!(off <= 3e-5, "{level} {storage:?}: {off}");
            prop_assert!(output.is_zero_outside());
        }
    }

    #[test]
    fn images_of_another_size_are_kept_to_the_nearest(
        channels in 1..40_usize,
        size in [2..20_usize, 2..30_usize],
        (window, stride, padding) in prop::sample::select(vec![(3, 2, 1), (2, 2, 0), (3, 1, 1)]),
        storage in storages(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let pool = MaxPool { window, stride, padding };
        let values = noise(seed, channels * size[0] * size[1]);
        let packed = packed(&values, [channels, size[0], size[1]], 0, storage);
        let whole = image(&unpacked(&packed), channels, size, 0);
        let (pooled, doubled) = (size.map(|side| pool.output(side)), size.map(|side| 2 * side));
        let thread_pool = ThreadPool::new(threads);
        let blank = |size: [usize; 2]| Image::zeros(channels, size[0], size[1], 0);
        let wide = |image: &Image| planes(image).into_iter().map(f64::from).collect::<Vec<_>>();
        for level in Level::available() {
            let (mut maxima, mut between) = (blank(pooled), blank(doubled));
            pool.run(&thread_pool, level, &whole, &mut maxima);
            upsample(&thread_pool, level, &whole, &mut between);
            let small = |size: [usize; 2]| Packed::zeros([channels, size[0], size[1]], 1, storage);
            let mut output = small(pooled);
            max_pool_packed(&thread_pool, level, pool, &packed, &mut output);
            prop_assert!(apart(&unpacked(&output), &wide(&maxima)) <= 1e-6);
            let mut output = small(doubled);
            upsample_packed(&thread_pool, level, &packed, &mut output);
            let off = apart(&unpacked(&output), &wide(&between));
            prop_assert!(off <= 1.01 * rounding(storage, 1.0), "{level} {storage:?}: {off}");
        }
    }

    #[test]
    fn sums_are_of_what_is_kept(
        channels in 1..40_usize,
        size in [1..9_usize, 1..20_usize],
        activation in activations(),
        [one, other, to] in [storages(), storages(), storages()],
        threads in 1..4_usize,
        seed: u64,
    ) {
        let of = |seed: u64, storage: Storage| {
            let values = noise(seed, channels * size[0] * size[1]);
            packed(&values, [channels, size[0], size[1]], 1, storage)
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
            let [one, other] = [&one, &other].map(Held::Packed);
            let mut whole = Image::zeros(channels, size[0], size[1], 0);
            add_held(&thread_pool, level, one, Some(other), activation, HeldMut::Whole(&mut whole));
            prop_assert!(apart(&planes(&whole), &sums) <= 1e-6);
            // What is beyond the ends of a scale is kept as these.
            let mut small = Packed::zeros([channels, size[0], size[1]], 2, to);
            add_held(&thread_pool, level, one, Some(other), activation, HeldMut::Packed(&mut small));
            let ends = match to {
                Storage::Bf16 => [-2.0, 2.0],
                Storage::Byte(Scale { step, zero }) => {
                    [-f64::from(zero), 255.0 - f64::from(zero)].map(|end| end * f64::from(step))
                }
            };
            let kept: Vec<f64> = sums.iter().map(|sum| sum.clamp(ends[0], ends[1])).collect();
            let off = apart(&unpacked(&small), &kept);
            prop_assert!(off <= 1.01 * rounding(to, 2.0) + 1e-6, "{level} {to:?}: {off}");
        }
    }

    #[test]
    fn planes_are_read_as_they_would_be_packed(
        channels in 1..40_usize,
        size in [1..9_usize, 1..40_usize],
        [factor, offset] in [0.5_f32..2.0, -0.5_f32..0.5],
        storage in storages(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let shape = [channels, size[0], size[1]];
        let values = noise(seed, channels * size[0] * size[1]);
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let mut whole = Image::zeros(channels, size[0], size[1], 1);
            read_planes(&thread_pool, level, &values, [factor, offset], HeldMut::Whole(&mut whole));
            let want: Vec<f64> =
                values.iter().map(|v| f64::from(factor) * f64::from(*v) + f64::from(offset)).collect();
            prop_assert!(apart(&planes(&whole), &want) < 1e-6);
            prop_assert!(whole.is_zero_outside());
            let (mut packed, mut read) =
                (Packed::zeros(shape, 1, storage), Packed::zeros(shape, 1, storage));
            held(Held::Whole(&whole), HeldMut::Packed(&mut packed));
            read_planes(&thread_pool, level, &values, [factor, offset], HeldMut::Packed(&mut read));
            let apart = apart(&unpacked(&read), &unpacked(&packed).iter().map(|v| f64::from(*v)).collect::<Vec<_>>());
            // Values between two steps may be rounded either way.
            prop_assert!(apart <= 2.01 * rounding(storage, 2.0), "{level} {storage:?}: {apart}");
        }
    }
}

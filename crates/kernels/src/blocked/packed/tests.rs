//! Images of fewer bits against plain loops in double precision, on every level.

use proptest::prelude::*;

use super::*;
use crate::Level;
use crate::blocked::tests::{
    After, activations, apart, convolved, image, magnitude, noise, planes,
};
use crate::blocked::{Activation, ConvShape, Image, Team};
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
    packed.read(&image(planes, size[0], [size[1], size[2]], 0));
    packed
}

/// What an image stands for.
fn unpacked(packed: &Packed) -> Vec<f32> {
    let [channels, height, width] = packed.size();
    let mut image = Image::zeros(channels, height, width, 0);
    packed.write(&mut image);
    planes(&image)
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
        assert_eq!(value(scale.byte(0.0)), 0.0);
        for end in [low, high] {
            assert!((value(scale.byte(end)) - end).abs() <= scale.step, "{low} {high}");
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
        let exact = 1e-6 * magnitude(shape, &from, size, &by) + rounding(to, f64::from(most));
        let team = Team::new(threads);
        for level in Level::available() {
            let conv = PackedConv::new(shape, &weight, &bias, storage, level);
            let mut output = Packed::zeros([channels_out, out[0], out[1]], 1, to);
            conv.run(&team, &input, has_residual.then_some(&residual), activation, &mut output);
            let apart = apart(&unpacked(&output), &truth);
            // A sum that lies between two values may be rounded either way.
            prop_assert!(apart <= 1.01 * exact, "{level} {storage:?}: {apart}, {exact}");
        }
    }
}

//! Every operation against plain loops in double precision, over odd shapes, on every level.

#![allow(clippy::unwrap_used, reason = "tests")]

use proptest::prelude::*;

use super::*;
use crate::Level;
use crate::batch_norm::{Activation, Statistics};

/// Numbers between -1 and 1.
fn noise(seed: u64, count: usize) -> Vec<f32> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

fn double(values: &[f32]) -> Vec<f64> {
    values.iter().map(|value| f64::from(*value)).collect()
}

/// Calls `each` with the indices of output, input and weight of every product of a convolution.
fn products(conv: &Conv, mut each: impl FnMut(usize, usize, usize)) {
    let (from, to, k) = (conv.input, conv.output(), conv.kernel);
    for image in 0..from.batch {
        for (out, channel) in (0..to.channels).flat_map(|o| (0..from.channels).map(move |c| (o, c)))
        {
            for (y, x) in (0..to.height).flat_map(|y| (0..to.width).map(move |x| (y, x))) {
                for (ky, kx) in (0..k).flat_map(|ky| (0..k).map(move |kx| (ky, kx))) {
                    let at = |o: usize, tap: usize| (o * conv.stride + tap).checked_sub(k / 2);
                    let (Some(iy), Some(ix)) = (at(y, ky), at(x, kx)) else { continue };
                    if iy < from.height && ix < from.width {
                        each(
                            ((image * to.channels + out) * to.height + y) * to.width + x,
                            ((image * from.channels + channel) * from.height + iy) * from.width
                                + ix,
                            ((out * from.channels + channel) * k + ky) * k + kx,
                        );
                    }
                }
            }
        }
    }
}

/// Output, and gradients by input and weight, of planes.
fn truth(conv: &Conv, x: &[f64], w: &[f64], dy: &[f64]) -> [Vec<f64>; 3] {
    let mut all = [vec![0.0; dy.len()], vec![0.0; x.len()], vec![0.0; w.len()]];
    products(conv, |o, i, k| {
        all[0][o] += x[i] * w[k];
        all[1][i] += dy[o] * w[k];
        all[2][k] += dy[o] * x[i];
    });
    all
}

/// The largest difference, relative to the largest sum of products that do not cancel.
fn apart(ours: &[f32], truth: &[f64], magnitude: &[f64]) -> f64 {
    assert_eq!(ours.len(), truth.len());
    let pairs = ours.iter().zip(truth);
    let apart = pairs.map(|(ours, truth)| (f64::from(*ours) - truth).abs()).fold(0.0, f64::max);
    apart / magnitude.iter().fold(1e-3, |a, b| f64::max(a, *b))
}

fn activations() -> impl Strategy<Value = Activation> {
    prop_oneof![Just(Activation::Identity), Just(Activation::Relu), Just(Activation::Relu6)]
}

fn kept(value: f64, activation: Activation) -> f64 {
    match activation {
        Activation::Identity => value,
        Activation::Relu => value.max(0.0),
        Activation::Relu6 => value.clamp(0.0, 6.0),
    }
}

/// A normalisation by some statistics, with what it does to a number of a channel.
fn some_norm(channels: usize, seed: u64, activation: Activation) -> (Norm, [Vec<f32>; 4]) {
    let [mean, gamma, beta] = [1, 2, 3].map(|k| noise(seed ^ k, channels));
    let variance: Vec<f32> = noise(seed ^ 4, channels).iter().map(|v| 1.0 + 0.5 * v).collect();
    let statistics = Statistics { mean: mean.clone(), variance: variance.clone() };
    (Norm::new(&statistics, &gamma, &beta, 1e-5, activation), [mean, variance, gamma, beta])
}

fn normalised(x: f64, channel: usize, [mean, variance, gamma, beta]: &[Vec<f32>; 4]) -> f64 {
    let [m, v, g, b] = [mean, variance, gamma, beta].map(|of| f64::from(of[channel]));
    g * (x - m) / (v + f64::from(1e-5_f32)).sqrt() + b
}

/// Whether the lanes that fill the last block up are zero.
fn is_zero_beyond(shape: &Blocks, values: &[f32]) -> bool {
    shape.from_planes(&shape.to_planes(values)) == values
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn convolutions_and_their_gradients_are_the_sums_that_they_are(
        batch in 1..4_usize,
        channels in [1..40_usize, 1..50_usize],
        kernel in prop::sample::select(vec![1_usize, 3, 3, 5, 7]),
        stride in 1..3_usize,
        size in [1..12_usize, 1..20_usize],
        activation in prop::option::of(activations()),
        has_bias: bool,
        threads in 1..4_usize,
        seed: u64,
    ) {
        let input = Blocks { batch, channels: channels[0], height: size[0], width: size[1] };
        let conv = Conv { input, channels_out: channels[1], kernel, stride, level: Level::Portable };
        let out = conv.output();
        let pixels = size[0] * size[1];
        let x = noise(seed, batch * channels[0] * pixels);
        let w = noise(seed ^ 1, channels[0] * channels[1] * kernel * kernel);
        let dy = noise(seed ^ 2, batch * channels[1] * out.height * out.width);
        let bias = has_bias.then(|| noise(seed ^ 3, channels[1]));
        let norm = activation.map(|activation| some_norm(channels[0], seed ^ 8, activation));
        let mut taken = double(&x);
        let absolute = |of: &[f64]| of.iter().map(|v| v.abs()).collect::<Vec<_>>();
        // Normalised numbers are differences: what is rounded are their terms.
        let mut terms = absolute(&taken);
        if let (Some((_, numbers)), Some(activation)) = (&norm, activation) {
            for (k, (value, terms)) in taken.iter_mut().zip(&mut terms).enumerate() {
                let channel = k / pixels % channels[0];
                *value = kept(normalised(*value, channel, numbers), activation);
                let [mean, variance, gamma, beta] = numbers.each_ref().map(|of| of[channel]);
                let signless = [vec![-mean.abs()], vec![variance], vec![gamma.abs()], vec![beta.abs()]];
                *terms = normalised(*terms, 0, &signless);
            }
        }
        let (w64, dy64) = (double(&w), double(&dy));
        let mut sums = truth(&conv, &taken, &w64, &dy64);
        let sizes = truth(&conv, &terms, &absolute(&w64), &absolute(&dy64));
        for (k, value) in sums[0].iter_mut().enumerate() {
            let channel = k / (out.height * out.width) % channels[1];
            *value += bias.as_ref().map_or(0.0, |bias| f64::from(bias[channel]));
        }
        let (x, dy) = (input.from_planes(&x), out.from_planes(&dy));
        let from = Input { values: &x, norm: norm.as_ref().map(|(norm, _)| norm) };
        let is_winograd = kernel == 3 && stride == 1;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for level in Level::available() {
            let conv = Conv { level, ..conv };
            let direct = || {
                [
                    conv.forward(from, &w, bias.as_deref()),
                    conv.backward_input(&w, &dy),
                    conv.backward_weight(from, &dy),
                ]
            };
            // What these sizes would not be worth.
            let transformed = || {
                let [forth, back] = [false, true].map(|is_turned| conv.weights(&w, is_turned));
                [
                    winograd::convolved(input, from, forth, bias.as_deref(), level),
                    winograd::convolved(out, dy[..].into(), back, None, level),
                    winograd_weight::gradient(&conv, from, &dy),
                ]
            };
            // Transforms cancel more.
            let mut all = vec![(pool.install(direct), 5e-7)];
            all.extend(is_winograd.then(|| (pool.install(transformed), 5e-6)));
            for ([y, dx, dw], most) in all {
                prop_assert!(is_zero_beyond(&out, &y) && is_zero_beyond(&input, &dx));
                let planes = [out.to_planes(&y), input.to_planes(&dx), dw];
                for (k, what) in ["output", "by input", "by weight"].iter().enumerate() {
                    let apart = apart(&planes[k], &sums[k], &sizes[k]);
                    prop_assert!(apart < most, "{level} {what}: {apart:e}, allowed {most:e}");
                }
            }
        }
        let sums = conv.backward_bias(&dy);
        let of_channel = |channel: usize| -> f64 {
            let planes = dy64.chunks(out.height * out.width).skip(channel).step_by(channels[1]);
            planes.flatten().sum()
        };
        let want: Vec<f64> = (0..channels[1]).map(of_channel).collect();
        prop_assert!(apart(&sums, &want, &[1.0]) < 1e-5);
    }

    #[test]
    fn norms_and_their_gradients_are_those_of_their_definition(
        batch in 1..5_usize,
        channels in 1..40_usize,
        size in [1..12_usize, 2..40_usize],
        activation in activations(),
        seed: u64,
    ) {
        let shape = Blocks { batch, channels, height: size[0], width: size[1] };
        let pixels = size[0] * size[1];
        let x: Vec<f32> = noise(seed, batch * channels * pixels).iter().map(|v| 3.0 * v + 10.0).collect();
        let dy = noise(seed ^ 1, x.len());
        let (gamma, beta) = (noise(seed ^ 2, channels), noise(seed ^ 3, channels));
        let blocks = shape.from_planes(&x);
        let statistics = Norm::statistics(&shape, &blocks);
        let norm = Norm::new(&statistics, &gamma, &beta, 1e-5, activation);
        let plain = crate::batch_norm::BatchNorm { channels, pixels, epsilon: 1e-5, activation };
        let (y, expected) = plain.forward(&x, &gamma, &beta);
        for (ours, plain) in [
            (&statistics.mean, &expected.mean),
            (&statistics.variance, &expected.variance),
        ] {
            prop_assert!(apart(ours, &double(plain), &double(plain)) < 1e-6);
        }
        let input = Input { values: &blocks, norm: Some(&norm) };
        let written = input.written(&shape);
        prop_assert!(is_zero_beyond(&shape, &written));
        prop_assert!(apart(&shape.to_planes(&written), &double(&y), &[1.0]) < 1e-5);
        let gradients = plain.backward(&x, &gamma, &beta, &expected, &dy);
        let mut by_input = shape.from_planes(&dy);
        let ours = norm.backward(&shape, &blocks, &mut by_input);
        prop_assert!(is_zero_beyond(&shape, &by_input));
        let count = (batch * pixels) as f64;
        // A number whose value is at a bound but for rounding counts on one side or the other.
        let near = x.iter().enumerate().any(|(k, x)| {
            let channel = k / pixels % channels;
            let of = [&expected.mean, &expected.variance, &gamma, &beta].map(Clone::clone);
            let value = normalised(f64::from(*x), channel, &of);
            value.abs() < 1e-5 || (value - 6.0).abs() < 1e-5
        });
        prop_assume!(!near || activation == Activation::Identity);
        // Numbers that hardly differ are divided by as little, their rounding with them; gradients by them twice.
        let inverses = expected.variance.iter().map(|v| 1.0 / (f64::from(*v) + 1e-5).sqrt());
        let steep = inverses.fold(1.0, f64::max);
        for (ours, plain, scale) in [
            (shape.to_planes(&by_input), gradients.input, steep * steep),
            (ours.gamma, gradients.gamma, count * steep),
            (ours.beta, gradients.beta, count),
        ] {
            let apart = apart(&ours, &double(&plain), &[scale]);
            prop_assert!(apart < 2e-5, "{apart:e}");
        }
    }

    #[test]
    fn sums_pools_and_masks_are_those_of_planes(
        batch in 1..4_usize,
        channels in 1..40_usize,
        size in [1..12_usize, 1..20_usize],
        activation in activations(),
        seed: u64,
    ) {
        let shape = Blocks { batch, channels, height: size[0], width: size[1] };
        let a = noise(seed, batch * channels * size[0] * size[1]);
        let b = noise(seed ^ 1, a.len());
        let [one, other] = [&a, &b].map(|planes| shape.from_planes(planes));
        let sum = Input::from(&one[..]).add(&shape, Input::from(&other[..]), activation);
        let want: Vec<f64> =
            a.iter().zip(&b).map(|(a, b)| kept(f64::from(a + b), activation)).collect();
        prop_assert_eq!(apart(&shape.to_planes(&sum), &want, &[1.0]), 0.0);
        let masked = shape.to_planes(&through(activation, &sum, &other));
        for ((masked, sum), dy) in masked.iter().zip(shape.to_planes(&sum)).zip(&b) {
            let is_through = activation == Activation::Identity || (sum > 0.0 && sum < 6.0);
            prop_assert_eq!(*masked, if is_through { *dy } else { 0.0 });
        }
        let pool = MaxPool { input: shape };
        let out = pool.output();
        let (values, taps) = pool.forward(Input::from(&one[..]));
        let (planes, which) = crate::max_pool::forward(&a, size);
        prop_assert_eq!(out.to_planes(&values), planes);
        let dy = noise(seed ^ 2, which.len());
        let by_input = pool.backward(&out.from_planes(&dy), &taps);
        let want = crate::max_pool::backward(&dy, &which, size);
        prop_assert!(apart(&shape.to_planes(&by_input), &double(&want), &[1.0]) < 1e-6);
    }
}

#[test]
fn results_are_the_same_bits_on_any_number_of_threads() {
    for (channels, size, kernel, stride) in
        [([64, 64], [45, 60], 3, 1), ([40, 80], [12, 15], 3, 2), ([3, 64], [31, 40], 7, 2)]
    {
        let input = Blocks { batch: 5, channels: channels[0], height: size[0], width: size[1] };
        let conv = Conv { input, channels_out: channels[1], kernel, stride, level: Level::best() };
        let x = input.from_planes(&noise(1, 5 * channels[0] * size[0] * size[1]));
        let w = noise(2, channels[0] * channels[1] * kernel * kernel);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let statistics = Norm::statistics(&input, &x);
                let ones = vec![1.0; channels[0]];
                let norm = Norm::new(&statistics, &ones, &ones, 1e-5, Activation::Relu);
                let from = Input { values: &x, norm: Some(&norm) };
                let y = conv.forward(from, &w, None);
                let mut dx = conv.backward_input(&w, &y);
                let gradients = norm.backward(&input, &x, &mut dx);
                (conv.backward_weight(from, &y), y, dx, gradients)
            })
        };
        assert!(on(1) == on(2) && on(1) == on(3), "{channels:?}");
    }
}

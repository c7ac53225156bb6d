use proptest::prelude::*;

use super::super::{winograd, winograd_weight};
use super::*;
use crate::Level;

/// Output, and gradients by input and weight, in planes.
fn reference(conv: &Conv, x: &[f64], w: &[f64], dy: &[f64]) -> [Vec<f64>; 3] {
    let (input, output) = (conv.input, conv.output());
    let window = Window { input, output, kernel: conv.kernel, stride: conv.stride };
    let [plane_in, plane_out] = [input, output].map(|shape| shape.height * shape.width);
    let taps = conv.kernel.pow(2);
    let mut all = [vec![0.0; dy.len()], vec![0.0; x.len()], vec![0.0; w.len()]];
    for (image, out, channel) in (0..input.batch).flat_map(|image| {
        let pairs = move |out| (0..input.channels).map(move |channel| (image, out, channel));
        (0..output.channels).flat_map(pairs)
    }) {
        let to = (image * output.channels + out) * plane_out;
        let from = (image * input.channels + channel) * plane_in;
        let weight = (out * input.channels + channel) * taps;
        window.products(|o, i, k| {
            let (o, i, k) = (to + o, from + i, weight + k);
            all[0][o] += x[i] * w[k];
            all[1][i] += dy[o] * w[k];
            all[2][k] += dy[o] * x[i];
        });
    }
    all
}

/// Direct results of a convolution, and those of Winograd's algorithm, which sizes of tests would
/// not be worth, with the error that each may have.
fn results(
    conv: Conv,
    input: NormalizedInput<'_>,
    w: &[f32],
    dy: &[f32],
    bias: Option<&[f32]>,
) -> Vec<([Vec<f32>; 3], f64)> {
    let direct =
        [conv.forward(input, w, bias), conv.backward_input(w, dy), conv.backward_weight(input, dy)];
    let mut all = vec![(direct, 5e-7)];
    if conv.kernel == 3 && conv.stride == 1 {
        let [forth, back] = [false, true].map(|is_transposed| conv.weights(w, is_transposed));
        let transformed = [
            winograd::convolved(conv.input, input, forth, bias, conv.level),
            winograd::convolved(conv.output(), dy.into(), back, None, conv.level),
            winograd_weight::gradient(&conv, input, dy),
        ];
        // Transforms cancel more.
        all.push((transformed, 5e-6));
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn convolutions_and_their_gradients_match_their_sums(
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
        let conv =
            Conv { input, channels_out: channels[1], kernel, stride, level: Level::Portable };
        let out = conv.output();
        let x = noise(seed, batch * channels[0] * size[0] * size[1]);
        let w = noise(seed ^ 1, channels[0] * channels[1] * kernel * kernel);
        let dy = noise(seed ^ 2, batch * channels[1] * out.height * out.width);
        let bias = has_bias.then(|| noise(seed ^ 3, channels[1]));
        let norm = activation.map(|it| ReferenceNorm::random(channels[0], seed ^ 8, it));
        let [taken, terms] = ReferenceNorm::apply(norm.as_ref(), &x, &input);
        let (w64, dy64) = (double(&w), double(&dy));
        let mut sums = reference(&conv, &taken, &w64, &dy64);
        let mut sizes = reference(&conv, &terms, &absolute(&w64), &absolute(&dy64));
        for (k, (value, size)) in sums[0].iter_mut().zip(&mut sizes[0]).enumerate() {
            let channel = k / (out.height * out.width) % channels[1];
            let bias = bias.as_ref().map_or(0.0, |bias| f64::from(bias[channel]));
            *value += bias;
            *size += bias.abs();
        }
        let (x, dy) = (input.from_planes(&x), out.from_planes(&dy));
        let norm = norm.map(|norm| norm.norm());
        let from = NormalizedInput { values: &x, norm: norm.as_ref() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for level in Level::available() {
            let conv = Conv { level, ..conv };
            let all = pool.install(|| results(conv, from, &w, &dy, bias.as_deref()));
            for ([y, dx, dw], tolerance) in all {
                prop_assert!(is_zero_padded(&out, &y) && is_zero_padded(&input, &dx));
                let planes = [out.to_planes(&y), input.to_planes(&dx), dw];
                for (k, of) in ["output", "by input", "by weight"].iter().enumerate() {
                    let error = relative_error(&planes[k], &sums[k], &sizes[k]);
                    prop_assert!(error < tolerance, "{level} {of}: {error:e} of {tolerance:e}");
                }
            }
        }
        let channel_sum = |channel: usize| -> f64 {
            let planes = dy64.chunks(out.height * out.width).skip(channel).step_by(channels[1]);
            planes.flatten().sum()
        };
        let expected: Vec<f64> = (0..channels[1]).map(channel_sum).collect();
        prop_assert!(relative_error(&backward_bias(&out, &dy), &expected, &[1.0]) < 1e-5);
    }
}

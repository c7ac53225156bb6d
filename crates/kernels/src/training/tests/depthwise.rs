use proptest::prelude::*;

use super::*;
use crate::Level;

/// Output, and gradients by input and weight, in planes.
fn reference(conv: &Depthwise, x: &[f64], w: &[f64], dy: &[f64]) -> [Vec<f64>; 3] {
    let (input, output) = (conv.input, conv.output());
    let window = Window { input, output, kernel: conv.kernel, stride: conv.stride };
    let [plane_in, plane_out] = [input, output].map(|shape| shape.height * shape.width);
    let taps = conv.kernel.pow(2);
    let mut all = [vec![0.0; dy.len()], vec![0.0; x.len()], vec![0.0; w.len()]];
    for plane in 0..input.batch * input.channels {
        let weight = plane % input.channels * taps;
        window.products(|o, i, k| {
            let (o, i, k) = (plane * plane_out + o, plane * plane_in + i, weight + k);
            all[0][o] += x[i] * w[k];
            all[1][i] += dy[o] * w[k];
            all[2][k] += dy[o] * x[i];
        });
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn depthwise_convolutions_and_their_gradients_match_their_sums(
        batch in 1..4_usize,
        channels in 1..40_usize,
        kernel in prop::sample::select(vec![1_usize, 3, 3, 5, 5, 7]),
        stride in 1..3_usize,
        size in [1..14_usize, 1..30_usize],
        activation in prop::option::of(activations()),
        has_bias: bool,
        seed: u64,
    ) {
        let input = Blocks { batch, channels, height: size[0], width: size[1] };
        let conv = Depthwise { input, kernel, stride, level: Level::Portable };
        let out = conv.output();
        let x = noise(seed, batch * channels * size[0] * size[1]);
        let w = noise(seed ^ 1, channels * kernel * kernel);
        let dy = noise(seed ^ 2, batch * channels * out.height * out.width);
        let bias = has_bias.then(|| noise(seed ^ 3, channels));
        let norm = activation.map(|it| ReferenceNorm::random(channels, seed ^ 8, it));
        let [taken, terms] = ReferenceNorm::apply(norm.as_ref(), &x, &input);
        let (w64, dy64) = (double(&w), double(&dy));
        let mut sums = reference(&conv, &taken, &w64, &dy64);
        let mut sizes = reference(&conv, &terms, &absolute(&w64), &absolute(&dy64));
        for (k, (value, size)) in sums[0].iter_mut().zip(&mut sizes[0]).enumerate() {
            let channel = k / (out.height * out.width) % channels;
            let bias = bias.as_ref().map_or(0.0, |bias| f64::from(bias[channel]));
            *value += bias;
            *size += bias.abs();
        }
        let (x, dy) = (input.from_planes(&x), out.from_planes(&dy));
        let norm = norm.map(|norm| norm.norm());
        let from = NormalizedInput { values: &x, norm: norm.as_ref() };
        for level in Level::available() {
            let conv = Depthwise { level, ..conv };
            let y = conv.forward(from, &w, bias.as_deref());
            let dx = conv.backward_input(&w, &dy);
            prop_assert!(is_zero_padded(&out, &y) && is_zero_padded(&input, &dx));
            let planes =
                [out.to_planes(&y), input.to_planes(&dx), conv.backward_weight(from, &dy)];
            for (k, of) in ["output", "by input", "by weight"].iter().enumerate() {
                let error = relative_error(&planes[k], &sums[k], &sizes[k]);
                prop_assert!(error < 5e-7, "{level} {of}: {error:e}");
            }
        }
    }
}

use proptest::prelude::*;

use super::*;

/// Mean and variance of every channel of planes.
fn statistics(x: &[f64], shape: &Blocks) -> [Vec<f64>; 2] {
    let pixels = shape.height * shape.width;
    let count = (shape.batch * pixels) as f64;
    let channel_mean = |channel: usize, term: &dyn Fn(f64) -> f64| -> f64 {
        let planes = x.chunks(pixels).skip(channel).step_by(shape.channels);
        planes.flatten().map(|x| term(*x)).sum::<f64>() / count
    };
    let mean: Vec<_> = (0..shape.channels).map(|c| channel_mean(c, &|x| x)).collect();
    let variance = |c: usize| channel_mean(c, &|x| (x - mean[c]).powi(2));
    let variance = (0..shape.channels).map(variance).collect();
    [mean, variance]
}

/// Gradients by input, gamma and beta, of planes.
fn gradients(reference: &ReferenceNorm, x: &[f64], dy: &[f64], shape: &Blocks) -> [Vec<f64>; 3] {
    let pixels = shape.height * shape.width;
    let count = (shape.batch * pixels) as f64;
    let channel = |k: usize| k / pixels % shape.channels;
    let n = |k: usize| {
        let [mean, inverse, ..] = reference.channel(channel(k));
        (x[k] - mean) * inverse
    };
    let masked = |k: usize| {
        let value = reference.value(x[k], channel(k));
        if activated(value, reference.activation) == value { dy[k] } else { 0.0 }
    };
    let [mut gamma, mut beta] = [(); 2].map(|()| vec![0.0; shape.channels]);
    for k in 0..x.len() {
        gamma[channel(k)] += masked(k) * n(k);
        beta[channel(k)] += masked(k);
    }
    let by_input = |k: usize| {
        let c = channel(k);
        let [_, inverse, factor, _] = reference.channel(c);
        factor * inverse * (masked(k) - beta[c] / count - n(k) * gamma[c] / count)
    };
    [(0..x.len()).map(by_input).collect(), gamma, beta]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn norms_and_their_gradients_match_their_definition(
        batch in 1..5_usize,
        channels in 1..40_usize,
        size in [1..12_usize, 2..40_usize],
        activation in activations(),
        seed: u64,
    ) {
        let shape = Blocks { batch, channels, height: size[0], width: size[1] };
        let pixels = size[0] * size[1];
        let x: Vec<f32> =
            noise(seed, batch * channels * pixels).iter().map(|v| 3.0 * v + 10.0).collect();
        let dy = noise(seed ^ 1, x.len());
        let blocks = shape.from_planes(&x);
        let Statistics { mean, variance } = Norm::statistics(&shape, &blocks);
        let expected = statistics(&double(&x), &shape);
        for (ours, expected) in [&mean, &variance].into_iter().zip(&expected) {
            prop_assert!(relative_error(ours, expected, expected) < 1e-6);
        }
        let (gamma, beta) = (noise(seed ^ 2, channels), noise(seed ^ 3, channels));
        let reference = ReferenceNorm { mean, variance, gamma, beta, activation };
        let norm = reference.norm();
        let input = NormalizedInput { values: &blocks, norm: Some(&norm) };
        let output = input.materialized(&shape);
        prop_assert!(is_zero_padded(&shape, &output));
        let [expected, _] = ReferenceNorm::apply(Some(&reference), &x, &shape);
        // Values that hardly differ are divided by as little, their rounding with them; gradients
        // by them twice.
        let inverses = (0..channels).map(|channel| reference.channel(channel)[1]);
        let steep = inverses.fold(1.0, f64::max);
        prop_assert!(relative_error(&shape.to_planes(&output), &expected, &[steep]) < 1e-5);
        // A value that is clamped but for rounding counts on one side or the other.
        let is_near_bound = x.iter().enumerate().any(|(k, x)| {
            let value = reference.value(f64::from(*x), k / pixels % channels);
            value.abs() < 1e-5 * steep || (value - 6.0).abs() < 1e-5 * steep
        });
        prop_assume!(!is_near_bound || activation == Activation::Identity);
        let expected = gradients(&reference, &double(&x), &double(&dy), &shape);
        let mut by_input = shape.from_planes(&dy);
        let ours = norm.backward(&shape, &blocks, &mut by_input);
        prop_assert!(is_zero_padded(&shape, &by_input));
        let count = (batch * pixels) as f64;
        let ours = [shape.to_planes(&by_input), ours.gamma, ours.beta];
        let scales = [steep * steep, count * steep, count];
        for ((ours, expected), scale) in ours.iter().zip(&expected).zip(scales) {
            let error = relative_error(ours, expected, &[scale]);
            prop_assert!(error < 2e-5, "{error:e}");
        }
    }
}

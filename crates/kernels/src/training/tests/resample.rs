use proptest::prelude::*;

use super::*;

/// The largest values of windows of planes, and the gradient by the planes. Of equals the first
/// wins.
fn max_pooled(pool: &MaxPool, x: &[f32], dy: &[f32]) -> [Vec<f64>; 2] {
    let (shape, out) = (pool.input, pool.output());
    let mut all = [vec![0.0; dy.len()], vec![0.0; x.len()]];
    for k in 0..dy.len() {
        let plane = k / (out.height * out.width) * shape.height * shape.width;
        let place = [k / out.width % out.height, k % out.width];
        let side = |at: usize, side: usize| {
            let first = (2 * at).saturating_sub(pool.padding);
            first..(2 * at + pool.kernel - pool.padding).min(side)
        };
        let pixels = side(place[0], shape.height)
            .flat_map(|y| side(place[1], shape.width).map(move |x| plane + y * shape.width + x));
        // `max_by` would take the last of equals.
        let best = pixels.reduce(|best, at| if x[at] > x[best] { at } else { best }).unwrap();
        all[0][k] = f64::from(x[best]);
        all[1][best] += f64::from(dy[k]);
    }
    all
}

/// A bilinear upsampling of planes, and the gradient by the planes.
fn upsampled(shape: &Blocks, x: &[f64], dy: &[f64]) -> [Vec<f64>; 2] {
    let (height, width) = (shape.height, shape.width);
    let mut all = [vec![0.0; dy.len()], vec![0.0; x.len()]];
    // Pixels on both sides of an output's centre, and the weight of the second.
    let sides = |output: usize, side: usize| {
        let centre = ((output as f64 + 0.5) / 2.0 - 0.5).max(0.0);
        let first = centre as usize;
        [(first, 1.0 - centre.fract()), ((first + 1).min(side - 1), centre.fract())]
    };
    for k in 0..dy.len() {
        let (plane, y, column) =
            (k / (4 * height * width), k / (2 * width) % (2 * height), k % (2 * width));
        for (iy, wy) in sides(y, height) {
            for (ix, wx) in sides(column, width) {
                let at = (plane * height + iy) * width + ix;
                all[0][k] += wy * wx * x[at];
                all[1][at] += wy * wx * dy[k];
            }
        }
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn sums_and_masks_match_those_of_planes(
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
        let sum = NormalizedInput::from(&one[..]).add(&shape, NormalizedInput::from(&other[..]), activation);
        let expected: Vec<f64> =
            a.iter().zip(&b).map(|(a, b)| activated(f64::from(a + b), activation)).collect();
        prop_assert_eq!(relative_error(&shape.to_planes(&sum), &expected, &[1.0]), 0.0);
        let masked = shape.to_planes(&activation_backward(activation, &sum, &other));
        for ((masked, sum), dy) in masked.iter().zip(shape.to_planes(&sum)).zip(&b) {
            let passes = activation == Activation::Identity || (sum > 0.0 && sum < 6.0);
            prop_assert_eq!(*masked, if passes { *dy } else { 0.0 });
        }
    }

    #[test]
    fn pools_take_the_largest_and_give_it_the_gradient(
        batch in 1..4_usize,
        channels in 1..40_usize,
        size in [2..12_usize, 2..20_usize],
        (kernel, padding) in prop::sample::select(vec![(3, 1), (2, 0), (3, 0)]),
        seed: u64,
    ) {
        let shape = Blocks { batch, channels, height: size[0], width: size[1] };
        let pool = MaxPool { input: shape, kernel, padding };
        let out = pool.output();
        let x = noise(seed, batch * channels * size[0] * size[1]);
        let dy = noise(seed ^ 2, batch * channels * out.height * out.width);
        let [expected, by_input] = max_pooled(&pool, &x, &dy);
        let blocks = shape.from_planes(&x);
        let (values, taps) = pool.forward(NormalizedInput::from(&blocks[..]));
        prop_assert_eq!(double(&out.to_planes(&values)), expected);
        let ours = shape.to_planes(&pool.backward(&out.from_planes(&dy), &taps));
        prop_assert!(relative_error(&ours, &by_input, &[1.0]) < 1e-6);
    }

    #[test]
    fn upsampling_mixes_the_nearest_pixels(
        batch in 1..4_usize,
        channels in 1..40_usize,
        size in [1..12_usize, 1..20_usize],
        activation in prop::option::of(activations()),
        seed: u64,
    ) {
        let shape = Blocks { batch, channels, height: size[0], width: size[1] };
        let upsample = Upsample { input: shape };
        let out = upsample.output();
        let x = noise(seed, batch * channels * size[0] * size[1]);
        let dy = noise(seed ^ 2, 4 * x.len());
        let norm = activation.map(|it| ReferenceNorm::random(channels, seed ^ 8, it));
        let [taken, _] = ReferenceNorm::apply(norm.as_ref(), &x, &shape);
        let [expected, by_input] = upsampled(&shape, &taken, &double(&dy));
        let blocks = shape.from_planes(&x);
        let norm = norm.map(|norm| norm.norm());
        let y = upsample.forward(NormalizedInput { values: &blocks, norm: norm.as_ref() });
        let dx = upsample.backward(&out.from_planes(&dy));
        prop_assert!(is_zero_padded(&out, &y) && is_zero_padded(&shape, &dx));
        prop_assert!(relative_error(&out.to_planes(&y), &expected, &[1.0]) < 2e-6);
        prop_assert!(relative_error(&shape.to_planes(&dx), &by_input, &[1.0]) < 2e-6);
    }
}

#[test]
fn pooling_prefers_the_first_of_equals_and_propagates_nan() {
    let pooled = |values: &[f32], side: usize| {
        let input = Blocks { batch: 1, channels: 1, height: side, width: side };
        let pool = MaxPool { input, kernel: 3, padding: 1 };
        let (values, taps) = pool.forward(input.from_planes(values)[..].into());
        let taps: Vec<u8> = taps.chunks(16).map(|taps| taps[0]).collect();
        (pool.output().to_planes(&values), taps)
    };
    assert_eq!(pooled(&[1.0; 9], 3), (vec![1.0; 4], vec![4, 3, 1, 0]));
    assert!(pooled(&[1.0, f32::NAN, 2.0, 3.0], 2).0[0].is_nan());
}

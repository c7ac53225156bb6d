//! Bilinear upsampling and unary operators.

use super::*;

/// Bilinear interpolation of `plane` at `[y, x]`, in pixels from the centre of the first.
fn bilinear(plane: &[f32], [height, width]: [usize; 2], [y, x]: [f64; 2]) -> f64 {
    let (y, x) = (y.clamp(0.0, (height - 1) as f64), x.clamp(0.0, (width - 1) as f64));
    let corners = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[down, across]| {
        let (row, column) = (y.floor() + f64::from(down), x.floor() + f64::from(across));
        let weight = (1.0 - (y - row).abs()) * (1.0 - (x - column).abs());
        let at = (row as usize).min(height - 1) * width + (column as usize).min(width - 1);
        weight * f64::from(plane[at])
    });
    corners.iter().sum()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn upsampling_is_bilinear_interpolation(
        channels in 1..40_usize,
        size in [1..9_usize, 1..20_usize],
        border in 0..3_usize,
        threads in 1..4_usize,
        seed: u64,
    ) {
        let input = random_values(seed, channels * size[0] * size[1]);
        let out = size.map(|side| 2 * side);
        let mut expected = Vec::new();
        for plane in input.chunks(size[0] * size[1]) {
            for (y, x) in (0..out[0]).flat_map(|y| (0..out[1]).map(move |x| (y, x))) {
                let at = [y, x].map(|pixel| (pixel as f64 + 0.5) / 2.0 - 0.5);
                expected.push(bilinear(plane, size, at));
            }
        }
        let input = image(&input, channels, size, border);
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let mut output = Image::zeros(channels, out[0], out[1], border);
            upsample(&thread_pool, level, &input, &mut output);
            let apart = max_abs_difference(&planes(&output), &expected);
            prop_assert!(apart < 3e-7, "{level}: {apart}");
            prop_assert!(output.is_zero_outside(), "{level}: the border is not zero");
        }
    }

    #[test]
    fn unary_operators_match_plain_loops(
        channels in 1..40_usize,
        size in [1..9_usize, 1..20_usize],
        [factor, offset] in [-3.0..3.0_f32, -3.0..3.0_f32],
        spread in prop::sample::select(vec![1.0_f32, 10.0, 120.0]),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let input = random_values(seed, channels * size[0] * size[1]);
        let input: Vec<f32> = input.into_iter().map(|value| spread * value).collect();
        let scaled: Vec<f64> = input
            .iter()
            .map(|value| f64::from(*value) * f64::from(factor) + f64::from(offset))
            .collect();
        let sigmoids: Vec<f64> =
            input.iter().map(|value| 1.0 / (1.0 + (-f64::from(*value)).exp())).collect();
        let image = image(&input, channels, size, 1);
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let mut output = Image::zeros(channels, size[0], size[1], 2);
            affine(&thread_pool, level, &image, [factor, offset], &mut output);
            prop_assert!(max_abs_difference(&planes(&output), &scaled) < 3e-7 * f64::from(spread * 3.0 + 3.0));
            prop_assert!(output.is_zero_outside(), "{level}");
            let mut output = Image::zeros(channels, size[0], size[1], 0);
            sigmoid(&thread_pool, level, &image, &mut output);
            for (ours, expected) in planes(&output).iter().zip(&sigmoids) {
                let relative = (f64::from(*ours) / expected.max(1e-37) - 1.0).abs();
                let is_tiny = *expected < 1e-37 && *ours < 2e-37;
                prop_assert!(relative < 5e-7 || is_tiny, "{level}: {ours} {expected}");
            }
            prop_assert!(output.is_zero_outside(), "{level}");
        }
    }
}

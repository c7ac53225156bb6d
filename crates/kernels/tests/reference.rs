//! Every kernel against its definition.

#![allow(clippy::unwrap_used, reason = "tests")]

use evpose_kernels::batch_norm::{Activation, BatchNorm};
use evpose_kernels::conv2d::Conv2d;
use evpose_kernels::depthwise::Depthwise;
use evpose_kernels::max_pool;
use proptest::prelude::*;

/// Numbers in [-1, 1) without a pattern.
fn noise(length: usize, seed: u64) -> Vec<f32> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    };
    std::iter::repeat_with(next).take(length).collect()
}

fn assert_close(ours: &[f32], reference: &[f64]) {
    assert_eq!(ours.len(), reference.len());
    let size = reference.iter().fold(1.0_f64, |size, value| size.max(value.abs()));
    for (index, (ours, reference)) in ours.iter().zip(reference).enumerate() {
        let error = (f64::from(*ours) - reference).abs();
        assert!(error < 1e-5 * size, "{index}: {ours} instead of {reference}");
    }
}

/// Calls `term(output, input, weight)` for every product of a convolution.
fn products(c: &Conv2d, mut term: impl FnMut(usize, usize, usize)) {
    let [rows, columns] = c.output();
    let [kernel_y, kernel_x] = c.kernel;
    for n in 0..c.batch {
        for o in 0..c.channels_out {
            for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                for i in 0..c.channels_in {
                    for (ky, kx) in (0..kernel_y).flat_map(|y| (0..kernel_x).map(move |x| (y, x))) {
                        let line = (y * c.stride + ky).wrapping_sub(c.padding);
                        let column = (x * c.stride + kx).wrapping_sub(c.padding);
                        if line < c.height && column < c.width {
                            term(
                                ((n * c.channels_out + o) * rows + y) * columns + x,
                                ((n * c.channels_in + i) * c.height + line) * c.width + column,
                                ((o * c.channels_in + i) * kernel_y + ky) * kernel_x + kx,
                            );
                        }
                    }
                }
            }
        }
    }
}

fn check_convolution(c: Conv2d) {
    let [rows, columns] = c.output();
    let x = noise(c.batch * c.channels_in * c.height * c.width, 1);
    let w = noise(c.channels_out * c.channels_in * c.kernel[0] * c.kernel[1], 2);
    let b = noise(c.channels_out, 3);
    let dy = noise(c.batch * c.channels_out * rows * columns, 4);
    let channel = |at: usize| at / (rows * columns) % c.channels_out;
    let mut y: Vec<f64> = (0..dy.len()).map(|at| f64::from(b[channel(at)])).collect();
    let (mut dx, mut dw) = (vec![0.0; x.len()], vec![0.0; w.len()]);
    let mut db = vec![0.0; b.len()];
    products(&c, |to, from, weight| {
        y[to] += f64::from(x[from]) * f64::from(w[weight]);
        dx[from] += f64::from(dy[to]) * f64::from(w[weight]);
        dw[weight] += f64::from(dy[to]) * f64::from(x[from]);
    });
    dy.iter().enumerate().for_each(|(at, dy)| db[channel(at)] += f64::from(*dy));
    assert_close(&c.forward(&x, &w, Some(&b)), &y);
    assert_close(&c.backward_input(&w, &dy), &dx);
    assert_close(&c.backward_weight(&x, &dy), &dw);
    assert_close(&c.backward_bias(&dy), &db);
}

/// Every channel is the convolution of a single one.
fn check_depthwise(d: Depthwise) {
    let Depthwise { batch, channels, height, width, kernel, stride, padding } = d;
    let single = Conv2d {
        batch: 1,
        channels_in: 1,
        height,
        width,
        channels_out: 1,
        kernel: [kernel; 2],
        stride,
        padding,
    };
    let [rows, columns] = d.output();
    let (plane_in, plane_out, taps) = (height * width, rows * columns, kernel * kernel);
    let x = noise(batch * channels * plane_in, 1);
    let w = noise(channels * taps, 2);
    let b = noise(channels, 3);
    let dy = noise(batch * channels * plane_out, 4);
    let (mut y, mut dx) = (vec![0.0; dy.len()], vec![0.0; x.len()]);
    let (mut dw, mut db) = (vec![0.0; w.len()], vec![0.0; b.len()]);
    for plane in 0..batch * channels {
        let channel = plane % channels;
        let (of_in, of_out) = (plane * plane_in, plane * plane_out);
        y[of_out..][..plane_out].fill(f64::from(b[channel]));
        products(&single, |to, from, weight| {
            let (to, from, weight) = (of_out + to, of_in + from, channel * taps + weight);
            y[to] += f64::from(x[from]) * f64::from(w[weight]);
            dx[from] += f64::from(dy[to]) * f64::from(w[weight]);
            dw[weight] += f64::from(dy[to]) * f64::from(x[from]);
        });
        db[channel] += dy[of_out..][..plane_out].iter().map(|dy| f64::from(*dy)).sum::<f64>();
    }
    assert_close(&d.forward(&x, &w, Some(&b)), &y);
    assert_close(&d.backward_input(&w, &dy), &dx);
    assert_close(&d.backward_weight(&x, &dy), &dw);
    assert_close(&d.backward_bias(&dy), &db);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_depthwise_convolution_and_its_gradients_are_their_sums(
        (batch, channels) in (1usize..20, 1usize..5),
        (height, width) in (1usize..22, 1usize..22),
        (kernel, stride, padding) in (1usize..8, 1usize..4, 0usize..4),
    ) {
        prop_assume!(height + 2 * padding >= kernel && width + 2 * padding >= kernel);
        check_depthwise(Depthwise { batch, channels, height, width, kernel, stride, padding });
    }

    #[test]
    fn a_convolution_and_its_gradients_are_their_sums(
        (batch, channels_in, channels_out) in (1usize..6, 1usize..5, 1usize..7),
        (height, width) in (1usize..22, 1usize..22),
        (kernel_y, kernel_x) in (1usize..8, 1usize..8),
        (stride, padding) in (1usize..4, 0usize..4),
    ) {
        prop_assume!(height + 2 * padding >= kernel_y && width + 2 * padding >= kernel_x);
        let kernel = [kernel_y, kernel_x];
        check_convolution(Conv2d {
            batch, channels_in, height, width, channels_out, kernel, stride, padding,
        });
    }

    /// Many images go another way than few.
    #[test]
    fn a_convolution_of_a_batch_and_its_gradients_are_their_sums(
        (batch, channels_in, channels_out) in (8usize..36, 1usize..7, 1usize..10),
        (height, width) in (1usize..9, 1usize..9),
        (kernel_y, kernel_x) in (1usize..5, 1usize..5),
        (stride, padding) in (1usize..4, 0usize..4),
    ) {
        prop_assume!(height + 2 * padding >= kernel_y && width + 2 * padding >= kernel_x);
        let kernel = [kernel_y, kernel_x];
        check_convolution(Conv2d {
            batch, channels_in, height, width, channels_out, kernel, stride, padding,
        });
    }

    #[test]
    fn a_batch_norm_and_its_gradients_follow_the_formula(
        (batch, channels, pixels) in (1usize..6, 1usize..5, 2usize..60),
        activation in prop::sample::select(vec![
            Activation::Identity, Activation::Relu, Activation::Relu6,
        ]),
    ) {
        let norm = BatchNorm { channels, pixels, epsilon: 1e-5, activation };
        let x: Vec<f32> = noise(batch * channels * pixels, 5).iter().map(|x| x * 3.0 + 1.0).collect();
        // So that some values pass 6.
        let gamma: Vec<f32> = noise(channels, 6).iter().map(|gamma| 5.0 * gamma).collect();
        let (beta, dy) = (noise(channels, 7), noise(x.len(), 8));
        let count = (batch * pixels) as f64;
        let of = |at: usize| at / pixels % channels;
        let mean_of = |values: &dyn Fn(usize) -> f64| {
            let mut sums = vec![0.0; channels];
            (0..x.len()).for_each(|at| sums[of(at)] += values(at));
            sums.iter().map(|sum| sum / count).collect::<Vec<f64>>()
        };
        let mean = mean_of(&|at| f64::from(x[at]));
        let variance = mean_of(&|at| (f64::from(x[at]) - mean[of(at)]).powi(2));
        let inverse: Vec<f64> = variance.iter().map(|v| 1.0 / (v + 1e-5).sqrt()).collect();
        let n = |at: usize| (f64::from(x[at]) - mean[of(at)]) * inverse[of(at)];
        let plain = |at: usize| f64::from(gamma[of(at)]) * n(at) + f64::from(beta[of(at)]);
        let (least, most) = match activation {
            Activation::Identity => (f64::MIN, f64::MAX),
            Activation::Relu => (0.0, f64::MAX),
            Activation::Relu6 => (0.0, 6.0),
        };
        let y: Vec<f64> = (0..x.len()).map(|at| plain(at).clamp(least, most)).collect();
        let masked = |at: usize| if y[at] == plain(at) { f64::from(dy[at]) } else { 0.0 };
        let mean_dy = mean_of(&masked);
        let mean_dyn = mean_of(&|at| masked(at) * n(at));
        let dx: Vec<f64> = (0..x.len())
            .map(|at| {
                let c = of(at);
                f64::from(gamma[c]) * inverse[c] * (masked(at) - mean_dy[c] - n(at) * mean_dyn[c])
            })
            .collect();
        let sums = |means: &[f64]| means.iter().map(|mean| mean * count).collect::<Vec<f64>>();

        let (output, statistics) = norm.forward(&x, &gamma, &beta);
        assert_close(&output, &y);
        assert_close(&statistics.mean, &mean);
        assert_close(&statistics.variance, &variance);
        let gradients = norm.backward(&x, &gamma, &beta, &statistics, &dy);
        assert_close(&gradients.input, &dx);
        assert_close(&gradients.gamma, &sums(&mean_dyn));
        assert_close(&gradients.beta, &sums(&mean_dy));
    }

    #[test]
    fn pooling_takes_the_largest_and_gives_it_the_gradient(
        (planes, height, width) in (1usize..20, 1usize..12, 1usize..12),
    ) {
        let x = noise(planes * height * width, 9);
        let [rows, columns] = max_pool::output([height, width]);
        let dy = noise(planes * rows * columns, 10);
        let (mut y, mut dx) = (vec![0.0; dy.len()], vec![0.0; x.len()]);
        for at in 0..dy.len() {
            let (plane, row, column) = (at / (rows * columns), at / columns % rows, at % columns);
            let lines = (2 * row).saturating_sub(1)..(2 * row + 2).min(height);
            let best = lines
                .flat_map(|line| {
                    let across = (2 * column).saturating_sub(1)..(2 * column + 2).min(width);
                    across.map(move |across| (plane * height + line) * width + across)
                })
                .max_by(|&a, &b| x[a].total_cmp(&x[b]))
                .unwrap();
            y[at] = f64::from(x[best]);
            dx[best] += f64::from(dy[at]);
        }
        let (output, taps) = max_pool::forward(&x, [height, width]);
        assert_close(&output, &y);
        assert_close(&max_pool::backward(&dy, &taps, [height, width]), &dx);
    }
}

#[test]
fn layers_of_a_residual_network_are_their_sums() {
    let layer = |channels_in, channels_out, size: [usize; 2], kernel, stride| Conv2d {
        batch: 37,
        channels_in,
        height: size[0],
        width: size[1],
        channels_out,
        kernel: [kernel; 2],
        stride,
        padding: kernel / 2,
    };
    check_convolution(layer(3, 8, [45, 60], 7, 2));
    check_convolution(layer(8, 8, [12, 15], 3, 1));
    check_convolution(layer(8, 16, [12, 15], 3, 2));
    check_convolution(layer(8, 16, [12, 15], 1, 2));
    check_convolution(layer(16, 8, [2, 2], 3, 1));
    check_convolution(layer(16, 24, [20, 20], 1, 1));
}

#[test]
fn pooling_prefers_the_first_of_equals_and_lets_nan_through() {
    let (values, taps) = max_pool::forward(&[1.0; 9], [3, 3]);
    assert_eq!((values, taps), (vec![1.0; 4], vec![4, 3, 1, 0]));
    let (values, _) = max_pool::forward(&[1.0, f32::NAN, 2.0, 3.0], [2, 2]);
    assert!(values[0].is_nan());
}

#[test]
fn results_are_equal_to_the_bit_on_one_and_on_more_threads() {
    let conv = Conv2d {
        batch: 64,
        channels_in: 5,
        height: 13,
        width: 11,
        channels_out: 7,
        kernel: [3, 3],
        stride: 1,
        padding: 1,
    };
    let norm =
        BatchNorm { channels: 7, pixels: 13 * 11, epsilon: 1e-5, activation: Activation::Relu };
    let x = noise(64 * 5 * 13 * 11, 11);
    let w = noise(7 * 5 * 9, 12);
    let everything = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let y = conv.forward(&x, &w, None);
            let (z, statistics) = norm.forward(&y, &w[..7], &w[7..14]);
            let gradients = norm.backward(&y, &w[..7], &w[7..14], &statistics, &z);
            let dx = conv.backward_input(&w, &gradients.input);
            let dw = conv.backward_weight(&x, &gradients.input);
            let (pooled, taps) = max_pool::forward(&z, [13, 11]);
            let unpooled = max_pool::backward(&pooled, &taps, [13, 11]);
            (y, z, statistics, gradients, dx, dw, pooled, unpooled)
        })
    };
    let one = everything(1);
    assert!(one == everything(2) && one == everything(3));
}

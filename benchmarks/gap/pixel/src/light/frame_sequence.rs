//! Light behind a Gaussian point spread function.
//!
//! The linear luminance is read at the pixel centres (and a margin) 1024 times a second, blurred
//! with Lindeberg's discrete Gaussian `e^(-s) I_n(s)` (1990; its variance is exactly `s` however
//! small, where a sampled Gaussian fails), and interpolated in time by cubics. No edge passes in
//! less than 10 ms, so the cubic is right to about 1e-4 in `ln I`.

use rayon::prelude::*;

use super::log_scene;
use crate::event::{DURATION_S, HEIGHT, WIDTH};
use crate::scene::Scene;

const RATE_HZ: f64 = 1024.0;

/// The blurred light of one recording, `ln I` frame by frame.
#[derive(Debug)]
pub(super) struct FrameSequence {
    frames: Vec<Vec<f32>>,
}

impl FrameSequence {
    pub(super) fn new(scene: &Scene, k1: f64, sigma_px: f64) -> Self {
        let kernel = kernel(sigma_px);
        // One frame before the start and two after the end, for the cubics.
        let count = (DURATION_S * RATE_HZ) as i64 + 3;
        let frames = (-1..count)
            .into_par_iter()
            .map(|k| frame(scene, k1, &kernel, k as f64 / RATE_HZ))
            .collect();
        Self { frames }
    }

    /// Catmull and Rom's cubic through the four frames around `t_s`.
    pub(super) fn log_light(&self, x: usize, y: usize, t_s: f64) -> f64 {
        // The cubic needs one frame before and two behind, so that frames begin one step early.
        let last = (self.frames.len() - 4) as f64;
        let place = (t_s * RATE_HZ).clamp(0.0, last);
        let k = place as usize;
        let f = place - k as f64;
        let value = |i: usize| f64::from(self.frames[k + i][y * WIDTH + x]);
        let (a, b, c, d) = (value(0), value(1), value(2), value(3));
        let bend = 2.0 * a - 5.0 * b + 4.0 * c - d;
        let twist = 3.0 * (b - c) + d - a;
        b + 0.5 * f * (c - a + f * (bend + f * twist))
    }
}

/// Half of the symmetric kernel, middle first, whose sum over both halves is 1.
fn kernel(sigma_px: f64) -> Vec<f64> {
    let variance = sigma_px * sigma_px;
    // Beyond 4.5 standard deviations lies less than 1e-5 of the weight.
    let reach = (4.5 * sigma_px).ceil() as i32 + 1;
    let half: Vec<f64> = (0..=reach).map(|n| (-variance).exp() * bessel_i(n, variance)).collect();
    let total = 2.0 * half.iter().sum::<f64>() - half[0];
    half.into_iter().map(|weight| weight / total).collect()
}

/// Modified Bessel function of the first kind by its power series.
fn bessel_i(order: i32, x: f64) -> f64 {
    let mut term = (1..=order).fold(1.0, |product, k| product * 0.5 * x / f64::from(k));
    let mut sum = term;
    for k in 1..200 {
        term *= 0.25 * x * x / (f64::from(k) * f64::from(k + order));
        sum += term;
        if term < 1e-17 * sum {
            break;
        }
    }
    sum
}

fn frame(scene: &Scene, k1: f64, kernel: &[f64], t_s: f64) -> Vec<f32> {
    let margin = kernel.len() - 1;
    let (wide, high) = (WIDTH + 2 * margin, HEIGHT + 2 * margin);
    let place = |i: usize| i as f64 - margin as f64;
    let mut across = vec![0.0; WIDTH * high];
    let mut line = vec![0.0; wide];
    for row in 0..high {
        for (x, value) in line.iter_mut().enumerate() {
            // A lens blurs light, not its logarithm.
            *value = log_scene(scene, k1, place(x), place(row), t_s).exp();
        }
        // A Gaussian is separable.
        for x in 0..WIDTH {
            across[row * WIDTH + x] = weigh(kernel, |n| line[(x + margin).wrapping_add_signed(n)]);
        }
    }
    (0..WIDTH * HEIGHT)
        .map(|i| {
            let (x, y) = (i % WIDTH, i / WIDTH + margin);
            weigh(kernel, |n| across[y.wrapping_add_signed(n) * WIDTH + x]).ln() as f32
        })
        .collect()
}

fn weigh(kernel: &[f64], value: impl Fn(isize) -> f64) -> f64 {
    let sides = kernel.iter().enumerate().skip(1);
    sides.fold(kernel[0] * value(0), |sum, (n, weight)| {
        sum + weight * (value(n as isize) + value(-(n as isize)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_has_the_variance_it_was_asked_for() {
        for sigma_px in [0.3_f64, 0.7, 1.4, 2.5] {
            let kernel = kernel(sigma_px);
            let variance: f64 =
                kernel.iter().enumerate().map(|(n, w)| 2.0 * w * (n * n) as f64).sum();
            assert!((variance - sigma_px * sigma_px).abs() < 1e-3 * variance, "{sigma_px}");
        }
    }

    #[test]
    fn a_sine_loses_the_share_that_the_gaussian_says() {
        let (sigma_px, turns_per_px) = (1.4_f64, 0.05);
        let k = std::f64::consts::TAU * turns_per_px;
        let left = weigh(&kernel(sigma_px), |n| (k * n as f64).cos());
        let variance = sigma_px * sigma_px;
        // exp(-s (1 - cos k)) for the discrete Gaussian; exp(-s k^2 / 2) for the continuous one.
        assert!((left - (-variance * (1.0 - k.cos())).exp()).abs() < 1e-5);
        assert!((left - (-0.5 * variance * k * k).exp()).abs() < 1e-3);
    }
}

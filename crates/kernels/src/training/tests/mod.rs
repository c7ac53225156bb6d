//! Every operation against plain loops in double precision, over odd shapes, on every level.

mod conv;
mod depthwise;
mod norm;
mod resample;
mod threads;

use super::*;
use crate::blocked::tests::{activated, activations, random_values as noise};

fn double(values: &[f32]) -> Vec<f64> {
    values.iter().map(|value| f64::from(*value)).collect()
}

fn absolute(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| value.abs()).collect()
}

/// The largest error, relative to the largest sum of products that do not cancel.
fn relative_error(ours: &[f32], truth: &[f64], magnitude: &[f64]) -> f64 {
    assert_eq!(ours.len(), truth.len());
    let pairs = ours.iter().zip(truth);
    let error = pairs.map(|(ours, truth)| (f64::from(*ours) - truth).abs()).fold(0.0, f64::max);
    error / magnitude.iter().fold(1e-3, |a, b| f64::max(a, *b))
}

/// Statistics and parameters of a normalisation.
struct ReferenceNorm {
    mean: Vec<f32>,
    variance: Vec<f32>,
    gamma: Vec<f32>,
    beta: Vec<f32>,
    activation: Activation,
}

const EPSILON: f32 = 1e-5;

impl ReferenceNorm {
    fn random(channels: usize, seed: u64, activation: Activation) -> Self {
        let [mean, gamma, beta] = [1, 2, 3].map(|k| noise(seed ^ k, channels));
        let variance = noise(seed ^ 4, channels).iter().map(|v| 1.0 + 0.5 * v).collect();
        Self { mean, variance, gamma, beta, activation }
    }

    fn norm(&self) -> Norm {
        let statistics = Statistics { mean: self.mean.clone(), variance: self.variance.clone() };
        Norm::new(&statistics, &self.gamma, &self.beta, EPSILON, self.activation)
    }

    /// Mean, `1 / sqrt(variance + ε)`, gamma and beta.
    fn channel(&self, channel: usize) -> [f64; 4] {
        let [m, v, g, b] = [&self.mean, &self.variance, &self.gamma, &self.beta]
            .map(|values| f64::from(values[channel]));
        [m, 1.0 / (v + f64::from(EPSILON)).sqrt(), g, b]
    }

    /// The normalised value, before the activation.
    fn value(&self, x: f64, channel: usize) -> f64 {
        let [mean, inverse, gamma, beta] = self.channel(channel);
        gamma * (x - mean) * inverse + beta
    }

    /// The size of the terms that are summed to a value.
    fn magnitude(&self, x: f64, channel: usize) -> f64 {
        let [mean, inverse, gamma, beta] = self.channel(channel);
        gamma.abs() * (x.abs() + mean.abs()) * inverse + beta.abs()
    }

    /// The input of an operation after the normalisation, and the size of its terms.
    fn apply(norm: Option<&Self>, x: &[f32], shape: &Blocks) -> [Vec<f64>; 2] {
        let x = double(x);
        let Some(norm) = norm else { return [x.clone(), absolute(&x)] };
        let channel = |k: usize| k / (shape.height * shape.width) % shape.channels;
        let values = x.iter().enumerate();
        let taken =
            values.clone().map(|(k, x)| activated(norm.value(*x, channel(k)), norm.activation));
        let terms = values.map(|(k, x)| norm.magnitude(*x, channel(k)));
        [taken.collect(), terms.collect()]
    }
}

/// Whether the lanes that pad the last block are zero.
fn is_zero_padded(shape: &Blocks, values: &[f32]) -> bool {
    shape.from_planes(&shape.to_planes(values)) == values
}

/// The shape of a padded, strided convolution over planes.
#[derive(Clone, Copy)]
struct Window {
    input: Blocks,
    output: Blocks,
    kernel: usize,
    stride: usize,
}

impl Window {
    /// Calls `each` with the indices of output pixel, input pixel and tap of every product within a
    /// channel plane.
    fn products(&self, mut each: impl FnMut(usize, usize, usize)) {
        let (from, to, k) = (self.input, self.output, self.kernel);
        for (y, x) in (0..to.height).flat_map(|y| (0..to.width).map(move |x| (y, x))) {
            for (ky, kx) in (0..k).flat_map(|ky| (0..k).map(move |kx| (ky, kx))) {
                let at = |o: usize, tap: usize| (o * self.stride + tap).checked_sub(k / 2);
                let (Some(iy), Some(ix)) = (at(y, ky), at(x, kx)) else { continue };
                if iy < from.height && ix < from.width {
                    each(y * to.width + x, iy * from.width + ix, ky * k + kx);
                }
            }
        }
    }
}

//! Batch normalisation by the statistics of the batch.
//!
//! # Model
//! Per channel, with mean `m` and biased variance `v` over batch and pixels and `n = (x - m) /
//! sqrt(v + ε)`: `y = γ n + β`, then `max(y, 0)` where a ReLU follows. The gradient by the input
//! is `γ / sqrt(v + ε) (dy - mean(dy) - n mean(dy n))`.
//!
//! # Source
//! Ioffe, Szegedy: *Batch Normalization*, ICML 2015.

use rayon::prelude::*;

/// Sums held at a time in an inner loop, so that it runs on vectors.
const LANES: usize = 16;

/// Shape of a batch normalisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchNorm {
    /// Channels.
    pub channels: usize,
    /// Pixels of a channel.
    pub pixels: usize,
    /// Added to the variance.
    pub epsilon: f32,
    /// Whether negative outputs become zero.
    pub relu: bool,
}

/// Per channel: mean and biased variance.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    /// `[channels]`
    pub mean: Vec<f32>,
    /// `[channels]`
    pub variance: Vec<f32>,
}

/// What [`BatchNorm::backward`] gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradients {
    /// As the input.
    pub input: Vec<f32>,
    /// `[channels]`
    pub gamma: Vec<f32>,
    /// `[channels]`
    pub beta: Vec<f32>,
}

impl BatchNorm {
    /// The normalised `input` and the statistics it was normalised by.
    ///
    /// # Shapes
    /// - `input`, output: `[batch, channels, pixels]`
    /// - `gamma`, `beta`: `[channels]`
    pub fn forward(&self, input: &[f32], gamma: &[f32], beta: &[f32]) -> (Vec<f32>, Statistics) {
        self.check(input.len(), gamma, beta);
        let statistics = self.statistics(input);
        let lines = self.lines(&statistics, gamma, beta);
        let mut output = vec![0.0; input.len()];
        self.images(&mut output).zip(input.par_chunks(self.image())).for_each(|(to, from)| {
            for (channel, &(scale, offset)) in lines.iter().enumerate() {
                let from = &from[self.range(channel)];
                let to = to[self.range(channel)].iter_mut().zip(from);
                if self.relu {
                    to.for_each(|(y, x)| {
                        let value = scale * x + offset;
                        // Not `max`, which would turn NaN into zero.
                        *y = if value < 0.0 { 0.0 } else { value };
                    });
                } else {
                    to.for_each(|(y, x)| *y = scale * x + offset);
                }
            }
        });
        (output, statistics)
    }

    /// The gradients, from the gradient by the output. Shapes as in [`forward`](Self::forward).
    pub fn backward(
        &self,
        input: &[f32],
        gamma: &[f32],
        beta: &[f32],
        statistics: &Statistics,
        gradient: &[f32],
    ) -> Gradients {
        self.check(input.len(), gamma, beta);
        assert_eq!(input.len(), gradient.len(), "length of the gradient");
        let lines = self.lines(statistics, gamma, beta);
        let count = (input.len() / self.channels.max(1)).max(1) as f64;
        let sums = (0..self.channels).into_par_iter().map(|channel| {
            let (scale, offset) = lines[channel];
            let mean = statistics.mean[channel];
            let inputs = input.chunks_exact(self.image()).map(|image| &image[self.range(channel)]);
            let gradients = gradient.chunks_exact(self.image());
            let (mut plain, mut centred) = (0.0, 0.0);
            for (xs, image) in inputs.zip(gradients) {
                let dys = &image[self.range(channel)];
                let sums = sum2(xs, dys, |x, dy| {
                    let dy = if self.relu && scale * x + offset <= 0.0 { 0.0 } else { dy };
                    (dy, dy * (x - mean))
                });
                plain += sums.0;
                centred += sums.1;
            }
            (plain, centred)
        });
        let sums: Vec<(f64, f64)> = sums.collect();
        let inverse =
            |channel: usize| 1.0 / f64::from(statistics.variance[channel] + self.epsilon).sqrt();
        // The gradient by the input is `a dy + b x + c`.
        let planes: Vec<[f32; 3]> = (0..self.channels)
            .map(|channel| {
                let (plain, centred) = sums[channel];
                let inverse = inverse(channel);
                let a = f64::from(gamma[channel]) * inverse;
                let b = -a * inverse * inverse * centred / count;
                let c = -a * plain / count - b * f64::from(statistics.mean[channel]);
                [a as f32, b as f32, c as f32]
            })
            .collect();
        let mut result = vec![0.0; input.len()];
        let sources = input.par_chunks(self.image()).zip(gradient.par_chunks(self.image()));
        self.images(&mut result).zip(sources).for_each(|(to, (xs, dys))| {
            for (channel, &[a, b, c]) in planes.iter().enumerate() {
                let range = self.range(channel);
                let (scale, offset) = lines[channel];
                let sources = xs[range.clone()].iter().zip(&dys[range.clone()]);
                let to = to[range].iter_mut().zip(sources);
                if self.relu {
                    to.for_each(|(dx, (&x, &dy))| {
                        let dy = if scale * x + offset <= 0.0 { 0.0 } else { dy };
                        *dx = a * dy + (b * x + c);
                    });
                } else {
                    to.for_each(|(dx, (&x, &dy))| *dx = a * dy + (b * x + c));
                }
            }
        });
        let gamma = sums.iter().enumerate().map(|(channel, sum)| (sum.1 * inverse(channel)) as f32);
        Gradients {
            input: result,
            gamma: gamma.collect(),
            beta: sums.iter().map(|sum| sum.0 as f32).collect(),
        }
    }

    fn statistics(&self, input: &[f32]) -> Statistics {
        let count = (input.len() / self.channels.max(1)).max(1) as f64;
        let of = |channel: usize| {
            let planes =
                || input.chunks_exact(self.image()).map(|image| &image[self.range(channel)]);
            let mean = planes().map(|xs| sum2(xs, xs, |x, _| (x, 0.0)).0).sum::<f64>() / count;
            let mean = mean as f32;
            let square = planes().map(|xs| sum2(xs, xs, |x, _| ((x - mean) * (x - mean), 0.0)).0);
            (mean, (square.sum::<f64>() / count) as f32)
        };
        let (mean, variance) = (0..self.channels).into_par_iter().map(of).unzip();
        Statistics { mean, variance }
    }

    /// Per channel, `(scale, offset)` with `y = scale x + offset`.
    fn lines(&self, statistics: &Statistics, gamma: &[f32], beta: &[f32]) -> Vec<(f32, f32)> {
        let numbers = statistics.mean.iter().zip(&statistics.variance).zip(gamma.iter().zip(beta));
        let line = |((mean, variance), (gamma, beta)): ((&f32, &f32), (&f32, &f32))| {
            let scale = gamma / (variance + self.epsilon).sqrt();
            (scale, beta - scale * mean)
        };
        numbers.map(line).collect()
    }

    fn image(&self) -> usize {
        (self.channels * self.pixels).max(1)
    }

    fn range(&self, channel: usize) -> std::ops::Range<usize> {
        channel * self.pixels..(channel + 1) * self.pixels
    }

    fn images<'a>(&self, data: &'a mut [f32]) -> rayon::slice::ChunksMut<'a, f32> {
        data.par_chunks_mut(self.image())
    }

    fn check(&self, input: usize, gamma: &[f32], beta: &[f32]) {
        assert_eq!(input % self.image(), 0, "length of the input");
        assert!(gamma.len() == self.channels && beta.len() == self.channels, "numbers per channel");
    }
}

/// The sums of both results of `term` over pairs, in an order that depends on the length alone.
fn sum2(xs: &[f32], ys: &[f32], term: impl Fn(f32, f32) -> (f32, f32)) -> (f64, f64) {
    let (mut first, mut second) = ([0.0_f32; LANES], [0.0_f32; LANES]);
    let (x_blocks, x_rest) = xs.as_chunks::<LANES>();
    let (y_blocks, y_rest) = ys.as_chunks::<LANES>();
    for (xs, ys) in x_blocks.iter().zip(y_blocks) {
        for lane in 0..LANES {
            let (a, b) = term(xs[lane], ys[lane]);
            first[lane] += a;
            second[lane] += b;
        }
    }
    for (lane, (x, y)) in x_rest.iter().zip(y_rest).enumerate() {
        let (a, b) = term(*x, *y);
        first[lane] += a;
        second[lane] += b;
    }
    let total = |lanes: [f32; LANES]| lanes.iter().map(|&lane| f64::from(lane)).sum();
    (total(first), total(second))
}

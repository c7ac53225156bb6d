//! Batch normalisation by the statistics of the batch.
//!
//! # Model
//! Per channel, with mean `m` and biased variance `v` over batch and pixels and `n = (x - m) /
//! sqrt(v + ε)`: `y = γ n + β`, then the activation. The gradient by the input
//! is `γ / sqrt(v + ε) (dy - mean(dy) - n mean(dy n))`.
//!
//! # Source
//! Ioffe, Szegedy: *Batch Normalization*, ICML 2015.

mod planes;
mod sums;

use pulp::Arch;
use rayon::prelude::*;

use planes::{GradientByInput, GradientSums, Line, MeanAndVariance, Normalise};

/// Shape of a batch normalisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchNorm {
    /// Channels.
    pub channels: usize,
    /// Pixels of a channel.
    pub pixels: usize,
    /// Added to the variance.
    pub epsilon: f32,
    /// What becomes of the result.
    pub activation: Activation,
}

/// What follows a normalisation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activation {
    /// Nothing.
    Identity,
    /// Negative values become 0.
    Relu,
    /// As [`Relu`](Self::Relu), and values beyond 6 become 6.
    Relu6,
}

impl Activation {
    /// The values between which the result is left as it is.
    pub(crate) fn bounds(self) -> [f32; 2] {
        match self {
            Self::Identity => [f32::NEG_INFINITY, f32::INFINITY],
            Self::Relu => [0.0, f32::INFINITY],
            Self::Relu6 => [0.0, 6.0],
        }
    }
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
            Arch::new().dispatch(Normalise { pixels: self.pixels.max(1), lines: &lines, from, to });
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
            Arch::new().dispatch(GradientSums {
                image: self.image(),
                range: self.range(channel),
                line: lines[channel],
                mean: statistics.mean[channel],
                input,
                gradient,
            })
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
            let (pixels, lines, planes) = (self.pixels.max(1), &lines[..], &planes[..]);
            Arch::new().dispatch(GradientByInput { pixels, lines, planes, xs, dys, to });
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
            let (image, range) = (self.image(), self.range(channel));
            Arch::new().dispatch(MeanAndVariance { image, range, count, input })
        };
        let (mean, variance) = (0..self.channels).into_par_iter().map(of).unzip();
        Statistics { mean, variance }
    }

    /// What becomes of the numbers of each channel.
    fn lines(&self, statistics: &Statistics, gamma: &[f32], beta: &[f32]) -> Vec<Line> {
        let [least, most] = self.activation.bounds();
        let numbers = statistics.mean.iter().zip(&statistics.variance).zip(gamma.iter().zip(beta));
        let line = |((mean, variance), (gamma, beta)): ((&f32, &f32), (&f32, &f32))| {
            let scale = gamma / (variance + self.epsilon).sqrt();
            Line { scale, offset: beta - scale * mean, least, most }
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

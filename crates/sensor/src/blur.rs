//! Convolution of an image with a Gaussian.
//!
//! # Model
//! The Gaussian is sampled at pixel centres out to 3 σ and normalised, and applied along rows and
//! then along columns; the border pixel goes on outside the image.

use evpose_core::SensorSize;

/// A Gaussian.
#[derive(Debug)]
pub(crate) struct Gaussian {
    /// Weights at distances 0, 1, 2, … pixels; both sides together sum to one.
    weights: Vec<f32>,
}

impl Gaussian {
    /// Of standard deviation `sigma_px`.
    pub(crate) fn new(sigma_px: f64) -> Self {
        let radius = (3.0 * sigma_px).ceil() as usize;
        let raw: Vec<f64> =
            (0..=radius).map(|k| (-0.5 * (k as f64 / sigma_px).powi(2)).exp()).collect();
        let sum = 2.0 * raw.iter().skip(1).sum::<f64>() + 1.0;
        // A vanishing width leaves 0/0 at the centre, whose weight is one by definition.
        let centre = std::iter::once(1.0 / sum);
        let sides = raw.iter().skip(1).map(|w| w / sum);
        Self { weights: centre.chain(sides).map(|w| w as f32).collect() }
    }

    /// Whether it spreads nothing.
    pub(crate) fn is_point(&self) -> bool {
        self.weights.len() == 1
    }

    /// Convolves `image`, along rows and then along columns.
    pub(crate) fn blur(&self, size: SensorSize, image: &mut [f32], work: &mut [f32]) {
        let (width, height) = (usize::from(size.width), usize::from(size.height));
        let rows = Line { starts: (0..width * height).step_by(width), stride: 1, length: width };
        let columns = Line { starts: (0..width).step_by(1), stride: width, length: height };
        self.along(image, work, rows);
        self.along(work, image, columns);
    }

    /// Convolves lines of `length` values `stride` apart; line `i` begins at `first(i)`.
    fn along(&self, source: &[f32], target: &mut [f32], line: Line) {
        let last = line.length - 1;
        for first in line.starts {
            for k in 0..line.length {
                let at = |position: usize| source[first + position * line.stride];
                let mut sum = self.weights[0] * at(k);
                for (distance, weight) in self.weights.iter().enumerate().skip(1) {
                    sum += weight * (at(k.saturating_sub(distance)) + at((k + distance).min(last)));
                }
                target[first + k * line.stride] = sum;
            }
        }
    }
}

/// The rows or the columns of an image.
struct Line {
    starts: std::iter::StepBy<std::ops::Range<usize>>,
    stride: usize,
    length: usize,
}

//! Convolution of an image with a Gaussian.
//!
//! # Model
//! The Gaussian is sampled at pixel centres out to 3 σ and normalised, and applied along rows and
//! then along columns; the border pixel goes on outside the image.

use evpose_core::SensorSize;

use evpose_cpu::vectorize;

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

    /// Convolves `image`, along rows and then along columns; `work` is as large.
    pub(crate) fn blur(&self, size: SensorSize, image: &mut [f32], work: &mut [f32]) {
        let width = usize::from(size.width);
        let reach = self.weights.len() - 1;
        // Edge values are repeated: light does not fall off at the border of the sensor.
        let mut padded = vec![0.0; width + 2 * reach];
        vectorize(
            #[inline(always)]
            || {
                for (row, target) in image.chunks_exact(width).zip(work.chunks_exact_mut(width)) {
                    padded[..reach].fill(row[0]);
                    padded[reach..reach + width].copy_from_slice(row);
                    padded[reach + width..].fill(row[width - 1]);
                    self.sum(target, |offset| {
                        &padded[reach.wrapping_add_signed(offset)..][..width]
                    });
                }
                let last = image.len() / width - 1;
                // Along columns whole rows are summed, so that memory is read in order.
                for (y, target) in image.chunks_exact_mut(width).enumerate() {
                    self.sum(target, |offset| {
                        let y = y.saturating_add_signed(offset).min(last);
                        &work[y * width..][..width]
                    });
                }
            },
        );
    }

    /// The weighted sum of a row and of those at every distance to both sides of it.
    #[inline(always)]
    fn sum<'a>(&self, target: &mut [f32], row: impl Fn(isize) -> &'a [f32]) {
        for (t, v) in target.iter_mut().zip(row(0)) {
            *t = self.weights[0] * *v;
        }
        // Symmetric weights: both sides share a multiplication.
        for (distance, weight) in self.weights.iter().enumerate().skip(1) {
            let (before, after) = (row(-(distance as isize)), row(distance as isize));
            for ((t, b), a) in target.iter_mut().zip(before).zip(after) {
                *t += weight * (b + a);
            }
        }
    }
}

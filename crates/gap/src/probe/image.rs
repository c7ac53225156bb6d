//! Images of signed event counts, smoothing and gradients. Outside the image, counts are zero.

/// Binomial weights, close to a Gaussian whose standard deviation is one spacing.
const WEIGHTS: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];

/// Values of pixels, row by row.
#[derive(Debug, Clone)]
pub(super) struct Image {
    pub(super) width: usize,
    pub(super) data: Vec<f32>,
}

impl Image {
    pub(super) fn zeros(width: usize, height: usize) -> Self {
        Self { width, data: vec![0.0; width * height] }
    }

    pub(super) fn height(&self) -> usize {
        self.data.len() / self.width
    }

    /// Smooths with a standard deviation of `spacing` pixels.
    pub(super) fn smoothed(&self, spacing: usize) -> Self {
        let (width, height) = (self.width, self.height());
        // Five weights, `spacing` pixels apart, reach this far to both sides.
        let edge = 2 * spacing;
        let mut padded = vec![0.0; width + 2 * edge];
        let mut along = Self::zeros(width, height);
        for (out, row) in along.data.chunks_exact_mut(width).zip(self.data.chunks_exact(width)) {
            padded[edge..edge + width].copy_from_slice(row);
            for (k, weight) in WEIGHTS.iter().enumerate() {
                let shifted = &padded[k * spacing..k * spacing + width];
                out.iter_mut().zip(shifted).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        let mut both = Self::zeros(width, height);
        for (y, out) in both.data.chunks_exact_mut(width).enumerate() {
            for (k, weight) in WEIGHTS.iter().enumerate() {
                // Outside of the image all is zero.
                let Some(from) = (y + k * spacing).checked_sub(edge) else { continue };
                let Some(row) = along.data.get(from * width..(from + 1) * width) else { break };
                out.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        both
    }

    /// Central differences along the row and the column, at a pixel that is not at the border.
    pub(super) fn gradient(&self, at: usize) -> (f32, f32) {
        let across = self.data[at + 1] - self.data[at - 1];
        let down = self.data[at + self.width] - self.data[at - self.width];
        (0.5 * across, 0.5 * down)
    }
}

/// Dot product over the common length of two slices, with eight independent accumulators.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f64 {
    const LANES: usize = 8;
    let length = a.len().min(b.len());
    let (a, b) = (a[..length].chunks(LANES * 64), b[..length].chunks(LANES * 64));
    let parts = a.zip(b).map(|(a, b)| {
        // Short sums in single precision, added up in double: fast, and exact enough for large
        // images.
        let mut lanes = [0.0_f32; LANES];
        let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
        let rest = a.remainder().iter().zip(b.remainder());
        let rest: f32 = rest.map(|(a, b)| a * b).sum();
        for (a, b) in a.zip(b) {
            lanes.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
        }
        f64::from(lanes.iter().sum::<f32>() + rest)
    });
    parts.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_keeps_the_sum_and_adds_the_variance_of_its_weights() {
        let mut image = Image::zeros(31, 23);
        image.data[11 * 31 + 15] = 1.0;
        for spacing in [1, 2] {
            let smooth = image.smoothed(spacing);
            let moment = |value: &dyn Fn(f64, f64) -> f64| -> f64 {
                let terms = smooth.data.iter().enumerate().map(|(i, v)| {
                    f64::from(*v) * value((i % 31) as f64 - 15.0, (i / 31) as f64 - 11.0)
                });
                terms.sum()
            };
            assert!((moment(&|_, _| 1.0) - 1.0).abs() < 1e-6);
            let variance = (spacing * spacing) as f64;
            assert!((moment(&|x, _| x * x) - variance).abs() < 1e-5);
            assert!((moment(&|_, y| y * y) - variance).abs() < 1e-5);
        }
    }

    #[test]
    fn a_sum_of_products_is_over_what_both_have() {
        let a: Vec<f32> = (0..1_003).map(|i| (i % 7) as f32).collect();
        let b: Vec<f32> = (0..1_001).map(|i| (i % 5) as f32).collect();
        let plain: f32 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        assert_eq!(dot(&a, &b), f64::from(plain));
        assert_eq!(dot(&a, &[]), 0.0);
    }

    #[test]
    fn the_gradient_of_a_plane_is_its_slope() {
        let mut image = Image::zeros(5, 4);
        image.data.iter_mut().enumerate().for_each(|(i, v)| {
            *v = 2.0 * (i % 5) as f32 - 3.0 * (i / 5) as f32;
        });
        assert_eq!(image.gradient(5 + 2), (2.0, -3.0));
    }
}

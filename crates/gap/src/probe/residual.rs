//! Residuals of event counts per pixel against the reference, and their correlations.
//!
//! # Model
//! The residual of a pixel is `sqrt(n + 3/8) - sqrt(g e + 3/8)` (Anscombe 1948) of its count `n`
//! and that of the reference `e`, with one gain `g` for all pixels. Its variance is 1/4 for
//! independent events, and nearly zero for events caused by the light alone.

use crate::probe::image::dot;

/// Minimum pixels of a correlation.
const ENOUGH_PIXELS: usize = 50;
/// Prior variance that shrinks correlations of small residuals towards zero: one event more or less
/// in every sixth pixel, by which two simulators differ where light returns to its former level.
const SETTLED: f64 = 0.004;

#[derive(Debug)]
pub(super) struct Residuals(Vec<f32>);

impl Residuals {
    pub(super) fn from_counts(measured: &[f32], expected: &[f32]) -> Self {
        let (mut n, mut e) = (0.0, 0.0);
        for (measured, expected) in measured.iter().zip(expected).filter(|(_, e)| **e > 0.0) {
            n += f64::from(*measured);
            e += f64::from(*expected);
        }
        // Without the overall gain, which other statistics measure: a pattern is what deviates from
        // it.
        let gain = if e > 0.0 { (n / e).clamp(0.2, 5.0) as f32 } else { 1.0 };
        let pairs = measured.iter().zip(expected);
        Self(pairs.map(|(n, e)| (n + 0.375).sqrt() - (gain * e + 0.375).sqrt()).collect())
    }

    /// Mean square over the chosen pixels; the divisor is at least fifty.
    pub(super) fn mean_square(&self, is_chosen: impl Fn(usize) -> bool) -> f64 {
        let (mut n, mut squares) = (0, 0.0);
        for pixel in (0..self.0.len()).filter(|pixel| is_chosen(*pixel)) {
            n += 1;
            squares += f64::from(self.0[pixel] * self.0[pixel]);
        }
        squares / n.max(ENOUGH_PIXELS) as f64
    }

    pub(super) fn centre(&mut self) {
        let mean = self.0.iter().map(|d| f64::from(*d)).sum::<f64>() / self.0.len() as f64;
        self.0.iter_mut().for_each(|d| *d -= mean as f32);
    }

    /// Moran's index of spatial autocorrelation (1950) at a distance along rows and columns, of
    /// centred residuals.
    pub(super) fn moran(&self, width: usize, distance: usize) -> f64 {
        let height = self.0.len() / width;
        if distance >= width || distance >= height {
            return 0.0;
        }
        let along: f64 = self.0.chunks_exact(width).map(|row| dot(row, &row[distance..])).sum();
        let down = dot(&self.0, &self.0[distance * width..]);
        let pairs = height * (width - distance) + (height - distance) * width;
        let per_pair = self.0.len() as f64 / pairs as f64;
        (along + down) * per_pair / (dot(&self.0, &self.0) + SETTLED * self.0.len() as f64)
    }

    /// Logarithms of the variance of sums over rows, and over columns, relative to independent
    /// residuals.
    pub(super) fn line_dispersions(&self, width: usize) -> [f64; 2] {
        let mut columns = vec![0.0; width];
        let mut rows = Vec::with_capacity(self.0.len() / width);
        for row in self.0.chunks_exact(width) {
            rows.push(row.iter().map(|d| f64::from(*d)).sum());
            columns.iter_mut().zip(row).for_each(|(sum, d)| *sum += f64::from(*d));
        }
        // Of independent pixels, the squares of sums and the sum of squares are alike: the log is
        // zero.
        let alone = dot(&self.0, &self.0);
        let settled = SETTLED * self.0.len() as f64;
        [rows, columns].map(|sums: Vec<f64>| {
            let together: f64 = sums.iter().map(|sum| sum * sum).sum();
            ((together + settled) / (alone + settled)).ln()
        })
    }
}

/// Correlation over the chosen pixels; NaN if they are too few.
pub(super) fn correlation(a: &Residuals, b: &Residuals, is_chosen: impl Fn(usize) -> bool) -> f64 {
    let (mut n, mut sums) = (0, [0.0_f64; 5]);
    for pixel in (0..a.0.len()).filter(|pixel| is_chosen(*pixel)) {
        let (a, b) = (f64::from(a.0[pixel]), f64::from(b.0[pixel]));
        n += 1;
        for (sum, term) in sums.iter_mut().zip([a, b, a * a, b * b, a * b]) {
            *sum += term;
        }
    }
    if n < ENOUGH_PIXELS {
        return f64::NAN;
    }
    let [a, b, aa, bb, ab] = sums;
    let n = n as f64;
    // The constant keeps a correlation of next to nothing from being one of all.
    let scale = (aa - a * a / n + SETTLED * n) * (bb - b * b / n + SETTLED * n);
    (ab - a * b / n) / scale.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn residuals(value: impl Fn(usize, usize) -> f32) -> Residuals {
        Residuals((0..60 * 40).map(|p| value(p % 60, p / 60)).collect())
    }

    #[test]
    fn a_gain_of_all_pixels_leaves_nothing() {
        let expected: Vec<f32> = (0..100).map(|i| (i % 5) as f32).collect();
        let measured: Vec<f32> = expected.iter().map(|e| 2.0 * e).collect();
        assert!(Residuals::from_counts(&measured, &expected).0.iter().all(|d| d.abs() < 1e-6));
    }

    #[test]
    fn correlation_is_one_for_equal_and_minus_one_for_opposite_residuals() {
        let a = residuals(|x, y| ((x * 7 + y * 13) % 11) as f32);
        let b = residuals(|x, y| 3.0 - 2.0 * ((x * 7 + y * 13) % 11) as f32);
        assert!((correlation(&a, &a, |_| true) - 1.0).abs() < 0.01);
        assert!((correlation(&a, &b, |_| true) + 1.0).abs() < 0.01);
        assert!(correlation(&a, &b, |p| p < 49).is_nan());
    }

    #[test]
    fn residuals_of_few_events_say_nothing() {
        let one = residuals(|x, y| f32::from(u8::from((x, y) == (5, 5))) * 0.56);
        assert!(correlation(&one, &one, |_| true) < 0.07);
        assert!(one.line_dispersions(60).map(f64::abs).iter().all(|d| *d < 0.01));
    }

    #[test]
    fn columns_that_alternate_are_alike_at_even_distances() {
        let columns = residuals(|x, _| if x % 2 == 0 { 1.0 } else { -1.0 });
        // Along rows and down columns, half of the pairs each.
        assert!(columns.moran(60, 1).abs() < 0.02, "{}", columns.moran(60, 1));
        assert!((columns.moran(60, 2) - 1.0).abs() < 0.02);
        let [rows, columns] = columns.line_dispersions(60);
        assert!(rows < -5.0 && (columns - 40_f64.ln()).abs() < 0.01, "{rows} {columns}");
    }
}

//! Smoothing by polynomials.
//!
//! # Model
//! Each value becomes that of the polynomial of least squares through the values of a window around
//! it. Nearer to an end than half of a window, it becomes that of the polynomial through the first
//! or the last window. Polynomials that are orthonormal over the window make this a projection
//! without any system of equations.
//!
//! # Source
//! Savitzky and Golay, *Smoothing and differentiation of data by simplified least squares
//! procedures*, Analytical Chemistry 36(8), 1964; the ends as SciPy's `savgol_filter` with
//! `mode='interp'`.

use crate::PoseError;

/// A filter for evenly spaced values.
#[derive(Debug, Clone, PartialEq)]
pub struct SavitzkyGolay {
    /// Orthonormal polynomials of the degrees 0, 1, … at the places of the window.
    basis: Vec<Vec<f64>>,
    /// Weights of the window for the value in its middle.
    middle: Vec<f64>,
}

impl SavitzkyGolay {
    /// A filter with windows of an odd number of values and polynomials of a lower degree.
    ///
    /// # Errors
    /// If the window is even, or the degree too high for it.
    pub fn new(window: usize, degree: usize) -> Result<Self, PoseError> {
        let out_of = |field, value: usize, rule| {
            Err(PoseError::OutOfRange { field, value: value as f64, rule })
        };
        if window.is_multiple_of(2) {
            return out_of("window", window, "odd");
        }
        if degree >= window {
            return out_of("degree", degree, "below the length of the window");
        }
        let basis = orthonormal(window, degree);
        let middle = (0..window).map(|i| basis.iter().map(|p| p[window / 2] * p[i]).sum());
        Ok(Self { middle: middle.collect(), basis })
    }

    /// Values in a window.
    pub fn window(&self) -> usize {
        self.middle.len()
    }

    /// Smooths values; none if there are fewer than in a window.
    pub fn smoothed(&self, values: &[f64]) -> Option<Vec<f64>> {
        let (length, half) = (self.window(), self.window() / 2);
        let begin = self.fitted(values.get(..length)?);
        let end = self.fitted(&values[values.len() - length..]);
        let inside = values.windows(length).map(|window| dot(&self.middle, window));
        Some([&begin[..half], &inside.collect::<Vec<_>>(), &end[half + 1..]].concat())
    }

    /// The polynomial of least squares through a window, at all its places.
    fn fitted(&self, window: &[f64]) -> Vec<f64> {
        let mut fitted = vec![0.0; window.len()];
        for polynomial in &self.basis {
            let share = dot(polynomial, window);
            for (value, p) in fitted.iter_mut().zip(polynomial) {
                *value += share * p;
            }
        }
        fitted
    }
}

/// Polynomials of the degrees 0 to `degree`, orthonormal over `window` even places from -1 to 1.
fn orthonormal(window: usize, degree: usize) -> Vec<Vec<f64>> {
    let half = (window / 2) as f64;
    let place = |i: usize| if window > 1 { (i as f64 - half) / half } else { 0.0 };
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(degree + 1);
    for _ in 0..=degree {
        // A polynomial of the next degree, less its shares of those before.
        let mut next: Vec<f64> = match basis.last() {
            Some(last) => last.iter().enumerate().map(|(i, p)| place(i) * p).collect(),
            None => vec![1.0; window],
        };
        for before in &basis {
            let share = dot(before, &next);
            next.iter_mut().zip(before).for_each(|(p, b)| *p -= share * b);
        }
        let length = dot(&next, &next).sqrt();
        next.iter_mut().for_each(|p| *p /= length);
        basis.push(next);
    }
    basis
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn near(values: &[f64], want: &[f64], tolerance: f64) {
        assert_eq!(values.len(), want.len());
        for (k, (value, want)) in values.iter().zip(want).enumerate() {
            assert!((value - want).abs() < tolerance, "{k}: {value}, not {want}");
        }
    }

    #[test]
    fn the_weights_of_five_places_are_those_of_the_tables() {
        let filter = SavitzkyGolay::new(5, 2).unwrap();
        near(&filter.middle, &[-3.0, 12.0, 17.0, 12.0, -3.0].map(|w| w / 35.0), 1e-15);
    }

    #[test]
    fn polynomials_of_the_degree_stay_as_they_are_ends_included() {
        let filter = SavitzkyGolay::new(501, 3).unwrap();
        let cubic: Vec<_> = (0..1_200)
            .map(|i| f64::from(i) / 500.0 - 1.0)
            .map(|x| 3.0 * x * x * x - 40.0 * x * x + x + 7.0)
            .collect();
        near(&filter.smoothed(&cubic).unwrap(), &cubic, 1e-10);
        near(&filter.smoothed(&cubic[..501]).unwrap(), &cubic[..501], 1e-10);
    }

    #[test]
    fn settings_and_values_that_do_not_fit_are_refused() {
        assert!(SavitzkyGolay::new(4, 2).is_err() && SavitzkyGolay::new(5, 5).is_err());
        assert!(SavitzkyGolay::new(0, 0).is_err());
        assert_eq!(SavitzkyGolay::new(5, 2).unwrap().smoothed(&[1.0; 4]), None);
        // A window of one value is that value.
        assert_eq!(SavitzkyGolay::new(1, 0).unwrap().smoothed(&[4.0, 5.0]).unwrap(), [4.0, 5.0]);
    }
}

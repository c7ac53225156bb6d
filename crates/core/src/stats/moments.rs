//! First and second moments of samples.

/// Arithmetic mean, summed in order; NaN of an empty sample.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean and standard deviation of a sample, with `n - 1` degrees of freedom; the deviation of one
/// value is zero, both are NaN of an empty sample.
///
/// ```
/// use evpose_core::stats::moments::mean_and_deviation;
///
/// assert_eq!(mean_and_deviation(&[1.0, 2.0, 3.0]), (2.0, 1.0));
/// ```
pub fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let mean = mean(values);
    let degrees = (values.len() as f64 - 1.0).max(1.0);
    (mean, (squared_deviations(values, mean) / degrees).sqrt())
}

/// Standard error of the mean of at least two values, `s / √n`.
pub fn standard_error(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    (squared_deviations(values, mean(values)) / (n - 1.0) / n).sqrt()
}

/// Sum of squared deviations from `mean`.
pub fn squared_deviations(values: &[f64], mean: f64) -> f64 {
    values.iter().map(|value| (value - mean).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_closed_forms() {
        // 1..=n: mean (n + 1) / 2, variance n (n + 1) / 12.
        let values: Vec<f64> = (1..=11).map(f64::from).collect();
        let (mean, deviation) = mean_and_deviation(&values);
        assert_eq!(mean, 6.0);
        assert!((deviation - 11f64.sqrt()).abs() < 1e-12);
        assert!((standard_error(&values) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn one_value_has_no_deviation_and_none_has_no_mean() {
        assert_eq!(mean_and_deviation(&[4.0]), (4.0, 0.0));
        assert!(mean(&[]).is_nan());
    }
}
